// Actions on a device, and its messages, from start to end.
import assert from "node:assert/strict";
import dgram from "node:dgram";
import { test } from "node:test";
import { asked, confirm, drawnAgain, go, outcome, press, shot, textOf, type, until, wider, world } from "./gateway.mjs";
import { frame, HostileDevice, LargeDevice } from "./hostile_device.mjs";

const here = world(["sim:fc", "udp-listen:127.0.0.1:0,name=ground,max_data=20000"]);


test("a question is deaf to a second touch, and its command is carried out once", async () => {
  const page = await here.open({ hash: "#/220/commands" });
  await page.waitForSelector(".command");
  const calls = async () => (await asked(page, "jobs")).jobs.filter((job) => job.kind === "command").length;
  const before = await calls();
  const isStillAsked = await page.evaluate(async () => {
    document.querySelector(".command:nth-child(4) button").click(); // HOVER
    while (!document.querySelector(".confirm .main")) await new Promise((drawn) => { setTimeout(drawn); });
    document.querySelector(".confirm .main").click(); // immediately
    await new Promise((drawn) => { setTimeout(drawn, 50); });
    return document.querySelector(".confirm") !== null;
  });
  assert.ok(isStillAsked);
  await confirm(page);
  await page.waitForSelector(".command:nth-child(4) .outcome:not(:empty):not(.muted)");
  assert.equal((await calls()) - before, 1);
  await page.browserContext().close();
});

test("values that are none of the declared type can't be sent", async () => {
  const page = await here.open({ hash: "#/220/commands" });
  await page.waitForSelector(".command input");
  await page.type(".command:nth-child(1) .values input", "65536"); // a u16
  await page.waitForFunction(() => document.querySelector(".command:nth-child(1) button").disabled);
  assert.match(await textOf(page, ".command:nth-child(1)"), /u16 0…65535/);
  await page.browserContext().close();
});

test("waypoints are added, written and read back", async () => {
  const page = await here.open({ hash: "#/220/waypoints" });
  await page.waitForSelector("table.waypoints tbody tr");
  await press(page, "Add one");
  await press(page, "Add one");
  await press(page, "Write to the device");
  await confirm(page);
  await page.waitForSelector("main .outcome.good");
  assert.equal((await asked(page, "devices/220/waypoints")).waypoints.length, 3);
  await page.browserContext().close();
});

test("a picture that was half gone by is not called lost", async () => {
  const page = await here.open({ hash: "#/images" });
  await page.waitForSelector("canvas.picture");
  await drawnAgain(page, "main figcaption", 3);
  assert.equal(await page.$("main figcaption .warn"), null);
  await page.browserContext().close();
});

test("a second touch on what begins a calibration begins no other, and hides nothing", async () => {
  const page = await here.open({ hash: "#/220/calibration" });
  await page.waitForSelector("main button.main");
  await page.$eval("main button.main", (button) => { button.click(); button.click(); }); // the second one arrives before the answer of the gateway
  await page.waitForFunction(() => [...document.querySelectorAll("main button")].some((one) => one.textContent === "Cancel and restore"));
  await drawnAgain(page, "main", 1).catch(() => undefined);
  assert.equal(await page.$("main p.bad[role=alert]"), null);
  assert.equal((await asked(page, "jobs")).jobs.filter((job) => job.kind === "calibration").length, 1);
  await press(page, "Cancel and restore");
  await page.waitForSelector("main p.bad[role=alert]");
  await page.browserContext().close();
});

async function begunCalibration(what) {
  const page = await here.open({ hash: "#/220/calibration" });
  await page.waitForSelector("main select");
  await page.select("main select", what);
  await press(page, "Start");
  await press(page, "Continue");
  await page.waitForSelector("main svg.solid");
  return page;
}

test("a calibration can be cancelled, and the old values come back", async () => {
  const page = await begunCalibration("accelerometer");
  await drawnAgain(page, "main .turning", 3);
  await shot(page, "accelerometer");
  await press(page, "Cancel and restore");
  await page.waitForSelector("main p.bad[role=alert]");
  assert.match(await textOf(page, "main p.bad[role=alert]"), /cancelled/);
  assert.equal((await asked(page, "devices/220/parameters/CAL_AOFF_X")).value, 0);
  await page.browserContext().close();
});

test("a calibration that nobody looks at goes on, and its end is told to who comes back", async () => {
  const page = await begunCalibration("compass");
  await go(page, "#/220/vehicle");
  await page.waitForSelector(".figure dd small");
  await go(page, "#/220/calibration");
  await page.waitForSelector("main svg.solid");
  await until("it ends", async () => /error before[^]*CAL_MOFF_X/.test(await textOf(page, "main")), 60000);
  await page.browserContext().close();
});

