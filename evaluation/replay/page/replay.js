// The page: what it shows, the instant it shows, and what the user does.

const speeds = [0.05, 0.1, 0.2, 0.5, 1, 2];
// The instant and the stretch of time that timeline and plots show, us since the start.
class Time {
  constructor(end) {
    this.end = Math.max(1, end);
    this.from = 0;
    this.to = this.end;
    this.now = 0;
    this.changed = true;
  }
  seek(t) {
    this.now = Math.min(this.end, Math.max(0, t));
    this.follow();
    this.changed = true;
  }
  show(from, to) {
    const span = Math.min(this.end, Math.max(2000, to - from));
    this.from = Math.min(this.end - span, Math.max(0, from));
    this.to = this.from + span;
    this.changed = true;
  }
  zoom(factor, about) {
    const at = about === undefined ? this.now : about;
    const span = Math.min(this.end, Math.max(2000, (this.to - this.from) * factor));
    const share = (at - this.from) / (this.to - this.from);
    this.show(at - share * span, at + (1 - share) * span);
  }
  // What is shown goes with the instant.
  follow() {
    const span = this.to - this.from;
    if (this.now < this.from) this.show(this.now - 0.1 * span, this.now + 0.9 * span);
    else if (this.now > this.to - 0.05 * span && this.to < this.end) this.show(this.now - 0.5 * span, this.now + 0.5 * span);
  }
}

async function start() {
  const head = JSON.parse(by("head").textContent);
  if (typeof DecompressionStream === "undefined") throw new Error("this browser has no DecompressionStream: one of 2023 or newer is needed");
  const texts = [...document.querySelectorAll("script.table")];
  const tables = {};
  for (let i = 0; i < head.tables.length; ++i) {
    tables[head.tables[i].name] = await readTable(head.tables[i], texts[i].textContent);
    texts[i].remove();
  }
  const sceneText = by("scene").textContent.trim();
  const time = new Time(head.duration * 1e6);
  const page = {head, tables, time, playing: false, speed: 1, span: 10e3, hidden: {}, version: 0, eyes: [], plots: [], scene: null,
    sceneCost: 0, sceneAt: 0, sceneDrawn: false, images: 0};
  window.replay = page;  // for tests, and for who is curious

  describe(page);
  const panels = by("panels");
  if (sceneText) addScene(page, panels, JSON.parse(new TextDecoder().decode(await inflated(sceneText))));
  else panels.classList.add("flat");
  addEyes(page, panels);
  addPlots(page, panels);
  addControls(page);
  addTimeline(page);
  openLink(page);
  window.addEventListener("hashchange", () => openLink(page));
  window.addEventListener("resize", () => { time.changed = true; });
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => redraw(page));
  requestAnimationFrame((now) => frame(page, now, now));
}

function redraw(page) {
  page.version += 1;
  page.time.changed = true;
}

function describe(page) {
  const head = page.head, facts = [];
  if (head.seed !== undefined) facts.push("seed " + head.seed);
  facts.push(head.duration.toFixed(2) + " s", head.size.join(" × ") + " pixels", head.events.total.toLocaleString("en") + " events");
  if (head.interrupted) facts.push("interrupted: ended before its time");
  by("facts").textContent = facts.join(" · ");
  if (head.report) {
    by("facts").append(" · ");
    element("a", by("facts"), "report").href = "report.html";
  }
  const remarks = [];
  if (head.events.every > 1)
    remarks.push("The page shows one of " + head.events.every + " events: there are more than it can hold.");
  if (head.events_remark) remarks.push("Events are not shown: " + head.events_remark);
  by("remark").textContent = remarks.join(" ");
  by("remark").hidden = remarks.length === 0;
  by("licence").textContent = "This page is made by saccade (BSD-3-Clause)." + (typeof THREE === "undefined" ? "" :
    " The scene is drawn by three.js, © 2010-2019 three.js authors, MIT licence; its text stands in the source of this page.");
}

function addScene(page, parent, scene) {
  const {heading, view, canvas} = panel(parent, "scene", "Scene");
  const choice = element("select");
  choice.id = "view";
  for (const [value, text] of [["overview", "overview"], ["behind", "from behind the robot"], ["front", "from the wall"],
    ["side", "from the side"], ["eye", "through the left eye"]]) element("option", choice, text).value = value;
  const label = element("label", heading, "Seen ");
  label.appendChild(choice);
  try {
    page.scene = new SceneView(canvas, scene, page.head.colours);
  } catch (error) {
    canvas.remove();
    const note = element("p", view, "The scene is not drawn: this browser offers no WebGL (" + error.message + ").");
    note.className = "note";
    return;
  }
  choice.addEventListener("change", () => page.scene.setView(choice.value));
}

