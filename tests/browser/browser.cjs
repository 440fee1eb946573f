// What the tests of pages share: a browser, a folder, and the end of a test. Exit status 77: skipped.
const fs = require("fs"), os = require("os"), path = require("path");
const {execFileSync} = require("child_process");

const chromium_paths = ["/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome"];
const screens = {
  desktop: {viewport: {width: 1280, height: 860}},
  phone: {viewport: {width: 390, height: 844}, deviceScaleFactor: 2, hasTouch: true, isMobile: true}
};

// Calls test({browser, folder, saccade, open}); `open(screen, url)` gives a page whose errors fail the test.
async function with_browser(program, test) {
  const folder = fs.mkdtempSync(path.join(os.tmpdir(), "saccade_browser_"));
  const skip = (why) => {
    console.log("SKIPPED: " + why + "; npm install --prefix build/browser and Debian's package chromium make it run (scripts/setup --all)");
    process.exit(77);
  };
  let playwright;
  try {
    playwright = require(path.join(process.env.SACCADE_BROWSER_MODULES || "", "node_modules", "playwright-core"));
  } catch (error) {
    skip("playwright-core is not installed");
  }
  const binary = chromium_paths.find((file) => fs.existsSync(file));
  if (!binary) skip("no chromium");
  const browser = await playwright.chromium.launch({executablePath: binary,
    args: ["--no-sandbox", "--disable-gpu", "--enable-unsafe-swiftshader"]});
  const problems = [];
  const open = async (screen, url) => {
    const context = await browser.newContext(screens[screen] || screen);
    const page = await context.newPage();
    page.on("pageerror", (error) => problems.push(screen + ": " + error.message));
    page.on("console", (message) => {
      // Software OpenGL states that it reads back what it draws.
      if (["error", "warning"].includes(message.type()) && !/GL Driver Message/.test(message.text())) problems.push(screen + ": " + message.text());
    });
    page.on("request", (request) => {  // a page of the server may ask there
      if (!/^(file|data|blob):/.test(request.url()) && !request.url().startsWith(url.split("?")[0].split("#")[0]))
        problems.push(screen + ": asks for " + request.url());
    });
    await page.goto(url);
    return page;
  };
  const saccade = (...given) => execFileSync(program, given, {cwd: folder, encoding: "utf8", stdio: ["ignore", "pipe", "pipe"]});
  let failed = false;
  try {
    await test({browser, folder, saccade, open});
    expect_equal(problems, [], "errors, warnings and requests of the page");
  } catch (error) {
    console.error(error);
    failed = true;
  }
  await browser.close();
  if (failed) console.error("the folder of the failed test: " + folder);
  else fs.rmSync(folder, {recursive: true});
  process.exit(failed ? 1 : 0);
}

function expect(condition, what) {
  if (!condition) throw new Error("expected: " + what);
}

function expect_equal(found, expected, what) {
  if (JSON.stringify(found) !== JSON.stringify(expected))
    throw new Error(what + ": found " + JSON.stringify(found) + ", expected " + JSON.stringify(expected));
}

module.exports = {with_browser, expect, expect_equal};
