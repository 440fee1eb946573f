// usage: live_page.cjs SACCADE: the live pages of a run and of a sweep, on a desktop's and a phone's screen.
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

with_browser(process.argv[2], async ({folder, open}) => {
  const run = await started(process.argv[2], folder, ["run", "look_at_ball", "--set", "run.duration_s=3", "--set", "expect={}", "--out", "run",
    "--web"]);
  expect(/^http:\/\/127\.0\.0\.1:\d+\/\?token=[0-9a-f]{32}$/.test(run.link), "a link on loopback with a token");
  expect_equal((await fetch(run.link.replace(/token=.*/, "token=0"))).status, 403, "status without the token");
  const pages = {desktop: await open("desktop", run.link), phone: await open("phone", run.link)};
  for (const [screen, page] of Object.entries(pages)) {
    await page.waitForFunction(() => window.live && live.events > 1000 && live.images > 3, null, {timeout: 120000});
    expect_equal(await page.evaluate(() => live.head.title), "look_at_ball", "title");
    expect(await page.evaluate(() => live.head.detectors.some((d) => d.table.rows > 0)), screen + ": detections");
    expect(await page.evaluate(() => {
      const t = live.tables.instants;
      return t.rows > 0 && t.visible[t.rows - 1] >= 0 && Math.abs(t.t[t.rows - 1] - live.time.now) < 1;
    }), screen + ": ground truth up to now");
    expect_equal(await page.isVisible("#stop"), false, screen + ": a button that stops");
    expect(await page.evaluate(() => document.documentElement.scrollWidth <= innerWidth), screen + ": nothing wider than the screen");
    await page.keyboard.press("Space");
    const frozen = await page.evaluate(() => live.time.now);
    const messages = await page.evaluate(() => live.messages);
    await page.waitForFunction((count) => live.messages > count + 3, messages);
    expect_equal(await page.evaluate(() => live.time.now), frozen, screen + ": the instant of a frozen page");
    await page.keyboard.press("Space");
  }
  expect_equal(await run.ended, 0, "status of the run");
  for (const page of Object.values(pages)) await page.waitForFunction(() => document.getElementById("state").textContent === "connection ended");
  // The run is the same as one that nobody looked at.
  const alone = require("child_process").execFileSync(process.argv[2], ["run", "look_at_ball", "--set", "run.duration_s=3", "--set", "expect={}",
    "--out", "alone"], {cwd: folder, stdio: "pipe"});
  expect(alone !== null && fs.readFileSync(path.join(folder, "run", "detections.csv")).equals(fs.readFileSync(path.join(folder, "alone",
    "detections.csv"))), "the same detections with and without a page");

  fs.writeFileSync(path.join(folder, "sweep.yaml"), "name: tiny\nscenario: look_at_ball\nset: {run.duration_s: 0.15}\n" +
    "axes:\n  seed: {seeds: 12}\nreport: {metrics: [events.count], worst: 0}\n");
  const sweep = await started(process.argv[2], folder, ["sweep", "sweep.yaml", "--jobs", "1", "--out", "sweep", "--web"]);
  const page = await open("desktop", sweep.link);
  await page.waitForFunction(() => window.live && live.head && live.head.kind === "sweep" && document.querySelectorAll("tbody tr").length > 0,
    null, {timeout: 120000});
  expect((await page.locator(".results p").textContent()).includes("of 12 done, 0 failed"), "progress");
  expect_equal(await sweep.ended, 0, "status of the sweep");
});