function addEyes(page, parent) {
  const {head, tables} = page;
  const two = Boolean(tables.events_right);
  const holder = element("div", parent);
  holder.className = two ? "stack two" : "stack";
  const shown = (name) => !page.hidden[name];
  const withTables = (list) => (list || []).map((d) => Object.assign({}, d, {table: tables[d.table]}));
  // The newest annotation of a recording counts until the next one.
  const sparse = (table) => table && table.rows > 1 && (table.t[table.rows - 1] - table.t[0]) / (table.rows - 1) > 3e3;
  const age = sparse(tables.truth) ? 12e3 : 2e3;
  const add = (title, parts) => {
    const {section, heading, canvas} = panel(holder, "eye", title);
    const count = element("small", heading, "");
    const view = new EyeView(canvas, head.size, head.colours, parts, shown);
    view.label = count;
    page.eyes.push(view);
    return section;
  };
  const first = add(two ? "Left eye" : "Events", {events: tables.events, truth: tables.truth, truth_age: age, detection_age: age,
    detections: withTables(head.detectors), gaze: tables.gaze, principal: tables.eye ? head.principal : null});
  if (two) {
    add("Right eye", {events: tables.events_right, truth: tables.truth_right, detections: withTables(head.right_detectors)});
  }
  const legend = element("div", first);
  legend.className = "legend";
  addPolarities(legend, head.colours);
  if (tables.truth) check(page, legend, "truth", "ground truth", head.colours.truth);
  for (const d of head.detectors) check(page, legend, "detector " + d.name, d.name, d.colour);
  if (tables.eye && head.principal) check(page, legend, "gaze", "gaze", head.colours.gaze);
  if (tables.gaze) check(page, legend, "target", "gaze target", head.colours.target);
}

// Distance of a detector's circles from the truth of the same time.
function positionErrors(table, truth) {
  const errors = new Float64Array(table.rows).fill(NaN);
  for (let i = 0; i < table.rows; ++i) {
    const row = rowAt(truth, table.t[i], 0);
    if (row >= 0 && truth.visible[row] >= 0.5) errors[i] = Math.hypot(table.x[i] - truth.x[row], table.y[i] - truth.y[row]);
  }
  return errors;
}

function addPlots(page, parent) {
  const {head, tables} = page;
  const section = element("section", parent);
  section.className = "plots";
  const add = (title, unit, series, options) => {
    if (series.length === 0) return;
    const plot = new Plot(title, unit, series, options);
    section.appendChild(plot.canvas);
    followPointer(plot.canvas, page.time, plot);
    page.plots.push(plot);
  };
  const detectors = head.detectors.map((d) => Object.assign({}, d, {table: tables[d.table]})).filter((d) => d.table);
  const shown = (name) => () => !page.hidden[name];
  if (tables.eye && tables.truth)
    add("Gaze error", "deg", [{name: "left eye", colour: head.colours.gaze, table: tables.eye, value: (t) => t.error,
      shown: shown("gaze")}], {zero: true});
  if (tables.truth) {
    add("Position error", "px", detectors.map((d) => {
      const errors = aboveThreshold(d, positionErrors(d.table, tables.truth));
      return {name: d.name, colour: d.colour, table: d.table, value: () => errors, dots: true, age: 2e3,
        shown: shown("detector " + d.name)};
    }), {range: [0, 12]});
  }
  for (const [axis, title] of [["x", "Circle, x"], ["y", "Circle, y"]]) {
    const size = head.size[axis === "x" ? 0 : 1];
    const series = detectors.map((d) => {
      const values = aboveThreshold(d, d.table[axis]);
      return {name: d.name, colour: d.colour, table: d.table, value: () => values, dots: true, age: 2e3,
        shown: shown("detector " + d.name)};
    });
    if (tables.truth) {
      const values = tables.truth[axis].map((v, i) => tables.truth.visible[i] > 0 ? v : NaN);
      series.push({name: "ground truth", colour: head.colours.truth, table: tables.truth, value: () => values, gap: 50e3,
        shown: shown("truth")});
    }
    add(title, "px", series, {range: [0, size]});
  }
  if (tables.gaze) {
    add("Joints", "deg", head.joints.map((joint, i) => ({name: joint.name.replace(/_/g, " "),
      colour: jointColours[i % jointColours.length], table: tables.gaze, value: (t) => t[joint.column]})), {height: 124});
  }
  if (tables.rates)
    add("Events per ms", "", [["on", "ON"], ["off", "OFF"]].map(([name, text]) =>
      ({name: text, colour: head.colours[name], table: tables.rates, whole: true, value: (t) => t[name]})), {zero: true});
}

