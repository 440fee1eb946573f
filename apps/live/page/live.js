// The live page: the last 10 s of a run, from the stream of live_server.h. A message is the length of a JSON text in four bytes,
// the text, and the columns of the tables that it describes (packed_table.h).

const kept_us = 10e6;
const windows = [1, 2, 5, 10, 20, 50, 100];  // ms
const by = (id) => document.getElementById(id);

function element(kind, parent, text) {
  const made = document.createElement(kind);
  if (text !== undefined) made.textContent = text;
  if (parent) parent.appendChild(made);
  return made;
}

// The rows of the last while, in columns that never grow: old rows go when there is no room.
class LiveTable {
  constructor(columns, capacity) {
    this.capacity = capacity;
    this.columns = ["t", ...columns];
    this.rows = 0;
    for (const column of this.columns) this[column] = new Float64Array(capacity);
  }
  append(part) {
    const count = Math.min(part.rows, this.capacity), skip = part.rows - count;
    if (this.rows + count > this.capacity) {
      const drop = Math.max(this.rows + count - this.capacity, this.rows >> 1);
      for (const column of this.columns) this[column].copyWithin(0, drop, this.rows);
      this.rows -= Math.min(drop, this.rows);
    }
    for (const column of this.columns) {
      const values = part[column];
      for (let i = 0; i < count; ++i) this[column][this.rows + i] = values ? values[skip + i] : NaN;
    }
    this.rows += count;
  }
}

function readMessage(data) {
  const length = new DataView(data).getUint32(0, true);
  const head = JSON.parse(new TextDecoder().decode(new Uint8Array(data, 4, length)));
  const bytes = new Bytes(new Uint8Array(data, 4 + length));
  const tables = {};
  for (const description of head.tables) {
    const table = {rows: description.rows};
    for (const column of description.columns) table[column.name] = readers[column.kind](bytes, description.rows, column);
    tables[description.name] = table;
  }
  return {head, tables};
}

const page = {head: null, messages: 0, images: 0, events: 0, frozen: false, span: 10e3, eyes: [], plots: [], tables: {}, hidden: {},
  version: 0, time: {from: 0, to: kept_us, now: 0}};
window.live = page;  // for tests, and for who is curious

function begin(head) {
  page.head = head;
  page.eyes = [];
  page.plots = [];
  page.time.now = 0;
  by("title").textContent = head.title;
  document.title = head.title + " – live";
  by("stop").hidden = !head.can_stop;
  by("panels").textContent = "";
  const facts = [head.kind];
  if (head.size) facts.push(head.size.join(" × ") + " pixels");
  if (head.duration) facts.push("of " + head.duration + " s");
  by("facts").textContent = facts.join(" · ");
  for (const id of ["pause", "time"]) by(id).hidden = head.kind === "sweep";
  by("window").parentNode.hidden = head.kind === "sweep";
  if (head.kind === "sweep") return beginSweep();
  beginRun(head);
}

function panel(parent, kind, title) {
  const section = element("section", parent);
  section.className = kind;
  const heading = element("h2", section, title);
  const view = element("div", section);
  view.className = "view";
  return {section, heading, canvas: element("canvas", view)};
}

