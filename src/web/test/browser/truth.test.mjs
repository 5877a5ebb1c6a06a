// The operator sees the true state: lost devices, values beyond their limits, errors that devices log.
import assert from "node:assert/strict";
import dgram from "node:dgram";
import { test } from "node:test";
import { asked, go, outcome, press, shot, textOf, type, until, world } from "./gateway.mjs";
import { FlyingDevice, frame } from "./hostile_device.mjs";

const here = world(["sim:imu", "udp-listen:127.0.0.1:0,name=ground", "udp-listen:127.0.0.1:0,name=field", "--route", "0x35=ground", "--route", "0x39=ground"]);
const groundPort = async (page) => (await asked(page, "links")).find((link) => link.name === "ground").port;

/** Waits until the title of the page matches `words`. */
async function titled(page, words) {
  let title = "";
  await until(`a title ${words}`, async () => words.test((title = await page.title()))).catch((error) => {
    throw new Error(`${error.message}; it is "${title}"`);
  });
}

/** Counts sounds and vibrations. */
const withEars = (page) => page.evaluate(() => {
  window.heard = { tones: 0, shakes: 0 };
  const start = OscillatorNode.prototype.start;
  OscillatorNode.prototype.start = function (...when) { ++window.heard.tones; return start.apply(this, when); };
  Object.defineProperty(navigator, "vibrate", { configurable: true, value: () => { ++window.heard.shakes; return true; } });
});

/** Milliseconds from `act` until all of `signs` (functions in the page) are true, by the page's clock, without the time for which the page's timers were late. */
async function shownAfter(page, signs, act) {
  await page.evaluate((signs) => {
    const all = signs.map((sign) => new Function("return " + sign));
    let last = performance.now();
    window.watch = { late: 0, seen: new Promise((done) => {
      const timer = setInterval(() => {
        const now = performance.now();
        window.watch.late += Math.max(0, now - last - 10);
        last = now;
        if (!all.every((sign) => sign())) return;
        clearInterval(timer);
        requestAnimationFrame(() => done(performance.now()));
      }, 10);
    }) };
  }, signs);
  const began = await page.evaluate(() => { window.watch.late = 0; return performance.now(); });
  act();
  const seen = await page.evaluate(() => window.watch.seen);
  return { took: seen - began, late: await page.evaluate(() => window.watch.late) };
}

for (const [width, height] of [[1440, 900], [390, 844]])
  test(`a vehicle that is killed in flight looks lost within 1 s and two periods, at ${width}×${height}`, async () => {
    const page = await here.open({ hash: "#/50/vehicle", width, height });
    const device = new FlyingDevice(await groundPort(page));
    try {
      await outcome(page, ".flag", /^airborne$/);
      await titled(page, /^Vehicle · Falcon$/);
      await outcome(page, ".contact-of-device.live", /Falcon .*\/s · 0\.\d s/);
      await new Promise((done) => setTimeout(done, 1500)); // its period is known
      await page.mouse.click(5, height - 200); // browsers allow sounds after a touch
      await withEars(page);
      await shot(page, `alive-${width}`);
      const { took, late } = await shownAfter(page, [
        "document.querySelector('main.old') && document.querySelector('.contact-of-device.lost')",
        "[...document.querySelectorAll('.vehicle .figure')].filter((one) => one.querySelector('small')).every((one) => one.classList.contains('late-value'))",
        "document.querySelector('.horizon.late-drawing, .late-drawing') && document.querySelector('.late-bars') && !document.querySelector('.modules .good')",
        "/Falcon no data for/.test(document.querySelector('.alerts li.lost')?.textContent)",
        "/^⚠ No data from Falcon/.test(document.title)",
        "window.heard.tones > 0 && window.heard.shakes > 0",
      ], () => device.kill());
      const most = 1000 + 2 * device.period();
      console.log(`a killed vehicle at ${width}: shown after ${took.toFixed(0)} ms, of which timers were late by ${late.toFixed(0)} ms; ${most.toFixed(0)} ms are allowed`);
      assert.ok(took - late <= most, `${took} ms, of which ${late} ms were late timers; ${most} ms are allowed`);
      assert.match(await outcome(page, ".flag", /airborne \d+ s ago/), /airborne \d+ s ago/);
      assert.match(await textOf(page, ".contact-of-device"), /no data for \d+ s/);
      assert.match(await textOf(page, ".contact.live"), /live/, "the gateway is there");
      await shot(page, `killed-${width}`);
      await go(page, "#/frames"); // on any page
      await outcome(page, ".alerts li.lost", /Falcon no data for \d+ s.*last state: airborne/);
      await until("it sounds again", () => page.evaluate(() => window.heard.shakes > 1), 10000);
      await press(page, "Silence");
      await until("it is silent", async () => !(await page.$(".silence")));
      device.fly();
      await until("all is well again", async () => !(await page.$(".alerts")) && !(await page.title()).startsWith("⚠"));
      assert.deepEqual(page.faults, []);
    } finally {
      device.stop();
      await page.browserContext().close();
    }
  });