function addTimeline(page) {
  const canvas = by("timeline"), time = page.time;
  followPointer(canvas, time, {left: () => 0, right: () => 0});
  // Above the part that is shown, with the rate of events; below where that part lies in the whole.
  page.drawTimeline = () => {
    fit(canvas);
    const context = canvas.getContext("2d"), width = canvas.width, height = canvas.height;
    const ratio = height / Math.max(1, canvas.clientHeight), bar = 5 * ratio, high = height - bar - 3 * ratio;
    context.fillStyle = css("--panel");
    context.fillRect(0, 0, width, height);
    const toX = (t) => width * (t - time.from) / (time.to - time.from);
    const rates = page.tables.rates;
    if (rates) {
      let most = 1;
      for (let i = 0; i < rates.rows; ++i) most = Math.max(most, rates.on[i] + rates.off[i]);
      const begin = Math.max(0, rowsUntil(rates, time.from) - 1), end = Math.min(rates.rows, rowsUntil(rates, time.to) + 1);
      const bin = rates.rows > 1 ? rates.t[1] - rates.t[0] : 1e3;
      context.fillStyle = css("--line");
      context.beginPath();
      context.moveTo(toX(rates.t[begin] - bin / 2), high);
      for (let i = begin; i < end; ++i) context.lineTo(toX(rates.t[i]), high * (1 - 0.9 * (rates.on[i] + rates.off[i]) / most));
      context.lineTo(toX((rates.t[end - 1] || 0) + bin / 2), high);
      context.fill();
    }
    const span = (time.to - time.from) * 1e-6, step = tickStep(span, width / (90 * ratio));
    context.fillStyle = css("--soft");
    context.font = 10 * ratio + "px system-ui, sans-serif";
    context.textBaseline = "top";
    context.textAlign = "left";
    for (let t = Math.ceil(time.from * 1e-6 / step) * step; t <= time.to * 1e-6; t += step) {
      const x = toX(t * 1e6);
      context.fillRect(x, 0, ratio, 4 * ratio);
      if (x < width - 40 * ratio) context.fillText(t.toFixed(digitsOf(step)) + " s", x + 3 * ratio, 2 * ratio);
    }
    context.fillStyle = css("--line");
    context.fillRect(0, height - bar, width, bar);
    context.fillStyle = css("--accent");
    context.fillRect(width * time.from / time.end, height - bar, Math.max(2, width * (time.to - time.from) / time.end), bar);
    const x = toX(time.now);
    context.fillStyle = css("--text");
    context.fillRect(x - ratio, 0, 2 * ratio, high);
    context.beginPath();
    context.arc(x, high - 4 * ratio, 5 * ratio, 0, 7);
    context.fill();
    context.fillRect(width * time.now / time.end - ratio, height - bar, 2 * ratio, bar);
  };
}

function setPlaying(page, playing) {
  if (playing && page.time.now >= page.time.end) page.time.seek(0);
  page.playing = playing;
  by("play").textContent = playing ? "❚❚" : "▶";
  by("play").setAttribute("aria-label", playing ? "Pause" : "Play");
  if (!playing) saveLink(page);
}

function step(page, us) {
  setPlaying(page, false);
  page.time.seek(page.time.now + us);
}

function setSpeed(page, index) {
  by("speed").selectedIndex = Math.min(speeds.length - 1, Math.max(0, index));
  page.speed = speeds[by("speed").selectedIndex];
}

