// usage: replay_page.cjs SACCADE: runs a scenario, and opens its replay page on a desktop's and a phone's screen.
const fs = require("fs"), path = require("path");
const {with_browser, expect, expect_equal} = require("./browser.cjs");

// Rows of a table of the run folder, as objects.
function table(file) {
  const lines = fs.readFileSync(file, "utf8").trim().split("\n"), names = lines[0].split(",");
  return lines.slice(1).map((line) => Object.fromEntries(line.split(",").map((value, i) => [names[i], value])));
}

// How many pixels of a place of the page are nearer to a colour than `distance`, from a screenshot drawn into a canvas.
async function pixels_like(page, selector, colour, distance) {
  const png = (await page.locator(selector).screenshot()).toString("base64");
  return page.evaluate(async ([data, [r, g, b], limit]) => {
    const image = new Image();
    image.src = "data:image/png;base64," + data;
    await image.decode();
    const canvas = document.createElement("canvas");
    canvas.width = image.width;
    canvas.height = image.height;
    const context = canvas.getContext("2d");
    context.drawImage(image, 0, 0);
    const bytes = context.getImageData(0, 0, canvas.width, canvas.height).data;
    let count = 0;
    for (let i = 0; i < bytes.length; i += 4)
      if (Math.abs(bytes[i] - r) + Math.abs(bytes[i + 1] - g) + Math.abs(bytes[i + 2] - b) < limit) ++count;
    return count;
  }, [png, colour, distance]);
}

async function ready(page) {
  await page.waitForFunction(() => window.replay && window.replay.images > 0, null, {timeout: 60000});
}

// Waits until what is shown belongs to the instant.
async function settled(page) {
  const before = await page.evaluate(() => { replay.time.changed = true; return replay.images; });
  await page.waitForFunction((count) => replay.images > count, before);
}

const now = (page) => page.evaluate(() => replay.time.now);