/** Opens another tab in front: the browser slows down the timers of `page`, and stops drawing it. */
async function hide(page) {
  const other = await page.browserContext().newPage();
  await other.goto("about:blank");
  await other.bringToFront();
  await until("it is hidden", () => page.evaluate(() => document.hidden));
  return other;
}

test("a page behind another tab tells by title, sound and vibration which vehicle is lost, until it is heard again; so a value beyond its limit", async () => {
  const page = await here.open({ hash: "#/59/vehicle" });
  const device = new FlyingDevice(await groundPort(page), { address: 59, name: "Hawk" });
  try {
    await outcome(page, ".flag", /^airborne$/);
    await titled(page, /^Vehicle · Hawk$/);
    await new Promise((done) => setTimeout(done, 1500)); // its period is known
    await page.mouse.click(5, 600); // browsers allow sounds after a touch
    await withEars(page);
    const other = await hide(page);
    await page.evaluate(() => {
      window.titles = [];
      new MutationObserver(() => window.titles.push({ at: performance.now(), title: document.title })).observe(document.querySelector("title"), { childList: true });
    });
    await new Promise((done) => setTimeout(done, 3000));
    assert.deepEqual(await page.evaluate(() => window.titles), [], "that no frames come is no loss");
    const began = await page.evaluate(() => performance.now());
    device.kill();
    await titled(page, /^⚠ No data from Hawk/);
    const took = (await page.evaluate(() => window.titles[0].at)) - began;
    console.log(`a vehicle killed behind another tab: the title says so after ${took.toFixed(0)} ms`);
    assert.match((await page.evaluate(() => window.titles[0].title)), /^⚠ No data from Hawk/, "nothing else before");
    await until("it sounds and shakes, more than once", () => page.evaluate(() => window.heard.tones > 4 && window.heard.shakes > 1));
    assert.match(await textOf(page, ".alerts li.lost[data-device='59']"), /Hawk no data for .*last state: airborne/);
    assert.ok(await page.evaluate(() => document.hidden));
    device.fly();
    await titled(page, /^Vehicle · Hawk$/);
    assert.ok(await page.evaluate(() => document.hidden));
    const limits = (list) => asked(page, "devices/59/limits", { method: "PUT", headers: { "Content-Type": "application/json" }, body: JSON.stringify({ limits: list }) });
    await limits([{ field: "power.voltage", side: "below", red: 14 }]); // by another client, while the page is hidden
    device.voltage = 13.2;
    await titled(page, /^⚠ Hawk: battery/);
    await limits([]);
    await titled(page, /^Vehicle · Hawk$/);
    device.kill();
    await titled(page, /^⚠ No data from Hawk/);
    await other.close();
    await page.bringToFront();
    await page.waitForSelector("main.old .alerts li.lost[data-device='59']");
    device.fly();
    await until("all is well again", async () => !(await page.$(".alerts")) && (await page.title()) === "Vehicle · Hawk");
    assert.deepEqual(page.faults, []);
  } finally {
    device.stop();
    await page.browserContext().close();
  }
});