test("who only looks is offered nothing that acts on a device", { skip: process.getuid() !== 0 && "a user's own gateway asks for no token" }, async () => {
  const page = await here.open({ access: "view", hash: "#/220/parameters" });
  await page.waitForSelector(".set li input");
  assert.equal((await page.$$("main .set input:not(:disabled)")).length, 0);
  for (const name of ["vehicle", "parameters", "commands", "waypoints", "calibration", "firmware"]) {
    await go(page, "#/220/" + name);
    await page.waitForFunction((name) => document.querySelector('nav .roomy [aria-current="page"]')?.getAttribute("href") === "#/220/" + name && document.querySelector("main h1"), {}, name);
    assert.equal((await page.$$("main button.main, .pinned button")).length, 0, name);
  }
  const tried = await page.evaluate(() => fetch("devices/220/parameters/SIM_WIND", { method: "PUT", headers: { "Content-Type": "application/json" }, body: '{"value": 9}' }).then((answer) => answer.status));
  assert.equal(tried, 403);
  await page.browserContext().close();
});

test("a device whose every word is HTML, and 10 KB long, is shown in words", async () => {
  const page = await here.open({ width: 390, hash: "#/log" });
  const port = /udp-listen:127\.0\.0\.1:(\d+)|127\.0\.0\.1:(\d+)/.exec(JSON.stringify((await asked(page, "links")).find((link) => link.name === "ground")));
  const device = new HostileDevice(Number(port[1] ?? port[2]), `<img src=x onerror="window.hit=1"><script>window.hit=1</script>"'&`.repeat(160));
  try {
    await page.waitForFunction(() => document.querySelectorAll(".log li").length > 3);
    const signs = { "#/log": ".log li", "#/frames": ".rows li", "#/overview": ".who", "#/30/parameters": ".set li input", "#/30/vehicle": ".figure dd small", "#/30/commands": "h1" };
    for (const hash of Object.keys(signs)) {
      await go(page, hash);
      await page.waitForFunction((sign) => document.querySelector("main " + sign), {}, signs[hash]);
      assert.equal(await page.evaluate(() => document.querySelectorAll("#app img, #app script").length), 0, hash);
      assert.ok((await wider(page)) <= 0, hash + " is wider than the screen");
      await shot(page, "hostile-" + hash.replace(/\W+/g, ""));
    }
    assert.equal(await page.evaluate(() => window.hit), undefined);
    assert.deepEqual(page.faults, []);
  } finally {
    device.stop();
  }
  await page.browserContext().close();
});

const groundPort = async (page) => (await asked(page, "links")).find((link) => link.name === "ground").port;

test("2,000 parameters, called as the device likes, with values that are no numbers, are searched and written", async () => {
  const page = await here.open({ hash: "#/log" });
  const device = new LargeDevice(await groundPort(page), 2000);
  try {
    await until("it is heard", async () => (await asked(page, "devices")).devices.some((one) => Number(one.address) === 32));
    await go(page, "#/32/parameters");
    await page.waitForFunction(() => document.querySelectorAll(".set li").length === 2000, { timeout: 90000 });
    const shown = (id) => page.$eval("#parameter-" + id, (input) => input.value);
    assert.deepEqual(await Promise.all([0, 1, 3, 4, 5, 7, 8].map(shown)), ["1", "2", "nan", "1e+38", "-inf", "18446744073709551615", "-9223372036854775808"]);
    await shot(page, "parameters-2000");
    for (const [id, value] of [[0, "5"], [1, "6"], [3, "0"], [4, "-1e38"], [11, "9"]]) await type(page, "#parameter-" + id, value);
    await press(page, "Write changes (5)");
    await outcome(page, ".outcome", /✓ 5 written and read back/);
    assert.deepEqual([0, 1, 3, 10, 11].map((id) => device.values[id][2].readFloatLE()), [5, 6, 0, 10, 9]);
    assert.deepEqual([await shown(1), await shown(10), await shown(11)], ["6", "10", "9"]);
    assert.equal(await page.$eval("label[for=parameter-11] b", (label) => label.textContent), "TWICE#11");
    assert.equal(await page.$(".set li.changed"), null, "each is known to be written");
    await type(page, ".tools input[type=search]", "p_1999");
    await page.waitForFunction(() => document.querySelectorAll(".set li").length === 1);
    assert.deepEqual(page.faults, []);
  } finally {
    device.stop();
  }
  await page.browserContext().close();
});

test("says it on every page of a device when two claim to be it", async () => {
  const page = await here.open({ hash: "#/31/vehicle" });
  const port = /127\.0\.0\.1:(\d+)/.exec(JSON.stringify((await asked(page, "links")).find((link) => link.name === "ground")))[1];
  const both = [dgram.createSocket("udp4"), dgram.createSocket("udp4")];
  const speak = setInterval(() => { for (const one of both) one.send(frame(31, 255, 3, [0, 0, 0, 0, 0, 0, 0]), Number(port), "127.0.0.1"); }, 50);
  try {
    for (const hash of ["#/31/vehicle", "#/31/commands"]) {
      await go(page, hash);
      await page.waitForFunction(() => document.querySelector("main .clash b")?.textContent === "Two devices use the address 0x1F.");
      assert.ok(await page.$eval("main .clash", (note) => note.getBoundingClientRect().bottom < innerHeight));
    }
    await go(page, "#/220/vehicle");
    await page.waitForFunction(() => document.querySelector("main h1 small")?.textContent === "0xDC" && !document.querySelector(".clash"));
  } finally {
    clearInterval(speak);
    for (const one of both) one.close();
    await page.browserContext().close();
  }
});
