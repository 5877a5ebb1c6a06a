// A gateway that only plays a recording: its devices can be watched, but receive no requests.
import assert from "node:assert/strict";
import { copyFileSync, existsSync, mkdtempSync, readdirSync, rmSync, statSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { drawnAgain, Gateway, go, openBrowser, openPage, outcome, shot, textOf, until, wider } from "./gateway.mjs";

const here = { folder: mkdtempSync(join(tmpdir(), "anogate-replay-")) };

/** A part of a flight of the simulated flight controller, recorded by the gateway. */
async function record(file) {
  const folderIn = (folder) => join(folder, "recordings");
  const gateway = await Gateway.start(["sim:fc"], (folder) => ({ record: { folder: folderIn(folder) } }));
  try {
    const folder = folderIn(gateway.folder); // created after the gateway listens
    const found = () => existsSync(folder) && readdirSync(folder).find((name) => name.endsWith(".pcapng"));
    await until("some is written", () => found() && statSync(join(folder, found())).size > 10000);
    await gateway.stop();
    copyFileSync(join(folder, found()), file);
  } finally {
    await gateway.end(); // otherwise this process would wait for it
  }
}

before(async () => {
  const file = join(here.folder, "flight.pcapng");
  await record(file);
  [here.gateway, here.browser] = await Promise.all([Gateway.start([`replay:${file},loop`]), openBrowser()]);
});
after(async () => {
  await here.browser?.close();
  await here.gateway?.end();
  rmSync(here.folder, { recursive: true, force: true });
});

const screens = [
  { language: "en", width: 1440, height: 900, of: "from a recording", devices: "devices: 1", nothing: "Nothing was dropped." },
  { language: "zh-CN", width: 390, height: 844, of: "来自录制", devices: "1 个设备", nothing: "没有丢弃任何帧。" },
];
for (const { language, width, height, of, devices, nothing } of screens)
  test(`who is in a recording is listed and watched, in ${language} at ${width}×${height}`, async () => {
    const page = await openPage(here.browser, here.gateway, { language, width, height });
    await page.waitForSelector(".who a");
    await drawnAgain(page, ".flows", 2);
    await shot(page, `overview-replay-${language}-${width}`);
    assert.equal(await textOf(page, ".branch .calm"), of);
    assert.match(await textOf(page, ".facts"), new RegExp(devices));
    assert.match(await textOf(page, "section[aria-labelledby=drops]"), new RegExp(nothing));
    const ofLink = (all) => all.map((one) => one.textContent).filter((text) => text.includes("flight")); // ignores stalls of this machine
    assert.deepEqual(await page.$$eval(".troubles li", ofLink), []);
    assert.equal(await page.$$eval(".flows .warn, .troubled", (all) => all.length), 0);
    assert.equal(await textOf(page, ".flows div:last-child dd"), language === "en" ? "0 /s" : "0 /秒");
    assert.match(await textOf(page, "nav select"), new RegExp(`0xDC .*${of}`));
    assert.deepEqual(await page.$$eval("nav .roomy a", (all) => all.map((one) => one.getAttribute("href"))), ["#/220/vehicle"]);
    assert.deepEqual(await page.$$eval("nav .narrow option", (all) => all.map((one) => one.value).filter(Boolean)), ["vehicle"]);
    await page.click(".who a");
    await page.waitForSelector(".figure dd small");
    await shot(page, `replay-vehicle-${language}-${width}`);
    assert.ok((await wider(page)) <= 0);
    assert.equal(await page.$(".pinned"), null);
    assert.deepEqual(page.faults, []);
    await page.browserContext().close();
  });

test("the pages that ask a device say that nobody is there, and ask nothing", async () => {
  const page = await openPage(here.browser, here.gateway);
  const asked = [];
  page.on("request", (request) => /\/devices\/\d/.test(request.url()) && asked.push(request.url()));
  await page.waitForSelector(".who a");
  await go(page, "#/220/parameters");
  await page.reload(); // the status is not known yet
  for (const name of ["parameters", "commands", "waypoints", "calibration", "firmware"]) {
    await go(page, "#/220/" + name);
    await outcome(page, "main .note", /Replay of flight\. Read-only/);
    await page.waitForFunction((name) => document.title.toLowerCase().startsWith(name), {}, name);
    assert.equal(await page.$("main button, main input"), null, name);
  }
  assert.deepEqual(asked, []);
  await page.browserContext().close();
});