function addControls(page) {
  const time = page.time;
  speeds.forEach((speed) => element("option", by("speed"), speed < 1 ? "1/" + Math.round(1 / speed) : speed + "×"));
  windows.forEach((ms) => { element("option", by("window"), ms + " ms").value = ms; });
  setSpeed(page, speeds.indexOf(1));
  by("window").value = "10";
  by("speed").addEventListener("change", () => setSpeed(page, by("speed").selectedIndex));
  by("window").addEventListener("change", () => {
    page.span = by("window").value * 1e3;
    redraw(page);
  });
  by("play").addEventListener("click", () => setPlaying(page, !page.playing));
  by("back").addEventListener("click", () => step(page, -1e3));
  by("forward").addEventListener("click", () => step(page, 1e3));
  by("zoom_in").addEventListener("click", () => time.zoom(0.5));
  by("zoom_out").addEventListener("click", () => time.zoom(2));
  by("all").addEventListener("click", () => time.show(0, time.end));
  by("keys").addEventListener("click", () => { by("help").hidden = false; });
  by("close").addEventListener("click", () => { by("help").hidden = true; });
  by("help").addEventListener("click", (event) => { if (event.target === by("help")) by("help").hidden = true; });
  by("link").addEventListener("click", async () => {
    saveLink(page);
    let done = "in the address";
    try {
      await navigator.clipboard.writeText(location.href);
      done = "copied";
    } catch (error) { /* a browser that does not let the page write there: the address has it */ }
    by("link").textContent = done;
    setTimeout(() => { by("link").textContent = "Link"; }, 1500);
  });
  // Keys are the page's again after a click.
  document.addEventListener("click", (event) => {
    const pressed = event.target.closest("button, input");
    if (pressed && event.detail > 0) pressed.blur();
  });
  document.addEventListener("change", (event) => { if (event.target.tagName === "SELECT") event.target.blur(); });
  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.altKey || event.metaKey || event.target.tagName === "SELECT") return;
    const button = /^(BUTTON|INPUT)$/.test(event.target.tagName);  // space presses it
    const us = event.shiftKey ? 10e3 : 1e3;
    const actions = {
      " ": button ? null : () => setPlaying(page, !page.playing), ArrowLeft: () => step(page, -us), ArrowRight: () => step(page, us),
      PageUp: () => step(page, -100e3), PageDown: () => step(page, 100e3), Home: () => step(page, -Infinity),
      End: () => step(page, Infinity), "<": () => setSpeed(page, by("speed").selectedIndex - 1),
      ">": () => setSpeed(page, by("speed").selectedIndex + 1), "+": () => time.zoom(0.5), "=": () => time.zoom(0.5),
      "-": () => time.zoom(2), "0": () => time.show(0, time.end), "?": () => { by("help").hidden = !by("help").hidden; },
      Escape: () => { by("help").hidden = true; }
    };
    if (!actions[event.key]) return;
    actions[event.key]();
    event.preventDefault();
  });
}

// #t=1.25: the instant in s.
function openLink(page) {
  const asked = /(?:^#|&)t=(\d+(?:\.\d*)?|\.\d+)/.exec(location.hash);
  if (!asked) return;
  const us = Math.round(asked[1] * 1e6);
  if (us === Math.round(page.time.now)) return;
  setPlaying(page, false);
  page.time.seek(us);
}

function saveLink(page) {
  const hash = "#t=" + (page.time.now * 1e-6).toFixed(6).replace(/\.?0+$/, "");
  if (location.hash !== hash) history.replaceState(null, "", hash);
}

function frame(page, now, last) {
  const time = page.time;
  if (page.playing) {
    time.seek(time.now + Math.min(now - last, 250) * 1e3 * page.speed);
    if (time.now >= time.end) setPlaying(page, false);
  } else if (time.changed) {
    clearTimeout(page.saving);
    page.saving = setTimeout(() => saveLink(page), 300);
  }
  const changed = time.changed;
  time.changed = false;
  if (changed) {
    by("time").textContent = (time.now * 1e-6).toFixed(3) + " / " + (time.end * 1e-6).toFixed(2) + " s";
    page.plots.forEach((plot) => plot.draw(time, page.version));
    page.drawTimeline();
    page.images += 1;
  }
  for (const eye of page.eyes) {
    if (!changed && !eye.changed) continue;
    eye.draw(time.now, page.span);
    eye.label.textContent = eye.count + (page.head.events.every > 1 ? " shown" : "") + " events in " + page.span / 1e3 + " ms";
  }
  if (page.scene) {
    page.scene.changed = page.scene.changed || changed;
    // Drawn in software a scene takes long, which the time until the next frame shows: while the run plays it gets a quarter of
    // the time.
    if (page.sceneDrawn) page.sceneCost = now - last;
    page.sceneDrawn = page.scene.changed && (!page.playing || now - page.sceneAt > 4 * page.sceneCost);
    if (page.sceneDrawn) {
      page.scene.draw(time.now, page.head.start_us, page.tables.eye, page.tables.gaze);
      page.sceneAt = now;
    }
  }
  requestAnimationFrame((next) => frame(page, next, now));
}

start().catch((error) => {
  by("remark").textContent = "The page cannot show its data: " + error.message;
  by("remark").hidden = false;
  console.error(error);
});
