// The page in Chromium, against a gateway with a simulated flight controller.
//   npm run test:browser -- --anogated PATH      screenshots: build/screenshots
import assert from "node:assert/strict";
import http from "node:http";
import { after, before, test } from "node:test";
import { mkdirSync, readFileSync, writeFileSync } from "node:fs";
import { dirname, join, resolve } from "node:path";
import { fileURLToPath } from "node:url";
import { answer, close, go, launch, logIn, openPage, press, sees } from "./browser.mjs";
import { freePort, Gateway, HostileDevice } from "./gateway.mjs";

const here = dirname(fileURLToPath(import.meta.url));
const shots = join(here, "../../build/screenshots");
const axe = readFileSync(join(here, "../../node_modules/axe-core/axe.min.js"), "utf8");
const program = resolve(process.env.ANOGATED ?? "anogated");

const ofGateway = ["overview", "frames", "charts", "log", "images"];
const ofDevice = ["vehicle", "parameters", "commands", "waypoints", "calibration", "firmware"];
const places = [...ofGateway.map((name) => [name, "#/" + name]), ...ofDevice.map((name) => [name, "#/220/" + name])];
const looks = [
  { language: "en", theme: "light", width: 1440, height: 900 },
  { language: "zh-CN", theme: "dark", width: 1440, height: 900 },
  { language: "en", theme: "dark", width: 390, height: 844 },
  { language: "zh-CN", theme: "light", width: 390, height: 844 },
];

const html = `<img src=x onerror="alert(1)"><script>alert(2)</script>"'&`;
let browser, gateway, port;

before(async () => {
  mkdirSync(shots, { recursive: true });
  browser = await launch();
  gateway = new Gateway(program);
  port = await freePort();
  await gateway.start("sim:fc,hz=20", `udp-listen:127.0.0.1:${port},max_data=20000`);
});
after(async () => {
  await browser?.close();
  await gateway?.stop();
  gateway?.remove();
});

/** A page of who may do everything. */
async function opened(look = {}, hash = "#/") {
  const page = await openPage(browser, look);
  await logIn(page, gateway.origin, gateway.token("control"), hash);
  await page.waitForSelector("nav select", { timeout: 15000 });
  return page;
}

// Answers that are part of the life with devices: a token is wanted, a device is busy, or does not answer.
const faultsOf = (page) => page.faults.filter((fault) => !/status of (401|409|504)/.test(fault));

for (const look of looks) {
  const name = `${look.language.slice(0, 2)}-${look.width}-${look.theme}`;
  test(`every page can be read by everybody: ${name}`, async () => {
    const page = await opened(look);
    await page.evaluate(axe);
    const wrong = [];
    for (const [title, hash] of places) {
      await go(page, hash);
      await page.waitForFunction(() => document.querySelector("main h1") && !document.querySelector("main .job"), { timeout: 20000 });
      await page.evaluate(() => new Promise((done) => { setTimeout(done, 700); })); // values and rates
      await page.screenshot({ path: join(shots, `${title}-${name}.png`) });
      const wide = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
      if (wide > 0) wrong.push(`${title}: ${wide} px wider than the screen`);
      const found = await page.evaluate(() => window.axe.run());
      for (const one of found.violations) wrong.push(`${title}: ${one.id}, ${one.nodes.slice(0, 3).map((node) => node.html.slice(0, 120)).join(" ; ")}`);
    }
    assert.deepEqual(wrong, []);
    assert.deepEqual(faultsOf(page), []);
    assert.deepEqual([...new Set(page.elsewhere)], [new URL(gateway.origin).host], "not one request elsewhere");
    await close(page);
  });
}

test("first values are there within a second", async () => {
  const page = await opened({}, "#/220/vehicle");
  await page.waitForFunction(() => /\d/.test(document.querySelector("main")?.innerText ?? ""));
  const began = performance.now();
  await page.reload({ waitUntil: "commit" }).catch(() => undefined);
  await page.waitForFunction(() => document.querySelector(".contact.live") && /\d/.test(document.querySelector("main")?.innerText ?? ""), { polling: 20, timeout: 10000 });
  const took = performance.now() - began;
  console.log(`first values after ${took.toFixed(0)} ms`);
  assert.ok(took < 3000, `${took} ms`);
  await close(page);
});

test("a gateway that is gone is told within seconds, and comes back by itself", async () => {
  const page = await opened({}, "#/frames");
  await page.waitForSelector(".rows li");
  await gateway.stop("SIGKILL");
  await page.waitForSelector(".contact.lost", { timeout: 3000 });
  await page.waitForSelector(".banner");
  await gateway.start();
  await page.waitForSelector(".contact.live", { timeout: 10000 });
  await page.waitForFunction(() => [...document.querySelectorAll(".rows li")].some((row) => !row.classList.contains("late")), { timeout: 10000 });
  await close(page);
});