test("a page behind another tab tells that the gateway is gone, and finds it again", async () => {
  const page = await here.open({ hash: "#/overview" });
  try {
    await page.waitForSelector(".contact.live");
    const well = await until("its title", async () => /^Overview/.test(await page.title()) && page.title());
    await hide(page);
    await here.gateway.stop();
    const began = performance.now();
    await until("a title", async () => /^⚠ The gateway does not answer/.test(await page.title()), 10000);
    console.log(`the gateway ended behind another tab: the title says so after ${(performance.now() - began).toFixed(0)} ms`);
    await here.gateway.runAgain();
    await until("the title of before", async () => (await page.title()) === well);
    assert.ok(await page.evaluate(() => document.hidden));
    here.gateway.process.kill("SIGSTOP"); // no connection is closed
    await until("a title", async () => /^⚠ The gateway does not answer/.test(await page.title()));
    here.gateway.process.kill("SIGCONT");
    await until("the title of before", async () => (await page.title()) === well);
    assert.ok(await page.evaluate(() => document.hidden));
  } finally {
    here.gateway.process.kill("SIGCONT");
    await page.browserContext().close();
  }
});

test("a device of which only its log is left is lost as soon as that ends", async () => {
  const page = await here.open({ hash: "#/60/vehicle" });
  const device = new FlyingDevice(await groundPort(page), { address: 60, name: "Rook" });
  try {
    await outcome(page, ".flag", /^airborne$/);
    await new Promise((done) => setTimeout(done, 1500));
    device.kill();
    const sentAt = [];
    const say = () => { sentAt.push(performance.now()); device.log("still here", 0); };
    const lines = setInterval(say, 200);
    await until("some lines", () => sentAt.length > 20);
    assert.equal(await page.$(".contact-of-device.lost"), null);
    const { took, late } = await shownAfter(page, ["document.querySelector('main.old') && document.querySelector('.contact-of-device.lost')"], () => { clearInterval(lines); say(); });
    const most = 1000 + 2 * Math.max(...sentAt.slice(-9).map((at, i, all) => (i > 0 ? at - all[i - 1] : 0)));
    console.log(`the log of a device ended: shown after ${took.toFixed(0)} ms, of which timers were late by ${late.toFixed(0)} ms; ${most.toFixed(0)} ms are allowed`);
    assert.ok(took - late <= most, `${took} ms, of which ${late} ms were late timers; ${most} ms are allowed`);
    await outcome(page, ".alerts li.lost[data-device='60']", /no data for/);
  } finally {
    device.stop();
    await page.browserContext().close();
  }
});

test("a page that is opened after the loss of a vehicle tells it, and its last state; also behind a reload and a dismissal", async () => {
  const before = await here.open({ hash: "#/overview" });
  const device = new FlyingDevice(await groundPort(before), { address: 58, name: "Swift" });
  const lost = ".alerts li.lost[data-device='58']";
  try {
    await until("it is heard", async () => (await asked(before, "devices")).devices.some((one) => Number(one.address) === 58));
    device.kill();
    await until("the gateway knows", async () => (await asked(before, "devices")).lost?.some((one) => one.address === "0x3A" && one.sflag === 2));
    const page = await here.open({ hash: "#/58/vehicle" });
    await outcome(page, ".flag", /airborne \d+ s ago/);
    await outcome(page, lost, /no data for \d+ s.*last state: airborne/);
    assert.match(await page.title(), /^⚠ No data from/);
    await page.waitForSelector("main.old");
    await page.waitForSelector(".contact-of-device.lost");
    await shot(page, "lost-before");
    await page.click(lost + " button");
    await until("it is dismissed", async () => !(await page.$(lost)));
    for (const visit of ["the same", "the next"]) {
      await outcome(page, ".flag", /airborne \d+ s ago/);
      await page.waitForSelector("main.old");
      await outcome(page, ".contact-of-device.lost", /no data for \d+ s/);
      assert.equal(await page.$(lost), null, visit);
      await page.reload();
      await page.waitForSelector("main h1");
    }
    await outcome(before, lost, /last state: airborne/); // dismissed in another browser
    device.fly();
    await until("it is back", async () => !(await page.$("main.old")) && (await textOf(page, ".flag")) === "airborne");
    assert.deepEqual(page.faults, []);
    await page.browserContext().close();
  } finally {
    device.stop();
    await before.browserContext().close();
  }
});

