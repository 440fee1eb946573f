// What the page that replays a run and the live page share: elements, panels, legends.

const windows = [1, 2, 5, 10, 20, 50, 100];  // ms
const jointColours = ["#e69f00", "#56b4e9", "#009e73", "#cc79a7", "#0072b2", "#d55e00", "#999933", "#882255", "#888888"];
const by = (id) => document.getElementById(id);

function element(kind, parent, text) {
  const made = document.createElement(kind);
  if (text !== undefined) made.textContent = text;
  if (parent) parent.appendChild(made);
  return made;
}

function panel(parent, kind, title) {
  const section = element("section", parent);
  section.className = kind;
  const heading = element("h2", section, title);
  const view = element("div", section);
  view.className = "view";
  return {section, heading, view, canvas: element("canvas", view)};
}

function dot(parent, colour) {
  const made = element("span", parent);
  made.className = "dot";
  made.style.background = colour;
}

function addPolarities(legend, colours) {
  for (const [name, text] of [["on", "ON"], ["off", "OFF"]]) {
    const mark = element("span", legend);
    dot(mark, colours[name]);
    mark.append(text);
  }
}

// A check box that shows and hides `name` everywhere; redraw() is the page's own.
function check(page, parent, name, text, colour) {
  const label = element("label", parent);
  const box = element("input", label);
  box.type = "checkbox";
  box.checked = true;
  dot(label, colour);
  label.append(text);
  box.addEventListener("change", () => {
    page.hidden[name] = !box.checked;
    redraw(page);
  });
}

function aboveThreshold(detector, values) {
  return values.map((v, i) => detector.table.score[i] >= detector.threshold ? v : NaN);
}
