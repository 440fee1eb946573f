// The live page: the last 10 s of a run, from the stream of live_server.h. A message is the length of a JSON text in four bytes,
// the text, and the columns of the tables that it describes (packed_table.h).

const kept_us = 10e6;
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
    // A late event counts as of the newest one before it: times do not go back.
    let last = this.rows > 0 ? this.t[this.rows - 1] : 0;
    for (let i = 0; i < count; ++i) this.t[this.rows + i] = last = Math.max(last, part.t[skip + i]);
    for (const column of this.columns.slice(1)) {
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

const page = {head: null, messages: 0, images: 0, events: 0, stops: 0, frozen: false, span: 10e3, eyes: [], plots: [], plotsDue: false, plotsAt: 0, tables: {}, hidden: {},
  version: 0, time: {from: 0, to: kept_us, now: 0}};
window.live = page;  // for tests, and for who is curious

function redraw() {
  page.version += 1;
  page.fresh = true;
}

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
  by("bar").hidden = head.kind === "sweep";
  by("panels").className = head.kind === "sweep" ? "one" : "flat";
  if (head.kind === "sweep") return beginSweep();
  beginRun(head);
}

function beginRun(head) {
  const tables = page.tables = {
    events: new LiveTable(["x", "y", "on"], 1 << 19),
    instants: new LiveTable(["x", "y", "r", "visible", "error", "target_px_x", "target_px_y", "late", "tick", "latency",
      "camera_age", "joints_age", ...head.joints.map((name, i) => "joint_" + i)], 1 << 15),
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
  const simulated = head.kind === "run" || head.kind === "serve";
  addPolarities(legend, head.colours);
  if (simulated) check(page, legend, "truth", "ground truth", head.colours.truth);
  head.detectors.forEach((d) => check(page, legend, "detector " + d.name, d.name, d.colour));
  if (head.principal) check(page, legend, "gaze", "gaze", head.colours.gaze);
  if (simulated) check(page, legend, "target", "gaze target", head.colours.target);

  page.log = page.watchdogs = null;
  if (head.kind === "deploy") beginDeploy(first.parentNode, head);

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
  const shown = (name) => ({shown: () => !page.hidden[name]});
  if (head.kind === "deploy") {
    plot("Ticks", "ms", [series("late", "#d55e00", instants, "late"), series("takes", "#0072b2", instants, "tick"),
      series("event to command", "#009e73", instants, "latency")], {zero: true});
  } else if (simulated) {
    plot("Gaze error", "deg", [series("left eye", head.colours.gaze, instants, "error", shown("gaze"))], {zero: true});
  }
  for (const [axis, i] of [["x", 0], ["y", 1]]) {
    plot("Circle, " + axis, "px", [
      ...head.detectors.map((d) => series(d.name, d.colour, d.table, "shown_" + axis, {dots: true, ...shown("detector " + d.name)})),
      ...(simulated ? [series("ground truth", head.colours.truth, instants, axis, shown("truth"))] : [])
    ], {range: [0, head.size[i]]});
  }
  if (head.joints.length)
    plot("Joints", "deg", head.joints.map((name, i) => series(name.replace(/_/g, " "), jointColours[i % jointColours.length], instants, "joint_" + i)),
      {height: 124});
  plot("Events per ms", "", [series("ON", head.colours.on, tables.rates, "on", {whole: true}),
    series("OFF", head.colours.off, tables.rates, "off", {whole: true})], {zero: true});
}

function beginDeploy(parent, head) {
  const section = element("section", parent);
  element("h2", section, "Watchdogs");
  const holder = element("div", section);
  holder.className = "results";
  page.watchdogs = element("table", holder);
  const heads = element("tr", element("thead", page.watchdogs));
  ["", "now", "most in 10 s", "stops at"].forEach((text) => element("th", heads, text));
  const body = element("tbody", page.watchdogs);
  page.watchdogRows = head.watchdogs.map((watchdog) => {
    const row = element("tr", body);
    element("th", row, watchdog.name);
    const cells = {column: watchdog.column, bound: watchdog.bound, now: element("td", row), most: element("td", row)};
    element("td", row, watchdog.bound + " ms");
    return cells;
  });
  page.counts = element("p", holder);
  const log = element("section", parent);
  element("h2", log, "Log");
  page.log = element("pre", log);
  page.log.id = "lines";
}

function showWatchdogs() {
  const instants = page.tables.instants, begin = rowsUntil(instants, page.time.now - kept_us);
  for (const row of page.watchdogRows) {
    const values = instants[row.column];
    let most = NaN;
    for (let i = begin; i < instants.rows; ++i) if (!(most >= values[i]) && values[i] === values[i]) most = values[i];
    const now = instants.rows ? values[instants.rows - 1] : NaN;
    [[row.now, now], [row.most, most]].forEach(([cell, value]) => {
      cell.textContent = value === value ? value.toFixed(1) + " ms" : "–";
      cell.className = value > row.bound ? "beyond" : "";
    });
  }
  const newest = page.newest;
  page.counts.textContent = [newest.state === "active" ? (newest.guarded ? "the guard watches the head" : "NO GUARD watches the head")
    : "the head is not active", newest.skipped_ticks + " ticks skipped", newest.dropped_events + " events dropped"].join(" · ");
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
  page.pictureHeading = element("h2", section, "Worst runs, again with pictures");
  page.pictures = element("div", section);
  page.pictures.className = "results pictures";
}

function showSweep(head) {
  setState(head.done + head.failed === head.total ? "all runs done" : "running", false);
  page.progress.max = Math.max(1, head.total);
  page.progress.value = head.done + head.failed;
  page.counts.textContent = head.done + " of " + head.total + " done, " + head.failed + " failed, " + head.running + " running";
  page.results.textContent = "";
  const table = element("table", page.results);
  const heads = element("tr", element("thead", table));
  head.columns.forEach((name) => element("th", heads, name));
  const body = element("tbody", table);
  for (const row of head.rows) {
    const line = element("tr", body);
    row.forEach((value) => element("td", line, value === null ? "–" : typeof value === "number" ? String(Number(value.toPrecision(4))) : value));
  }
  page.pictureHeading.hidden = page.pictures.hidden = head.pictures.length === 0;
  page.pictures.textContent = "";
  for (const picture of head.pictures) {
    const figure = element("figure", page.pictures), image = element("img", figure);
    image.alt = "the left eye's events in the middle of the run";
    image.src = "data:image/png;base64," + picture.png;
    element("figcaption", figure, picture.run);
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
  setState(head.state || "running", head.alarm);
  if (head.stops > page.stops) acknowledge();
  page.stops = head.stops;
  page.newest = head;
  if (page.frozen) return;
  for (const name of Object.keys(tables)) {
    const part = tables[name], table = page.tables[name];
    if (!table) continue;
    const number = /^detections_(\d+)$/.exec(name);
    if (number) {
      const detector = {threshold: page.head.detectors[number[1]].threshold, table: part};
      for (const axis of ["x", "y"]) part["shown_" + axis] = aboveThreshold(detector, part[axis]);
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
  redraw();
}

function setState(text, alarm) {
  by("state").textContent = text;
  by("state").className = alarm ? "alarm" : "";
}

// Plots are drawn 10 times per second at most.
function draw(now) {
  if (page.fresh || page.eyes.some((eye) => eye.changed)) {
    page.fresh = false;
    page.images += 1;
    page.plotsDue = true;
    by("time").textContent = (page.time.now * 1e-6).toFixed(2) + " s";
    for (const eye of page.eyes) {
      eye.draw(page.time.now, page.span);
      eye.label.textContent = eye.count + " events in " + page.span / 1e3 + " ms";
    }
  }
  if (page.plotsDue && now - page.plotsAt > 95) {
    page.plotsDue = false;
    page.plotsAt = now;
    for (const plot of page.plots) plot.draw(page.time, page.version);
    if (page.watchdogs && page.newest) showWatchdogs();
  }
  requestAnimationFrame(draw);
}

// The server ends the stream of a run that is over with code 1000.
function connect() {
  const socket = new WebSocket("ws://" + location.host + "/stream" + location.search);
  socket.binaryType = "arraybuffer";
  page.socket = socket;
  socket.onopen = () => {
    setState("starting", false);
    by("stop").disabled = false;
  };
  socket.onmessage = (event) => take(readMessage(event.data));
  socket.onclose = (event) => {
    by("stop").disabled = true;
    if (event.code === 1000) return setState("ended", false);
    setState("no connection", true);
    setTimeout(connect, 2000);
  };
}

function stop() {
  if (page.socket.readyState === WebSocket.OPEN) page.socket.send("stop");
}

function acknowledge() {
  by("stop").textContent = "STOP received";
  clearTimeout(page.acknowledged);
  page.acknowledged = setTimeout(() => { by("stop").textContent = "STOP"; }, 2000);
}

function freeze() {
  page.frozen = !page.frozen;
  by("pause").textContent = page.frozen ? "Go on" : "Freeze";
}

windows.forEach((ms) => { element("option", by("window"), ms + " ms").value = ms; });
by("window").value = "10";
by("window").addEventListener("change", () => {
  page.span = by("window").value * 1e3;
  redraw();
});
by("pause").addEventListener("click", freeze);
by("stop").addEventListener("click", stop);
document.addEventListener("keydown", (event) => {
  if (event.ctrlKey || event.altKey || event.metaKey) return;
  if (event.key === "f") freeze();
  // As in the terminal: wherever the focus is, the space bar stops the head.
  if (event.key !== " " || !page.head || !page.head.can_stop) return;
  event.preventDefault();
  document.activeElement.blur();
  stop();
});
connect();
requestAnimationFrame(draw);