test("what a stranger sends in the name of a vehicle is not shown, hides no loss, and the note says so", async () => {
  const page = await here.open({ hash: "#/57/vehicle" });
  const device = new FlyingDevice(await groundPort(page), { address: 57, name: "Wren" });
  const field = (await asked(page, "links")).find((link) => link.name === "field").port;
  const stranger = new FlyingDevice(field, { address: 57, name: "Cuckoo", voltage: 9.99 });
  const battery = () => page.$$eval(".figure", (all) => all.map((one) => one.textContent).find((text) => /battery/i.test(text)));
  try {
    await outcome(page, "main .clash", /It is pinned to ground: this page shows the data from there, and commands go there/);
    assert.doesNotMatch(await textOf(page, "main .clash"), /either/);
    await until("its battery", async () => /15\.20/.test(await battery()));
    for (let i = 0; i < 50; ++i) {
      assert.match(await battery(), /15\.20/);
      await new Promise((done) => setTimeout(done, 20));
    }
    device.kill();
    await outcome(page, ".alerts li.lost[data-device='57']", /no data for \d+ s/);
    await page.waitForSelector("main.old");
    stranger.log("FORGED");
    await new Promise((done) => setTimeout(done, 1000));
    assert.equal((await asked(page, "devices/57/log")).lines.length, 0);
    assert.equal(await page.$(".strip"), null);
    await shot(page, "forged-lost");
  } finally {
    device.fly();
    await until("it is heard again", async () => !(await page.$(".alerts li.lost[data-device='57']")));
    device.stop();
    stranger.stop();
    await page.browserContext().close();
  }
});

test("a vehicle that changes its rates, or sends rarely, is not called lost; one that was switched off can be dismissed", async () => {
  const page = await here.open({ hash: "#/overview" });
  const device = new FlyingDevice(await groundPort(page), { address: 51, name: "Slow" });
  try {
    await until("it is heard", () => page.$$eval(".who", (all) => all.some((one) => one.textContent.includes("0x33"))));
    device.kill();
    const slowly = setInterval(() => device.send(0x06, [3, 1, 0, 0, 0]), 1500);
    await new Promise((done) => setTimeout(done, 5000));
    await page.evaluate(() => { window.lostSeen = 0; new MutationObserver(() => { if (document.querySelector(".alerts li[data-device='51']")) ++window.lostSeen; }).observe(document.body, { subtree: true, childList: true }); });
    await until("no line of it", async () => !(await page.$(".alerts li[data-device='51']")));
    await new Promise((done) => setTimeout(done, 5000));
    assert.ok((await page.evaluate(() => window.lostSeen)) === 0);
    clearInterval(slowly);
    await page.waitForSelector(".alerts li[data-device='51']");
    await page.click(".alerts li[data-device='51'] button");
    await until("it is dismissed", async () => !(await page.$(".alerts li[data-device='51']")));
  } finally {
    device.stop();
    await page.browserContext().close();
  }
});

