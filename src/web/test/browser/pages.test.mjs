// Every page with the simulated world, in both languages, on a phone and on a desktop.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { test } from "node:test";
import { drawnAgain, Gateway, openPage, outcome, shot, until, wider, world } from "./gateway.mjs";

const axe = readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");
const here = world();

/** The element that shows the content of each page. */
const pages = {
  "overview": ".branch", "frames": ".rows li", "charts": ".uplot", "log": "h1", "images": "canvas.picture", "recordings": "h1 ~ *", "220/vehicle": ".figure dd small",
  "220/parameters": ".set li", "220/commands": ".command", "220/waypoints": ".waypoints tr", "220/calibration": "button.main", "220/firmware": ".file",
};

/** On a busy computer a page may lose its gateway for a moment and is grey then: the check is repeated, even if the gateway is back at its end. */
async function violations(page) {
  await page.evaluate(axe);
  for (;;) {
    await page.waitForSelector(".contact.live");
    const { found, stayed } = await page.evaluate(async () => {
      const isLive = () => document.querySelector(".contact.live") !== null;
      let stayed = isLive();
      const watch = new MutationObserver(() => (stayed = stayed && isLive()));
      watch.observe(document.body, { subtree: true, childList: true, attributes: true });
      const result = await axe.run();
      watch.disconnect();
      return { found: result.violations.map((one) => `${one.id}: ${one.nodes.map((node) => node.html).join(" ")}`), stayed: stayed && isLive() };
    });
    if (found.length === 0 || stayed) return found;
  }
}

for (const [language, width, height, dark] of [["en", 1440, 900, false], ["zh-CN", 390, 844, true], ["en", 390, 844, false], ["zh-CN", 1440, 900, true]])
  test(`is shown in ${language} at ${width}×${height}`, async () => {
    const page = await here.open({ language, width, height, dark });
    await page.waitForSelector(".branch");
    for (const [name, sign] of Object.entries(pages)) {
      await page.evaluate((hash) => (location.hash = hash), "#/" + name);
      await page.waitForSelector(`main ${sign}`, { timeout: 30000 });
      await shot(page, `${name.replace("/", "-")}-${language}-${width}`);
            const found = await violations(page);
      assert.deepEqual(found, [], name);
      assert.ok((await wider(page)) <= 0, `${name} is wider than the screen`);
      if (name === "220/vehicle") await outcome(page, ".modules li", language === "en" ? /^velocity: \w/ : /^速度：[^ ]/);
      assert.equal(await page.evaluate(() => document.documentElement.lang), language === "en" ? "en" : "zh-CN");
    }
    assert.deepEqual(page.faults, []);
    assert.deepEqual(page.elsewhere, [], "not one request elsewhere");
    await page.browserContext().close();
  });

test("the form of the token has the room to be read, and the header says what is missing", async () => {
  if (!here.gateway.token("view")) return; // a gateway of the same user needs no token
  for (const [width, height] of [[1280, 800], [390, 844]]) {
    const page = await here.open({ access: "", width, height });
    await page.waitForSelector(".login");
    assert.ok((await page.$eval(".login", (form) => form.getBoundingClientRect().width)) > 300, `at ${width}`);
    assert.equal(await page.$eval(".contact", (lamp) => lamp.textContent), "token required");
    await page.browserContext().close();
  }
});

test("calls no trouble what a lone browser sees", async () => {
  const alone = await Gateway.start(["sim:fc", "udp-listen:127.0.0.1:0,name=ground"]);
  try {
    const page = await openPage(here.browser, alone);
    await until("no registered ground station", () => page.$$eval(".branch .calm", (all) => all.some((one) => one.textContent.includes("no ground station is registered"))));
    await page.waitForSelector(".well");
    assert.equal(await page.$$eval(".troubles, .flows .warn, .drops, .troubled", (all) => all.length), 0);
    assert.deepEqual(await page.$$eval(".flows div:last-child dd", (all) => all.map((one) => parseFloat(one.textContent))), [0, 0]);
    await page.browserContext().close();
  } finally {
    await alone.end();
  }
});

test("says each trouble once", async () => {
  const page = await here.open();
  await page.waitForSelector(".troubles li");
  const said = await page.$$eval(".troubles span", (all) => all.map((one) => one.textContent));
  assert.ok(said.length > 0);
  for (const words of new Set(said))
    assert.equal(await page.$$eval(".branch", (all, words) => all.filter((one) => one.textContent.includes(words)).length, words), 0, words);
  await page.browserContext().close();
});

test("on a phone, the pages of a device are in view and lead there", async () => {
  const page = await here.open({ width: 390, height: 844 });
  await page.waitForSelector("nav .narrow");
  const outside = await page.$$eval("nav a, nav select", (all) => all.map((one) => one.getBoundingClientRect()).filter((at) => at.width > 0 && (at.left < 0 || at.right > innerWidth)).length);
  assert.equal(outside, 0);
  await page.select("nav .narrow", "vehicle");
  await page.waitForSelector(".figure dd small");
  assert.match(await page.evaluate(() => location.hash), /^#\/\d+\/vehicle$/);
  await page.browserContext().close();
});

test("shows its first values within a second or two of opening", async () => {
  const page = await here.open({ hash: "#/220/vehicle" });
  await page.waitForSelector(".figure dd small");
  const began = Date.now();
  await page.reload();
  await page.waitForSelector(".figure dd small");
  const took = Date.now() - began;
  assert.ok(took < 10000, `${took} ms: how fast it is, npm run speed says; here others have the processor`);
  await page.browserContext().close();
});

test("a tab that is hidden asks for nothing", async () => {
  const page = await here.open({ hash: "#/frames" });
  await page.waitForSelector(".rows li");
  await page.evaluate(() => {
    Object.defineProperty(document, "hidden", { configurable: true, get: () => true });
    document.dispatchEvent(new Event("visibilitychange"));
  });
  let asked = 0;
  const beats = (n) => page.evaluate((n) => new Promise((done) => { const timer = setInterval(() => --n <= 0 && (clearInterval(timer), done()), 100); }), n); // the page sends its requests at this interval
  await beats(3); // the requests that were on their way
  page.on("request", () => ++asked);
  await beats(12);
  assert.equal(asked, 0);
  await page.evaluate(() => {
    delete document.hidden;
    document.dispatchEvent(new Event("visibilitychange"));
  });
  await until("it asks again", () => asked > 0);
  await page.browserContext().close();
});