async function check_controls(page) {
  await page.keyboard.press("Home");
  expect_equal(await now(page), 0, "the start");
  await page.keyboard.press("ArrowRight");
  await page.keyboard.press("Shift+ArrowRight");
  expect_equal(await now(page), 11000, "a step and ten");
  await page.click("#back");
  expect_equal(await now(page), 10000, "a step back");
  await page.keyboard.press("+");
  const zoomed = await page.evaluate(() => replay.time.to - replay.time.from);
  expect(zoomed < 0.51 * await page.evaluate(() => replay.time.end), "less time after +");
  await page.evaluate(() => replay.time.seek(replay.time.end * 0.9));
  expect(await page.evaluate(() => replay.time.to >= replay.time.now), "the plots follow the instant");
  await page.click("#all");
  expect_equal(await page.evaluate(() => replay.time.from), 0, "all");
  const box = await page.locator("#timeline").boundingBox();
  await page.mouse.move(box.x + box.width / 4, box.y + 20);
  await page.mouse.down();
  await page.mouse.move(box.x + box.width / 2, box.y + 20, {steps: 4});
  await page.mouse.up();
  expect(Math.abs(await now(page) / await page.evaluate(() => replay.time.end) - 0.5) < 0.01, "half of the run after scrubbing there");
  await page.mouse.wheel(0, -400);
  await page.waitForFunction(() => replay.time.to - replay.time.from < 0.9 * replay.time.end);
  await page.click("#all");
  // The address holds the instant.
  await page.waitForFunction(() => /^#t=0\.\d+$/.test(location.hash));
  await page.evaluate(() => { location.hash = "#t=0.4375"; });
  await page.waitForFunction(() => replay.time.now === 437500);
  // Playing: simulated time goes on at the speed that is chosen, and ends at the end.
  await page.selectOption("#speed", {index: 0});
  await page.keyboard.press("Home");
  await page.keyboard.press("Space");
  await page.waitForFunction(() => replay.time.now > 5000);
  await page.keyboard.press("Space");
  const stopped = await now(page);
  await page.waitForTimeout(200);
  expect_equal(await now(page), stopped, "the instant after pausing");
  await page.selectOption("#speed", {index: 5});
  await page.keyboard.press("End");
  await page.keyboard.press("Shift+ArrowLeft");
  await page.click("#play");
  await page.waitForFunction(() => replay.time.now === replay.time.end && !replay.playing);
}

with_browser(process.argv[2], async ({folder, saccade, open}) => {
  const scenario = "look_at_ball";
  saccade("run", scenario, "--set", "run.duration_s=0.8", "--set", "expect={}", "--set", "output.events=csv", "--out", "run");
  saccade("report", "run");
  const file = path.join(folder, "run", "replay.html");
  expect(fs.statSync(file).size < 15e6, "less than 15 MB");

  const events = table(path.join(folder, "run", "events.csv"));
  const truth = table(path.join(folder, "run", "truth.csv"));
  const row = truth.findIndex((entry) => entry.visible > 0.9 && entry.t_us >= 400000);
  const t_s = truth[row].t_us * 1e-6;
  for (const screen of ["desktop", "phone"]) {
    const page = await open(screen, "file://" + file + "#t=" + t_s);
    await ready(page);
    await settled(page);
    expect(Math.abs(await now(page) - truth[row].t_us) < 1, "the instant of the link");
    // Every event, in its place.
    const found = await page.evaluate(() => {
      const e = replay.tables.events;
      return Array.from(e.t, (t, i) => [t, e.x[i], e.y[i], e.on[i]].join());
    });
    expect_equal(found.length, events.length, "events");
    const columns = Object.keys(events[0]);
    const expected = events.map((e) => [e[columns[0]], e.x, e.y, e.p].join());
    found.sort();
    expected.sort();
    expect_equal(found, expected, "events of the page");
    // Circle of the ground truth where the table has it.
    const at = await page.evaluate(() => {
      const t = replay.tables.truth, i = Array.from(t.t).indexOf(replay.time.now);
      return [t.x[i], t.y[i], t.r[i]];
    });
    for (const [i, name] of ["x_px", "y_px", "r_px"].entries())
      expect(Math.abs(at[i] - truth[row][name]) < 0.006, name + " of the truth");
    expect(await pixels_like(page, ".eye canvas", [0x00, 0x9e, 0x73], 30) > 50, "the true circle in the image of the eye");
    // The scene: the red ball, and another image from elsewhere.
    expect(await page.evaluate(() => replay.scene !== null), "a scene");
    expect(await pixels_like(page, ".scene canvas", [0x23, 0x25, 0x2b], 6) < 0.9 * await page.evaluate(() => {
      const canvas = document.querySelector(".scene canvas");
      return canvas.clientWidth * canvas.clientHeight * devicePixelRatio * devicePixelRatio;
    }), "something in the scene");
    // The ball of the scene is where the ground truth has it, which comes another way from the simulator.
    const places = await page.evaluate(() => {
      const scene = replay.scene, at = (name) => scene.groups[scene.bodies.findIndex((body) => body.name === name)].position.toArray();
      const moving = scene.bodies.filter((body) => body.poses.length > 1).map((body) => body.name);
      return {ball: at("ball_hand"), root: at("root"), moving};
    });
    ["x_m", "y_m", "z_m"].forEach((name, i) =>
      expect(Math.abs(places.ball[i] - truth[row][name]) < 1e-3, "the ball's " + name + ", found " + places.ball));
    expect(places.moving.length > 3 && !places.moving.includes("root"), "bodies that move, found " + places.moving);
    const overview = await page.locator(".scene canvas").screenshot();
    await page.selectOption("#view", "eye");
    await settled(page);
    expect(!overview.equals(await page.locator(".scene canvas").screenshot()), "another image through the eye");
    // Hiding the truth hides its circle.
    await page.locator("label", {hasText: "ground truth"}).locator("input").uncheck();
    await settled(page);
    expect_equal(await pixels_like(page, ".eye canvas", [0x00, 0x9e, 0x73], 30), 0, "pixels of a hidden circle");
    if (screen === "desktop") await check_controls(page);
    expect(await page.evaluate(() => document.documentElement.scrollWidth <= innerWidth), "nothing wider than the screen");
  }

  // The front picture of the site is such a page in a frame.
  const frame = fs.readFileSync(path.join(__dirname, "..", "..", "site", "demo.md"), "utf8").split("```")[1].replace("{raw} html", "");
  fs.copyFileSync(file, path.join(folder, "demo.html"));
  fs.writeFileSync(path.join(folder, "front.html"), "<!doctype html><meta charset=utf-8><title>front</title>" + frame);
  for (const screen of ["desktop", "phone"]) {
    const front = await open(screen, "file://" + path.join(folder, "front.html"));
    expect_equal(front.frames().length, 2, "frames");
    const inner = front.frames()[1];
    await ready(inner);
    expect(await inner.evaluate(() => replay.scene !== null && document.documentElement.scrollWidth <= innerWidth),
      "a scene, and nothing wider than the frame");
  }

  // A recording has neither scene nor truth.
  saccade("view", path.join("run", "events.csv"), "--size", "128x128", "--html", "events.html");
  const page = await open("desktop", "file://" + path.join(folder, "events.html"));
  await ready(page);
  expect(await page.evaluate(() => replay.scene === null && replay.tables.truth === undefined), "events alone");
  expect_equal(await page.evaluate(() => replay.tables.events.rows), events.length, "events of the recording");
});