test("a value beyond its limit is amber, then red, on every page and for all who look; the limits survive a restart", async () => {
  const page = await here.open({ hash: "#/52/alarms" });
  const device = new FlyingDevice(await groundPort(page), { address: 52, name: "Owl" });
  try {
    await press(page, "+ Voltage per cell");
    await page.waitForSelector(".limit input");
    await shot(page, "alarms-new");
    await type(page, ".limit label:nth-of-type(3) input", "3.7"); // red beyond amber is refused while typing
    await outcome(page, ".limit .fault", /Red must be beyond amber/);
    assert.ok(await page.$eval("main button.main", (button) => button.disabled));
    await type(page, ".limit label:nth-of-type(3) input", "3.4");
    await press(page, "+ Satellites");
    await press(page, "Save limits");
    await outcome(page, "main .outcome", /✓ Saved in the gateway/);
    assert.equal((await asked(page, "devices/52/limits")).limits.length, 2);
    const other = await here.open({ hash: "#/frames", width: 390, height: 844 }); // another client, which set nothing
    await other.mouse.click(5, 800);
    await withEars(other);
    device.voltage = 14.2; // 3.55 V a cell
    await outcome(other, ".alerts li.amber", /Voltage per cell 3\.55 V below 3\.60 V/);
    assert.match(await other.title(), /^⚠ .*Voltage per cell/);
    device.voltage = 13.2;
    await outcome(other, ".alerts li.red", /Voltage per cell 3\.30 V below 3\.40 V/);
    await until("it sounds and shakes", () => other.evaluate(() => window.heard.tones > 0 && window.heard.shakes > 0));
    await page.waitForSelector(".limit.red");
    await shot(other, "alarm-red-390");
    await shot(page, "alarms-red");
    const late = await here.open({ hash: "#/overview" }); // opened after the value arrived: the gateway evaluates it, not the page
    await outcome(late, ".alerts li.red", /Voltage per cell 3\.30 V below 3\.40 V/);
    await late.browserContext().close();
    device.voltage = 15.2;
    await until("all is well", async () => !(await other.$(".alerts li")));
    await here.gateway.restart();
    await page.waitForSelector(".contact.live");
    assert.equal((await asked(page, "devices/52/limits")).limits.length, 2, "kept over a restart");
    assert.deepEqual(page.faults.filter((one) => !/WebSocket|Failed to load/.test(one)), []);
    await other.browserContext().close();
  } finally {
    device.stop();
    await page.browserContext().close();
  }
});

test("an alarm of a device that was switched off is shown with its age, and can be dismissed until its value comes again", async () => {
  const page = await here.open({ hash: "#/55/alarms" });
  const device = new FlyingDevice(await groundPort(page), { address: 55, name: "Kite", voltage: 13.2 });
  const alarm = ".alerts li.beyond[data-device='55']";
  try {
    await press(page, "+ Voltage per cell");
    await press(page, "Save limits");
    await outcome(page, alarm, /below 3\.40 V/);
    assert.equal(await page.$(alarm + " button"), null);
    device.kill();
    await outcome(page, alarm, /below 3\.40 V · last value 1\d s ago/);
    await page.click(alarm + " button");
    await until("it is dismissed", async () => !(await page.$(alarm)));
    await page.reload();
    await page.waitForSelector("main h1");
    await new Promise((done) => setTimeout(done, 2000));
    assert.equal(await page.$(alarm), null, "in this browser");
    device.fly();
    await outcome(page, alarm, /below 3\.40 V$/);
  } finally {
    device.stop();
    await page.browserContext().close();
  }
});

test("the charge of the battery in percent has a limit of its own where a message tells it", async () => {
  const page = await here.open({ hash: "#/56/alarms" });
  const device = new FlyingDevice(await groundPort(page), { address: 56, name: "Lark" });
  try {
    await until("it is heard", async () => (await asked(page, "devices")).devices.some((one) => Number(one.address) === 56));
    const percent = () => page.$$eval("main button", (all) => all.find((one) => /Battery percentage/.test(one.textContent))?.disabled);
    await until("no message tells it", async () => (await percent()) === true);
    await asked(page, "flexible", { method: "PUT", headers: { "Content-Type": "application/json" }, body: JSON.stringify([{ id: "0xF1", fields: [{ name: "battery", type: "u8", unit: "%" }] }]) });
    await until("a message tells it", async () => (await percent()) === false);
    await press(page, "+ Battery percentage");
    await press(page, "Save limits");
    await outcome(page, "main .outcome", /✓ Saved in the gateway/);
    device.send(0xf1, [12]);
    await outcome(page, ".alerts li.beyond[data-device='56']", /flexible1\.battery 12 % below 15 %/);
  } finally {
    device.stop();
    await page.browserContext().close();
  }
});