test("a wrong token is refused, and the right one lets in", async () => {
  const page = await openPage(browser);
  await logIn(page, gateway.origin, "wrong");
  await page.waitForSelector(".login [role=alert]");
  assert.equal(await page.$("nav"), null);
  await page.$eval(".login input", (input) => input.select());
  await page.type(".login input", gateway.token("control"));
  await page.click(".login button");
  await page.waitForSelector("nav select");
  await close(page);
});

test("who only looks is offered nothing that acts, and what he tries is refused", async () => {
  const page = await openPage(browser);
  await logIn(page, gateway.origin, gateway.token("view"), "#/220/parameters");
  await page.waitForSelector("main input[id^=parameter-]", { timeout: 20000 });
  assert.equal(await page.$$eval("main .set input:not(:disabled)", (all) => all.length), 0);
  for (const name of ofDevice) {
    await go(page, "#/220/" + name);
    await page.waitForSelector("main h1");
    assert.equal(await page.$$eval("main button.main, .pinned button", (all) => all.length), 0, name);
  }
  const tried = await page.evaluate(async () => {
    const ask = (path, method, body) => fetch(path, { method, headers: { "Content-Type": "application/json" }, body: JSON.stringify(body) }).then((answer) => answer.status);
    return [await ask("/devices/220/parameters/SIM_WIND", "PUT", { value: 9 }), await ask("/devices/220/commands/UNLOCK", "POST", {}), await ask("/send", "POST", { hex: "AB" })];
  });
  assert.deepEqual(tried, [403, 403, 403]);
  await close(page);
});

test("a parameter is written, and what the device stored is shown", async () => {
  const page = await opened({}, "#/220/parameters");
  await page.waitForSelector("main input[id^=parameter-]", { timeout: 20000 });
  const id = await page.$$eval("main label", (all) => all.find((one) => one.textContent.includes("SIM_TURN")).htmlFor);
  await page.$eval("#" + id, (input) => input.select());
  await page.type("#" + id, "-7");
  await press(page, "Write 1");
  await page.waitForSelector("main .outcome.good", { timeout: 20000 });
  assert.equal((await gateway.ask("/devices/220/parameters/SIM_TURN")).value, -7);
  assert.equal(await page.$eval("#" + id, (input) => input.value), "-7");
  await press(page, "Keep over a restart");
  await page.waitForFunction(() => document.querySelector("main .outcome.good")?.textContent.length > 2, { timeout: 20000 });
  await close(page);
});

test("a command asks first, is deaf to a second touch, and is carried out once", async () => {
  const page = await opened({}, "#/220/commands");
  await page.waitForFunction(() => document.querySelectorAll(".command").length === 12, { timeout: 20000 });
  const before = (await gateway.ask("/jobs")).jobs.filter((job) => job.kind === "command").length;
  await page.evaluate(() => {
    const card = [...document.querySelectorAll(".command")].find((one) => one.textContent.includes("HOVER"));
    card.setAttribute("data-it", "");
    card.querySelector("button").click();
  });
  await page.waitForSelector("[data-it] .confirm");
  await page.evaluate(() => document.querySelector("[data-it] .confirm .main").click()); // at once
  assert.ok(await page.$("[data-it] .confirm"), "the second touch was no answer");
  await page.evaluate(() => new Promise((done) => { setTimeout(done, 450); }));
  await page.evaluate(() => document.querySelector("[data-it] .confirm .main").click());
  await page.waitForSelector("[data-it] .outcome:is(.good, .bad):not(:empty)", { timeout: 20000 });
  const after = (await gateway.ask("/jobs")).jobs.filter((job) => job.kind === "command").length;
  assert.equal(after - before, 1);
  await close(page);
});

test("waypoints are added, written and read back", async () => {
  const page = await opened({}, "#/220/waypoints");
  await page.waitForSelector("table.waypoints tbody tr", { timeout: 20000 });
  await press(page, "Add");
  await press(page, "Add");
  await page.waitForFunction(() => document.querySelectorAll("table.waypoints tbody tr").length === 3);
  await press(page, "Write");
  await answer(page, "Write");
  await page.waitForSelector("main .outcome.good:not(:empty)", { timeout: 20000 });
  assert.equal((await gateway.ask("/devices/220/waypoints")).waypoints.length, 3);
  await close(page);
});

test("pictures come, and the one that was half gone by is not called lost", async () => {
  const page = await opened({}, "#/images");
  await page.waitForSelector("main canvas", { timeout: 20000 });
  await page.evaluate(() => new Promise((done) => { setTimeout(done, 1500); }));
  assert.equal(await page.$("main figcaption .warn"), null);
  await close(page);
});

