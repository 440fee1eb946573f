// usage: live_page.cjs SACCADE: the live pages of a run, a deployed robot and a sweep, on a desktop's and a phone's screen.
const fs = require("fs"), path = require("path");
const {spawn} = require("child_process");
const {with_browser, expect, expect_equal} = require("./browser.cjs");

// Starts a command with --web. Returns {link, ended}: a promise of its status.
function started(program, folder, args) {
  const child = spawn(program, args, {cwd: folder, stdio: ["ignore", "ignore", "pipe"]});
  const ended = new Promise((resolve) => child.on("exit", resolve));
  return new Promise((resolve, reject) => {
    let text = "";
    child.stderr.on("data", (data) => {
      text += data;
      const link = /live page: (http:\S+)/.exec(text);
      if (link) resolve({link: link[1], ended, child});
    });
    ended.then((status) => reject(new Error("no link, status " + status + ": " + text)));
  });
}

// Sends SIGINT, which ends a run as planned, and waits for the end.
async function interrupted(command) {
  command.child.kill("SIGINT");
  return command.ended;
}

const has_state = (page, text) => page.waitForFunction((wanted) => document.getElementById("state").textContent === wanted, text,
  {timeout: 120000});

with_browser(process.argv[2], async ({folder, saccade, open}) => {
  const short = ["--set", "run.duration_s=1", "--set", "expect={}"];
  const screens = ["desktop", "phone"];

  // A run that goes on until it has been looked at.
  const run = await started(process.argv[2], folder, ["run", "look_at_ball", "--set", "run.duration_s=600", "--set", "expect={}",
    "--out", "long", "--web"]);
  expect(/^http:\/\/127\.0\.0\.1:\d+\/\?token=[0-9a-f]{32}$/.test(run.link), "a link on loopback with a token");
  expect_equal((await fetch(run.link.replace(/token=.*/, "token=0"))).status, 403, "status without the token");
  const pages = [];
  for (const screen of screens) {
    const page = await open(screen, run.link);
    pages.push(page);
    await page.waitForFunction(() => window.live && live.events > 1000 && live.images > 3, null, {timeout: 120000});
    expect_equal(await page.evaluate(() => live.head.title), "look_at_ball", "title");
    await page.waitForFunction(() => live.head.detectors.some((d) => d.table.rows > 0));
    expect(await page.evaluate(() => {
      const t = live.tables.instants;
      return t.rows > 0 && t.visible[t.rows - 1] >= 0 && Math.abs(t.t[t.rows - 1] - live.time.now) < 1;
    }), screen + ": ground truth up to now");
    expect_equal(await page.isVisible("#stop"), false, screen + ": a button that stops");
    expect(await page.evaluate(() => document.documentElement.scrollWidth <= innerWidth), screen + ": nothing wider than the screen");
    await page.keyboard.press("f");
    const frozen = await page.evaluate(() => [live.time.now, live.messages]);
    await page.waitForFunction((count) => live.messages > count + 3, frozen[1]);
    expect_equal(await page.evaluate(() => live.time.now), frozen[0], screen + ": the instant of a frozen page");
    await page.keyboard.press("f");
    await page.waitForFunction((then) => live.time.now > then, frozen[0]);
  }
  expect_equal(await interrupted(run), 1, "status of an interrupted run");
  for (const page of pages) await has_state(page, "ended");

  // A run is the same as one that nobody looked at.
  const watched = await started(process.argv[2], folder, ["run", "look_at_ball", ...short, "--out", "watched", "--web"]);
  await open("desktop", watched.link);
  expect_equal(await watched.ended, 0, "status of the run");
  saccade("run", "look_at_ball", ...short, "--out", "alone");
  const detections = (name) => fs.readFileSync(path.join(folder, name, "detections.csv"));
  expect(detections("watched").length > 1000 && detections("watched").equals(detections("alone")), "the same detections with and without a page");

  // A deployed robot, with bounds that a busy machine keeps.
  const robot = path.join(__dirname, "..", "..", "scenarios", "robots", "practice.yaml");
  for (const screen of screens) {
    const deploy = await started(process.argv[2], folder, ["deploy", robot, "--set", "deploy.guard=none", "--activate", "--out", "deploy_" + screen,
      "--web", ...["tick_late_ms=400", "hang_ms=400", "camera_silent_ms=400", "joints_stale_ms=400", "safe_within_ms=1000"].flatMap((bound) =>
        ["--set", "deploy.watchdog." + bound])]);
    const page = await open(screen, deploy.link);
    await has_state(page, "active");
    await page.waitForFunction(() => [...document.querySelectorAll(".results tbody tr")].length === 3 &&
      [...document.querySelectorAll(".results tbody td")].every((cell) => /^[\d.]+ ms$/.test(cell.textContent)));
    expect(await page.evaluate(() => document.documentElement.scrollWidth <= innerWidth), screen + ": nothing wider than the screen");
    if (screen === "phone") await page.tap("#stop");
    else await page.keyboard.press("Space");
    await has_state(page, "stopped");
    await page.waitForFunction(() => /stopped: /.test(document.getElementById("lines").textContent) && live.stops === 1);
    expect_equal(await interrupted(deploy), 0, "status of deploy after a stop");
    await has_state(page, "ended");
    expect(/stopped: by the operator/.test(fs.readFileSync(path.join(folder, "deploy_" + screen, "log.txt"), "utf8")), "the stop in log.txt");
  }

  fs.writeFileSync(path.join(folder, "sweep.yaml"), "name: tiny\nscenario: look_at_ball\nset: {run.duration_s: 0.15}\n" +
    "axes:\n  seed: {seeds: 6}\nreport: {metrics: [detectors.paper_full.average_precision, events.count], worst: 1}\n");
  const sweep = await started(process.argv[2], folder, ["sweep", "sweep.yaml", "--jobs", "1", "--out", "sweep", "--web"]);
  const page = await open("desktop", sweep.link);
  await page.waitForFunction(() => window.live && live.head && live.head.kind === "sweep" && document.querySelectorAll("tbody tr").length > 0,
    null, {timeout: 120000});
  expect(/\d of 6 done, 0 failed/.test(await page.locator(".results p").textContent()), "progress");
  expect_equal(await sweep.ended, 0, "status of the sweep");
  await has_state(page, "ended");
  expect_equal(await page.locator("tbody tr").count(), 6, "results");
  expect_equal(await page.locator(".pictures img").evaluateAll((images) => images.map((image) => image.naturalWidth > 0)), [true],
    "a picture of the worst run");
});
