// usage: report_pages.cjs SACCADE: the pages of a run, a sweep and a comparison, light and dark, on a phone and on paper.
const fs = require("fs"), path = require("path");
const {with_browser, expect, expect_equal} = require("./browser.cjs");

const luminance = (colour) => {
  const [r, g, b] = colour.match(/[\d.]+/g).map((v) => {
    const c = v / 255;
    return c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4;
  });
  return 0.2126 * r + 0.7152 * g + 0.0722 * b;
};

// The smallest contrast of a text with what is behind it (WCAG 2), over elements with text of their own.
async function least_contrast(page) {
  const pairs = await page.evaluate(() => {
    const found = {};
    for (const element of document.querySelectorAll("body *")) {
      if (element.closest("svg, script, style, .plot, .mark") || !element.checkVisibility()) continue;
      if (![...element.childNodes].some((node) => node.nodeType === 3 && node.textContent.trim())) continue;
      let behind = element;
      while (behind && getComputedStyle(behind).backgroundColor === "rgba(0, 0, 0, 0)") behind = behind.parentElement;
      const style = getComputedStyle(element);
      found[style.color + "|" + (behind ? getComputedStyle(behind).backgroundColor : "rgb(255, 255, 255)")] = element.tagName + "." + element.className;
    }
    return found;
  });
  return Object.entries(pairs).map(([colours, where]) => {
    const [a, b] = colours.split("|").map(luminance);
    return {contrast: (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05), where, colours};
  }).sort((a, b) => a.contrast - b.contrast)[0];
}

async function check_schemes(open, url, name) {
  for (const scheme of ["light", "dark"]) {
    const page = await open({viewport: {width: 1280, height: 860}, colorScheme: scheme}, url);
    const behind = luminance(await page.evaluate(() => getComputedStyle(document.body).backgroundColor));
    expect(scheme === "dark" ? behind < 0.05 : behind > 0.9, name + " is " + scheme);
    const least = await least_contrast(page);
    expect(least.contrast >= 4.5, name + ", " + scheme + ": contrast of 4.5, found " + JSON.stringify(least));
    await page.context().close();
  }
  const page = await open("phone", url);
  expect(await page.evaluate(() => document.documentElement.scrollWidth <= innerWidth + 1), name + " is as wide as the phone's screen");
  await page.context().close();
}

// On paper: drawings in place of plots, tables within the margins, a figure on one page.
async function check_paper(open, url, name) {
  const page = await open({viewport: {width: 703, height: 1000}}, url);
  await page.emulateMedia({media: "print"});
  await page.evaluate(() => window.dispatchEvent(new Event("beforeprint")));
  const found = await page.evaluate(() => ({
    tables: [...document.querySelectorAll(".wide > table")].map((table) => table.getBoundingClientRect().width),
    plots: [...document.querySelectorAll(".plots")].filter((plot) => plot.checkVisibility()).length,
    drawings: [...document.querySelectorAll(".drawing")].filter((drawing) => !drawing.checkVisibility()).length,
    splits: [...document.querySelectorAll("figure")].filter((figure) => figure.querySelector(".drawing") &&
      getComputedStyle(figure).breakInside !== "avoid").length,
    high: [...document.querySelectorAll(".drawing svg")].map((svg) => svg.getBoundingClientRect().height)
  }));
  expect(found.tables.every((width) => width <= 704), name + ": tables within the paper, found " + found.tables);
  expect_equal([found.plots, found.drawings, found.splits], [0, 0, 0], name + ": plots, hidden drawings and split figures on paper");
  expect(found.high.every((height) => height < 273 / 25.4 * 96), name + ": drawings lower than the paper");
  const pdf = await page.pdf({preferCSSPageSize: true});
  expect(pdf.length > 10000, name + ": a PDF");
  await page.context().close();
}

const cells = (page, table, column) => page.evaluate(([selector, at]) =>
  [...document.querySelector(selector).tBodies[0].rows].filter((row) => !row.hidden).map((row) => row.cells[at].textContent), [table, column]);

with_browser(process.argv[2], async ({folder, saccade, open}) => {
  const at = (...parts) => path.join(folder, ...parts);
  fs.writeFileSync(at("sweep.yaml"), "name: tiny\nscenario: look_at_ball\nset: {run.duration_s: 0.15}\n" +
    "axes:\n  seed: {seeds: 3}\n  ball.diameter_m: [0.06, 0.08, 0.1]\n" +
    "report: {metrics: [events.count, detectors.paper_full.average_precision], worst: 0}\n");
  saccade("sweep", "sweep.yaml", "--out", "sweep");
  for (const [name, seed] of [["a", 1], ["b", 2]])
    saccade("run", "look_at_ball", "--seed", String(seed), "--set", "run.duration_s=0.3", "--set", "expect={}", "--out", name);
  try {
    saccade("compare", "a", "b", "--html", "compare.html");
    expect(false, "status 3 of compare");
  } catch (error) {
    expect_equal(error.status, 3, "status of compare");
  }

  for (const [name, file] of [["a run", at("a", "report.html")], ["a sweep", at("sweep", "report.html")], ["a comparison", at("compare.html")]]) {
    await check_schemes(open, "file://" + file, name);
    await check_paper(open, "file://" + file, name);
  }

  const sweep = await open("desktop", "file://" + at("sweep", "report.html"));
  expect_equal((await cells(sweep, "#runs", 0)).length, 9, "runs");
  await sweep.locator("#runs th", {hasText: "events.count"}).click();
  const sorted = (await cells(sweep, "#runs", 3)).map(Number);
  expect_equal(sorted, [...sorted].sort((a, b) => a - b), "runs sorted by events.count");
  await sweep.locator("#runs th", {hasText: "events.count"}).click();
  expect_equal((await cells(sweep, "#runs", 3)).map(Number), [...sorted].reverse(), "the other way round");
  const filter = sweep.locator(".filter input").last();
  await filter.fill("ball.diameter_m>0.07 seed=2");
  expect_equal((await cells(sweep, "#runs", 2)).sort(), ["0.08", "0.1"], "filtered runs");
  await filter.fill("nothing<3");
  expect((await sweep.locator(".filter output").last().textContent()).includes("no column of nothing<3"), "a message for an unknown column");

  const comparison = await open("desktop", "file://" + at("compare.html"));
  const results = await cells(comparison, "table.sort", 7);
  expect(results.length > 20 && results[0] === "changed", "what has changed first");
  expect_equal([...results].sort().join(), results.join(), "changed before equal");
});