function beginRun(head) {
  const tables = page.tables = {
    events: new LiveTable(["x", "y", "on"], 1 << 19),
    instants: new LiveTable(["x", "y", "r", "visible", "error", "target_px_x", "target_px_y", "late", "tick", "latency",
      ...head.joints.map((name, i) => "joint_" + i)], 1 << 15),
    rates: new LiveTable(["on", "off"], 2048)
  };
  if (head.both_eyes) tables.events_right = new LiveTable(["x", "y", "on"], 1 << 19);
  head.detectors.forEach((d, i) => {
    d.table = tables["detections_" + i] = new LiveTable(["x", "y", "r", "score", "held", "shown_x", "shown_y"], 1 << 15);
  });
  const panels = by("panels"), holder = element("div", panels);
  holder.className = head.both_eyes ? "stack two" : "stack";
  const add = (title, parts) => {
    const {section, heading, canvas} = panel(holder, "eye", title);
    const view = new EyeView(canvas, head.size, head.colours, parts, (name) => !page.hidden[name]);
    view.label = element("small", heading, "");
    page.eyes.push(view);
    return section;
  };
  const ages = {truth_age: 20e3, detection_age: 20e3};
  const first = add(head.both_eyes ? "Left eye" : "Events", {events: tables.events, truth: tables.instants, gaze: tables.instants,
    detections: head.detectors, principal: head.principal, ...ages});
  if (head.both_eyes) add("Right eye", {events: tables.events_right, detections: []});
  const legend = element("div", first);
  legend.className = "legend";
  const check = (name, text, colour) => {
    const label = element("label", legend), box = element("input", label), dot = element("span", label);
    box.type = "checkbox";
    box.checked = true;
    dot.className = "dot";
    dot.style.background = colour;
    label.append(text);
    box.addEventListener("change", () => { page.hidden[name] = !box.checked; });
  };
  if (head.kind === "run" || head.kind === "serve") check("truth", "ground truth", head.colours.truth);
  head.detectors.forEach((d) => check("detector " + d.name, d.name, d.colour));

  const plots = element("section", panels);
  plots.className = "plots";
  const plot = (title, unit, series, options) => {
    const made = new Plot(title, unit, series, options);
    made.usable = series;
    plots.appendChild(made.canvas);
    page.plots.push(made);
  };
  const instants = tables.instants;
  const series = (name, colour, table, column, more) => Object.assign({name, colour, table, value: (t) => t[column], age: 50e3,
    gap: 100e3}, more);
  if (head.kind === "deploy") {
    plot("Ticks", "ms", [series("late", "#d55e00", instants, "late"), series("length", "#0072b2", instants, "tick"),
      series("latency", "#009e73", instants, "latency")], {zero: true});
  } else {
    plot("Gaze error", "deg", [series("left eye", head.colours.gaze, instants, "error")], {zero: true});
  }
  for (const [axis, i] of [["x", 0], ["y", 1]]) {
    plot("Circle, " + axis, "px", [...head.detectors.map((d) => series(d.name, d.colour, d.table, "shown_" + axis, {dots: true})),
      ...(head.kind === "deploy" || head.kind === "detect" ? [] : [series("ground truth", head.colours.truth, instants, axis)])],
    {range: [0, head.size[i]]});
  }
  const colours = ["#e69f00", "#56b4e9", "#009e73", "#cc79a7", "#0072b2", "#d55e00", "#999933", "#882255", "#888888"];
  if (head.joints.length)
    plot("Joints", "deg", head.joints.map((name, i) => series(name.replace(/_/g, " "), colours[i % colours.length], instants, "joint_" + i)),
      {height: 124});
  plot("Events per ms", "", [series("ON", head.colours.on, tables.rates, "on", {whole: true}),
    series("OFF", head.colours.off, tables.rates, "off", {whole: true})], {zero: true});
  page.log = null;
  if (head.kind !== "deploy") return;
  const log = element("section", panels);
  log.className = "plots";
  element("h2", log, "Log");
  page.log = element("pre", log);
  page.log.id = "lines";
}

function beginSweep() {
  const section = element("section", by("panels"));
  section.className = "plots";
  element("h2", section, "Progress");
  const holder = element("div", section);
  holder.className = "results";
  page.progress = element("progress", holder);
  page.counts = element("p", holder);
  element("h2", section, "Newest results");
  page.results = element("div", section);
  page.results.className = "results";
}

