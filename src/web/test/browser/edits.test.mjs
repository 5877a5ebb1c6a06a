// Edits that were not written; the results of writes; jobs of other clients.
import assert from "node:assert/strict";
import { test } from "node:test";
import { asked, confirm, go, outcome, press, shot, type, until, world } from "./gateway.mjs";

const here = world(["sim:fc", "sim:imu"]);

test("typed values stay on their device while other pages are open, are marked, and the browser asks before they are lost", async () => {
  const page = await here.open({ hash: "#/220/parameters" });
  await type(page, "#parameter-1", "7");
  await page.waitForSelector("nav .roomy .edited");
  await go(page, "#/221/parameters");
  await page.waitForFunction(() => document.querySelector("main h1 small")?.textContent.includes("0xDD") && document.querySelector(".set li input"));
  assert.equal(await page.$("main .set li.changed"), null, "they are not another device's");
  assert.equal(await page.$("nav .roomy .edited"), null);
  assert.deepEqual(await page.$eval("nav option[value='220']", (option) => [option.text.slice(0, 6), option.title]), ["• 0xDC", "unsaved changes"]);
  await go(page, "#/frames");
  await page.waitForSelector(".rows li");
  await go(page, "#/220/parameters");
  await page.waitForSelector("#parameter-1");
  await until("the value is there", () => page.$eval("#parameter-1", (input) => input.value === "7"));
  await shot(page, "edits");
  const dialog = new Promise((done) => page.once("dialog", async (one) => { const kind = one.type(); await one.accept(); done(kind); }));
  await page.reload();
  assert.equal(await dialog, "beforeunload");
  await page.browserContext().close();
});

test("waypoints that were changed and not sent stay on their device, are marked, and the browser asks before they are lost", async () => {
  const page = await here.open({ hash: "#/220/waypoints" });
  const rows = () => page.$$eval("table.waypoints tbody tr", (all) => all.length);
  const altitude = "table.waypoints tbody tr:last-child td:nth-of-type(3) input";
  await page.waitForSelector("table.waypoints tbody tr");
  const before = await rows();
  assert.equal(await page.$(".unsent"), null);
  await press(page, "Add one");
  await type(page, altitude, "12.5");
  await outcome(page, ".unsent", /changed and not sent/);
  await page.waitForSelector("nav .roomy .edited");
  await go(page, "#/221/waypoints");
  await page.waitForFunction(() => document.querySelector("main h1 small")?.textContent.includes("0xDD"));
  assert.equal(await page.$(".unsent"), null, "they are not another device's");
  await go(page, "#/frames");
  await page.waitForSelector(".rows li");
  await go(page, "#/220/waypoints");
  await until("they are there", async () => (await rows()) === before + 1);
  assert.equal(await page.$eval(altitude, (input) => input.value), "12.5");
  await press(page, "Read again"); // shows the values of the device only after the edits are discarded
  await new Promise((done) => setTimeout(done, 1000));
  assert.equal(await rows(), before + 1);
  await shot(page, "waypoints-not-sent");
  const dialog = new Promise((done) => page.once("dialog", async (one) => { const kind = one.type(); await one.dismiss(); done(kind); }));
  await page.evaluate(() => setTimeout(() => location.reload(), 0));
  assert.equal(await dialog, "beforeunload");
  assert.equal(await rows(), before + 1);
  await press(page, "Write to the device");
  await confirm(page);
  await outcome(page, "main .outcome", /✓/);
  await until("nothing is unsent", async () => !(await page.$(".unsent")) && !(await page.$("nav .roomy .edited")));
  assert.equal((await asked(page, "devices/220/waypoints")).waypoints.length, before + 1);
  await press(page, "Add one");
  await page.waitForSelector(".unsent");
  await press(page, "Discard changes");
  await until("what the device has", async () => (await rows()) === before + 1 && !(await page.$(".unsent")));
  await page.browserContext().close();
});

test("a value that the type can't have is refused while it is typed", async () => {
  const page = await here.open({ hash: "#/220/parameters" });
  const write = () => page.$$eval("main button.main", (all) => all[0].disabled);
  await page.waitForSelector("#parameter-1");
  for (const [text, why] of [["x", /not a number/], ["1.5", /whole number|^$/], ["99999999999999", /must be|^$/]]) {
    await type(page, "#parameter-1", text);
    const said = await page.$eval("#parameter-1-text", (one) => one.querySelector(".fault")?.textContent.trim() ?? "");
    assert.match(said, why, text);
    assert.equal(await page.$eval("#parameter-1", (one) => one.getAttribute("aria-invalid") === "true"), said !== "");
    assert.equal(await write(), said !== "");
  }
  await type(page, "#parameter-1", "7");
  assert.equal(await write(), false);
  await page.browserContext().close();
});

test("“it may have been done” is said of writes alone", async () => {
  const page = await here.open({ hash: "#/220/parameters" });
  await type(page, "#parameter-1", "9");
  here.gateway.process.kill("SIGKILL");
  try {
    await page.waitForSelector(".contact.lost");
    await press(page, "Write changes (1)");
    await outcome(page, "main .outcome", /does not answer: it may have been carried out/);
    await press(page, "Read again");
    assert.doesNotMatch(await outcome(page, "main p.bad", /does not answer/), /may have been carried out/);
  } finally {
    await here.gateway.runAgain();
    await page.waitForSelector(".contact.live");
  }
  await page.browserContext().close();
});

test("a job that waits is offered to be opened, and is described by device, action and address", async () => {
  const page = await here.open({ hash: "#/221/calibration" });
  await page.waitForSelector("main select");
  await page.select("main select", "compass");
  await press(page, "Start");
  await page.waitForFunction(() => [...document.querySelectorAll("main button")].some((one) => one.textContent === "Continue"));
  await go(page, "#/221/parameters");
  await page.waitForSelector(".set li input");
  const first = await page.$eval(".set li input:not(:disabled)", (one) => "#" + one.id);
  await type(page, first, "1");
  await until("something is changed", () => page.$(".set li.changed"));
  await press(page, "Write changes (1)");
  const said = await outcome(page, "main .outcome", /0xDD is used by job \d+ \(calibration, by 127\.0\.0\.1\)/);
  assert.doesNotMatch(said, /Mozilla/);
  for (const job of (await asked(page, "jobs")).jobs) assert.doesNotMatch(JSON.stringify(job), /Mozilla|Chrome/);
  await outcome(page, "main .open-job", /Waiting for you: open Calibration/);
  await shot(page, "open-job");
  await page.click("main .open-job");
  await press(page, "Cancel and restore");
  await page.waitForSelector("main p.bad[role=alert]");
  await page.browserContext().close();
});