test("a firmware is sent, and how it went is told", async () => {
  const file = join(gateway.folder, "new.bin");
  writeFileSync(file, Buffer.alloc(3000, 7));
  const page = await opened({}, "#/220/firmware");
  const input = await page.waitForSelector("main input[type=file]");
  await input.uploadFile(file);
  await sees(page, "new.bin");
  await press(page, "Upgrade");
  await answer(page, "Upgrade");
  await page.waitForSelector("main p.good[role=status], main p.bad[role=alert]", { timeout: 60000 });
  await page.screenshot({ path: join(shots, "firmware-done.png") });
  assert.match(await page.$eval("main p.good[role=status], main p.bad[role=alert]", (one) => one.textContent), /3000 bytes in 16 frames/);
  await close(page);
});

async function begunCalibration(what) {
  const page = await opened({}, "#/220/calibration");
  await page.waitForSelector("main select");
  await page.select("main select", what);
  await press(page, "Begin");
  await press(page, "Go on");
  await page.waitForSelector("main svg.solid", { timeout: 20000 });
  await page.evaluate(() => new Promise((done) => { setTimeout(done, 1500); }));
  await page.screenshot({ path: join(shots, `calibration-${what}.png`) });
  return page;
}

test("a calibration can be cancelled, and the old values come back", async () => {
  const old = (await gateway.ask("/devices/220/parameters/CAL_AOFF_X")).value;
  const page = await begunCalibration("accelerometer");
  await press(page, "Cancel and restore");
  await page.waitForSelector("main p.bad[role=alert]", { timeout: 20000 });
  assert.match(await page.$eval("main p.bad[role=alert]", (one) => one.textContent), /cancelled/);
  assert.equal((await gateway.ask("/devices/220/parameters/CAL_AOFF_X")).value, old);
  await close(page);
});

test("a calibration that is not watched goes on, and its end is told to who comes back", async () => {
  const page = await begunCalibration("compass");
  await go(page, "#/220/vehicle");
  await page.evaluate(() => new Promise((done) => { setTimeout(done, 1000); }));
  await go(page, "#/220/calibration");
  await page.waitForSelector("main svg.solid", { timeout: 5000 });
  await page.waitForFunction(() => document.querySelector("main .card .good"), { timeout: 60000 });
  const told = await page.$eval("main", (one) => one.innerText);
  assert.match(told, /error before/);
  assert.match(told, /CAL_MOFF_X/);
  await page.screenshot({ path: join(shots, "calibration-done.png") });
  await close(page);
});

test("the words of a device are words, however long and whatever they look like", async () => {
  const device = new HostileDevice(port, html.repeat(160));
  const page = await opened({ width: 390, height: 844 }, "#/log");
  await page.waitForFunction(() => document.querySelectorAll(".log li").length > 3, { timeout: 20000 });
  for (const hash of ["#/log", "#/frames", "#/overview", "#/30/parameters", "#/30/vehicle", "#/30/commands"]) {
    await go(page, hash);
    await page.evaluate(() => new Promise((done) => { setTimeout(done, 1200); }));
    assert.equal(await page.evaluate(() => document.querySelectorAll("#app img, #app script").length), 0, hash);
    assert.ok((await page.evaluate(() => document.documentElement.scrollWidth - innerWidth)) <= 0, hash + " is wider than the screen");
    await page.screenshot({ path: join(shots, `hostile-${hash.replace(/\W+/g, "")}.png`) });
  }
  assert.deepEqual(faultsOf(page), []);
  device.stop();
  await close(page);
});

test("a page of another origin neither acts nor looks", async () => {
  const served = http.createServer((request, response) => response.writeHead(200, { "Content-Type": "text/html" }).end("<p>evil</p>"));
  await new Promise((done) => { served.listen(0, "127.0.0.1", done); });
  const own = await opened({}, "#/");
  const page = await own.browserContext().newPage(); // with the cookie of who is let in
  await page.goto(`http://evil.example:${served.address().port}/`);
  const before = (await gateway.ask("/devices/220/parameters/SIM_TURN")).value;
  const tried = await page.evaluate(async (origin) => {
    const look = await fetch(origin + "/status", { credentials: "include" }).then((answer) => answer.status, () => "refused");
    const act = await fetch(origin + "/devices/220/parameters/SIM_TURN", { method: "PUT", credentials: "include", body: '{"value": 99}' }).then((answer) => answer.status, () => "refused");
    await fetch(origin + "/devices/220/apply", { method: "POST", mode: "no-cors", credentials: "include", body: '{"SIM_TURN": 99}' }).catch(() => undefined);
    const watch = await new Promise((done) => {
      const socket = new WebSocket(origin.replace("http", "ws") + "/frames");
      socket.onopen = () => done("open");
      socket.onerror = () => done("refused");
    });
    return [look, act, watch];
  }, gateway.origin);
  assert.deepEqual(tried, ["refused", "refused", "refused"]);
  assert.equal((await gateway.ask("/devices/220/parameters/SIM_TURN")).value, before);
  // A name that leads to the gateway is not the gateway's name.
  const rebound = await page.goto(`http://evil.example:${gateway.port}/status`);
  assert.ok([400, 401, 403, 421].includes(rebound.status()), String(rebound.status()));
  await close(own);
  served.close();
});