test("a host that sent a single frame is shown as listening", async () => {
  const page = await here.open({ hash: "#/overview" });
  const host = dgram.createSocket("udp4"), ground = await groundPort(page);
  try {
    await new Promise((done) => host.send(frame(0xfe, 0xff, 0xe0, [0, 0, 0, 0, 0]), ground, "127.0.0.1", done));
    const peer = `127.0.0.1:${host.address().port}`;
    await until("it is listening", () => page.$$eval(".peers li", (all, peer) => all.some((one) => one.textContent.includes(peer) && /listening for \d+ s/.test(one.textContent)), peer));
    await shot(page, "listening-since");
  } finally {
    host.close();
    await page.browserContext().close();
  }
});

test("red lines of a device are a strip and a count on every page; the gateway has those that nobody saw", async () => {
  const page = await here.open({ hash: "#/overview" });
  const device = new FlyingDevice(await groundPort(page), { address: 53, name: "Crow" });
  try {
    assert.equal(await page.$(".strip"), null);
    await page.waitForSelector(".branch");
    await until("it is heard", () => page.$$eval(".who", (all) => all.some((one) => one.textContent.includes("0x35"))));
    for (const n of [1, 2, 3]) device.log(`motor ${n} stalls`);
    device.log("ready", 2);
    await outcome(page, ".strip", /errors logged: 3.*motor 3 stalls/);
    await shot(page, "red-strip");
    await go(page, "#/frames");
    await outcome(page, ".strip", /errors logged: 3/);
    const late = await here.open({ hash: "#/log" }); // opened after the lines were sent
    await outcome(late, ".log", /motor 1 stalls/);
    assert.equal(await late.$$eval(".log li", (all) => all.filter((one) => /motor \d stalls|ready/.test(one.textContent)).length), 4);
    assert.equal((await asked(late, "devices/53/log")).red, 3);
    await late.browserContext().close();
    await page.evaluate(() => {
      window.followed = [];
      new WebSocket(location.origin.replace(/^http/, "ws") + "/devices/53/log").onmessage = (event) => window.followed.push(JSON.parse(event.data).text);
    });
    await page.click(".strip button");
    await until("it is dismissed", async () => !(await page.$(".strip")));
    await new Promise((done) => setTimeout(done, 3000)); // the gateway still counts them
    assert.equal(await page.$(".strip"), null);
    device.log("motor 4 stalls");
    await outcome(page, ".strip", /errors logged: 1.*motor 4 stalls/);
    await until("the log is a stream: the lines before, then each that comes", () => page.evaluate(() => window.followed.join() === "motor 1 stalls,motor 2 stalls,motor 3 stalls,ready,motor 4 stalls"));
  } finally {
    device.stop();
    await page.browserContext().close();
  }
});

test("texts of a device are isolated, and none of their characters is invisible", async () => {
  const page = await here.open({ hash: "#/log" });
  const device = new FlyingDevice(await groundPort(page), { address: 54, name: "Re\u202eKIN" });
  try {
    await until("it is heard", async () => (await asked(page, "devices")).devices.some((one) => Number(one.address) === 54));
    await until("its line", async () => {
      device.log("all \u202e\u2066well\u200b \u2069\u0085", 2);
      return page.$$eval(".log li", (all) => all.some((one) => one.textContent.includes("all ")));
    });
    assert.ok(await page.$$eval(".log li bdi", (all) => all.some((one) => one.textContent.includes("all "))));
    await go(page, "#/54/vehicle");
    await asked(page, "devices/scan", { method: "POST", headers: { "Content-Type": "application/json" }, body: "{}" }); // the device's name
    await outcome(page, "main h1 bdi", /KIN/);
    for (const hash of ["#/log", "#/frames", "#/54/vehicle", "#/54/commands", "#/overview"]) {
      await go(page, hash);
      await page.waitForSelector("main h1");
      await new Promise((done) => setTimeout(done, 500));
      assert.equal(await page.evaluate(() => /[\u202a-\u202e\u2066\u2067\u200b\u0080-\u009f]/.test(document.body.innerText + document.title)), false, hash);
    }
  } finally {
    device.stop();
    await page.browserContext().close();
  }
});