function showSweep(head) {
  page.progress.max = Math.max(1, head.total);
  page.progress.value = head.done + head.failed;
  page.counts.textContent = head.done + " of " + head.total + " done, " + head.failed + " failed, " + head.running + " running" +
    (head.left ? ", " + head.left + " left" : "");
  page.results.textContent = "";
  const table = element("table", page.results);
  const heads = element("tr", element("thead", table));
  head.columns.forEach((name) => element("th", heads, name));
  const body = element("tbody", table);
  for (const row of head.rows) {
    const line = element("tr", body);
    row.forEach((value) => element("td", line, value === null ? "–" : typeof value === "number" ? String(Number(value.toPrecision(4))) : value));
  }
}

function addRates(part) {
  if (!part.rows) return;
  // One row per message: what came in it, over its time.
  const from = part.t[0], to = part.t[part.rows - 1];
  const ms = Math.max(1, (to - from) * 1e-3);
  let on = 0;
  for (let i = 0; i < part.rows; ++i) on += part.on[i];
  page.tables.rates.append({rows: 1, t: [to], on: [on / ms], off: [(part.rows - on) / ms]});
}

function take(message) {
  const {head, tables} = message;
  page.messages += 1;
  if (head.kind) begin(head);
  if (head.columns) return showSweep(head);
  if (!page.head || head.now === undefined) return;
  by("state").textContent = head.state || "running";
  by("state").className = head.alarm ? "alarm" : "";
  if (page.frozen) return;
  for (const name of Object.keys(tables)) {
    const part = tables[name], table = page.tables[name];
    if (!table) continue;
    const number = /^detections_(\d+)$/.exec(name);
    if (number) {
      const threshold = page.head.detectors[number[1]].threshold;
      for (const axis of ["x", "y"]) part["shown_" + axis] = part[axis].map((v, i) => part.score[i] >= threshold ? v : NaN);
    }
    table.append(part);
  }
  if (tables.events) {
    page.events += tables.events.rows;
    addRates(tables.events);
  }
  const text = head.lines.join("\n");
  if (page.log && page.log.textContent !== text) {
    page.log.textContent = text;
    page.log.scrollTop = page.log.scrollHeight;
  }
  by("remark").hidden = !(head.missed > 0);
  by("remark").textContent = "The page has missed " + head.missed + " events or ticks.";
  page.time.now = head.now;
  page.time.to = Math.max(kept_us, head.now);
  page.time.from = page.time.to - kept_us;
  page.version += 1;
  page.fresh = true;
}

function draw() {
  if (page.fresh || page.eyes.some((eye) => eye.changed)) {
    page.fresh = false;
    page.images += 1;
    by("time").textContent = (page.time.now * 1e-6).toFixed(2) + " s";
    for (const eye of page.eyes) {
      eye.draw(page.time.now, page.span);
      eye.label.textContent = eye.count + " events in " + page.span / 1e3 + " ms";
    }
    for (const plot of page.plots) plot.draw(page.time, page.version);
  }
  requestAnimationFrame(draw);
}

function connect() {
  const socket = new WebSocket("ws://" + location.host + "/stream" + location.search);
  socket.binaryType = "arraybuffer";
  page.socket = socket;
  socket.onmessage = (event) => take(readMessage(event.data));
  socket.onclose = () => {
    by("state").textContent = "connection ended";
    by("state").className = "alarm";
    by("stop").disabled = true;
  };
}

function freeze() {
  page.frozen = !page.frozen;
  by("pause").textContent = page.frozen ? "Go on" : "Freeze";
}

windows.forEach((ms) => { element("option", by("window"), ms + " ms").value = ms; });
by("window").value = "10";
by("window").addEventListener("change", () => {
  page.span = by("window").value * 1e3;
  page.fresh = true;
});
by("pause").addEventListener("click", freeze);
by("stop").addEventListener("click", () => page.socket.send("stop"));
document.addEventListener("keydown", (event) => {
  if (event.key !== " " || /^(SELECT|BUTTON|INPUT)$/.test(event.target.tagName)) return;
  freeze();
  event.preventDefault();
});
connect();
requestAnimationFrame(draw);
