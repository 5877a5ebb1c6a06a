// Actions from start to end, and their failures.
import assert from "node:assert/strict";
import { createServer } from "node:http";
import { test } from "node:test";
import { confirm, choose, logIn, outcome, press, shot, textOf, type, until, wider, world } from "./gateway.mjs";

const here = world();

test("writes the parameters that were changed, and no other", async () => {
  const page = await here.open({ hash: "#/220/parameters" });
  await type(page, "#parameter-1", "7");
  await press(page, "Write changes (1)");
  await outcome(page, ".outcome", /✓ 1 written and read back/);
  assert.match(await textOf(page, "#parameter-1-text"), /stored: 7/);
  await type(page, "#parameter-1", "400");
  await outcome(page, "#parameter-1-text .fault", /must be -?\d+ to \d+/); // while typing, before anything is sent
  assert.ok(await page.$$eval("main button.main", (all) => all.find((one) => one.textContent === "Write changes (1)").disabled));
  await press(page, "back to 7");
  await choose(page, here.gateway, "backup.json", JSON.stringify({ parameters: { SIM_TURN: 0, SIM_SPEED: 300 } }));
  await press(page, "Use 1 from the file");
  await press(page, "Write changes (1)");
  await outcome(page, ".outcome", /✓ 1 written/);
  await press(page, "Save permanently");
  await outcome(page, ".outcome", /✓ Stored in the device/);
  await page.browserContext().close();
});

test("asks before a command, and lands by a button that is held", async () => {
  const page = await here.open({ hash: "#/220/commands" });
  await page.waitForSelector(".command");
  const call = async (n, values = []) => {
    for (const [i, value] of values.entries()) await type(page, `.command:nth-child(${n}) .values input[id$="-${i}"]`, value);
    await page.click(`.command:nth-child(${n}) button`);
    await confirm(page, `.command:nth-child(${n})`);
    await outcome(page, `.command:nth-child(${n}) .outcome`, /✓/);
  };
  await call(10); // UNLOCK
  await call(1, ["200"]); // TAKE_OFF
  await page.evaluate(() => (location.hash = "#/220/vehicle"));
  await outcome(page, ".flag", /airborne/);
  await shot(page, "flying");
  const button = await page.waitForSelector(".hold.land");
  const box = await button.boundingBox();
  await page.mouse.move(box.x + 9, box.y + 9);
  await page.mouse.down();
  await new Promise((resolve) => setTimeout(resolve, 200)); // a touch that is too short
  await page.mouse.up();
  assert.doesNotMatch(await textOf(page, ".pinned"), /LAND/);
  const finger = await page.target().createCDPSession();
  const touch = (type, ...touchPoints) => finger.send("Input.dispatchTouchEvent", { type, touchPoints });
  await touch("touchStart", { x: box.x + 9, y: box.y + 9 });
  await page.waitForSelector(".hold.land.held");
  await touch("touchMove", { x: box.x + 9, y: box.y - 60 }); // the finger moves off the button
  await page.waitForSelector(".hold.land:not(.held)");
  await touch("touchEnd");
  await new Promise((resolve) => setTimeout(resolve, 1000));
  assert.doesNotMatch(await textOf(page, ".pinned"), /LAND/);
  await page.mouse.down();
  await outcome(page, ".pinned", /✓ LAND/);
  await page.mouse.up();
  await outcome(page, ".flag", /^(locked|unlocked)$/);
  await page.browserContext().close();
});

test("warns of a file of another device", async () => {
  const page = await here.open({ hash: "#/220/parameters" });
  await page.waitForSelector(".set li");
  await choose(page, here.gateway, "own.json", JSON.stringify({ device: "0xDC", name: "SimFC", parameters: { SIM_TURN: 1 } }));
  await page.waitForFunction(() => [...document.querySelectorAll("main option")].some((one) => one.value === "file"));
  assert.equal(await page.$("main .stranger"), null);
  await choose(page, here.gateway, "other.json", JSON.stringify({ device: "0xDD", name: "SimIMU", parameters: { SIM_TURN: 1 } }));
  await page.waitForSelector("main .stranger");
  assert.match(await textOf(page, "main .stranger"), /The file is from SimIMU/);
  await page.browserContext().close();
});

test("sends a frame, and says by which links it left", async () => {
  const page = await here.open({ hash: "#/frames" });
  await press(page, "Send a frame");
  await page.waitForSelector("form .main");
  await page.click("form .main");
  await outcome(page, "form [role=status]", /Sent to fc, imu; not sent to absent \(the link was down\)/);
  await page.browserContext().close();
});

test("calibrates a compass", async () => {
  const page = await here.open({ hash: "#/221/calibration" });
  await page.waitForSelector("main select");
  await page.select("main select", "compass");
  await press(page, "Start");
  await press(page, "Continue");
  await page.waitForSelector(".halves polygon.filled");
  await shot(page, "compass");
  await until("it ends", async () => /✓ Calibrated/.test(await textOf(page, "main")), 60000);
  await page.browserContext().close();
});

/** Milliseconds from `act` until the page has drawn that the gateway is lost, by the page's clock, and the delay of its timers within that time, which other load of the computer causes. */
async function lostAfter(page, act) {
  await page.evaluate(() => {
    const every = 10;
    let last = performance.now();
    window.contact = { late: 0, seen: new Promise((drawn) => {
      const timer = setInterval(() => {
        const now = performance.now();
        window.contact.late += Math.max(0, now - last - every);
        last = now;
        if (!document.querySelector(".contact.lost")) return;
        clearInterval(timer);
        requestAnimationFrame(() => drawn(performance.timeOrigin + performance.now()));
      }, every);
    }) };
  });
  const began = await page.evaluate(() => { window.contact.late = 0; return performance.timeOrigin + performance.now(); });
  act(); // later than `began`
  const seen = await page.evaluate(() => window.contact.seen);
  return { took: seen - began, late: await page.evaluate(() => window.contact.late) };
}

test("sees within a second that the gateway is silent or gone, and that it is back", async () => {
  const page = await here.open({ hash: "#/220/vehicle" });
  for (const [signal, back] of [["SIGSTOP", () => here.gateway.process.kill("SIGCONT")], ["SIGKILL", () => here.gateway.runAgain()]])
    for (const [hash, sign] of [["#/220/vehicle", ".figure dd small"], ["#/overview", ".branch"]]) {
      await page.evaluate((hash) => { location.hash = hash; }, hash);
      await page.waitForSelector(sign);
      await page.waitForSelector(".contact.live");
      const { took, late } = await lostAfter(page, () => here.gateway.process.kill(signal));
      console.log(`${signal} on ${hash}: seen after ${took.toFixed(0)} ms, of which the page's timers were late by ${late.toFixed(0)} ms`);
      assert.ok(took - late <= 1000, `${signal}: seen after ${took} ms, of which ${late} ms were others'`);
      await shot(page, "lost");
      await back();
      await page.waitForSelector(".contact.live");
    }
  await page.evaluate(() => { location.hash = "#/220/vehicle"; });
  await page.waitForSelector(".figure dd small");
  await here.gateway.restart();
  await page.waitForSelector(".contact.live");
  await until("values come again", () => page.$eval(".figure", (figure) => !figure.classList.contains("late-value")).catch(() => false));
  await page.browserContext().close();
});

test("tells who has no token, a wrong one, or one to look only", { skip: process.getuid() !== 0 && "a user's own gateway asks for none" }, async () => {
  const page = await here.open({ access: null });
  await page.waitForSelector(".login input");
  await page.type(".login input", "wrong");
  await page.click(".login button");
  await outcome(page, "[role=alert]", /Wrong token/);
  await logIn(page, here.gateway.token("view"));
  await page.waitForSelector(".branch");
  assert.match(await textOf(page, ".note"), /Read-only: this token/);
  assert.equal(await page.$(".scan"), null, "what it may not is not offered");
  const status = await page.evaluate(() => fetch("send", { method: "POST", headers: { "Content-Type": "application/json" }, body: "{}" }).then((answer) => answer.status));
  assert.equal(status, 403);
  await page.click(".only-view button");
  await logIn(page, here.gateway.token("control"));
  await page.waitForFunction(() => !document.querySelector(".only-view, .login"));
  assert.ok(await page.waitForSelector(".scan"), "what it may now is offered");
  await page.click(".sign-out");
  await page.waitForSelector(".login input");
  await page.reload();
  await page.waitForSelector(".login input", { timeout: 10000 });
  assert.equal(await page.evaluate(() => fetch("status").then((answer) => answer.status)), 401, "the cookie is gone");
  await page.browserContext().close();
});

test("shows as words what a device says, whatever that is", async () => {
  const page = await here.open({ hash: "#/log" });
  await page.waitForSelector("h1");
  const html = '<img src=x onerror="window.hit=1"><script>window.hit=1</script>';
  const send = (str) => page.evaluate((str) => fetch("send", { method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify({ from: 77, to: 255, name: "log", fields: { color: 1, str } }) }).then((answer) => answer.status), str);
  await until("the page listens", async () => (await send("heard?")) === 200 && page.$(".log li"));
  page.faults.length = 0; // a busy gateway may have refused the first ones
  assert.equal(await send(html), 200);
  assert.equal(await send("x".repeat(4000)), 200);
  await outcome(page, ".log", /<img src=x/);
  assert.ok((await wider(page)) <= 0);
  assert.equal(await page.evaluate(() => window.hit), undefined);
  assert.deepEqual(page.faults, []);
  await shot(page, "hostile-log");
  await page.browserContext().close();
});

test("a page of another origin gets nothing, by fetch, WebSocket or frame", async () => {
  const other = createServer((_, response) => response.setHeader("Content-Type", "text/html").end("<h1>another</h1>"));
  await new Promise((resolve) => other.listen(0, "127.0.0.1", resolve));
  const own = await here.open();
  const page = await own.browserContext().newPage();
  await page.goto(`http://127.0.0.1:${other.address().port}/`);
  const got = await page.evaluate(async (address) => {
    const asked = await fetch(address + "/status", { credentials: "include" }).then((answer) => answer.status).catch(() => "refused");
    const posted = await fetch(address + "/send", { method: "POST", mode: "no-cors", credentials: "include", body: "{}" }).then((answer) => answer.type).catch(() => "refused");
    const opened = await new Promise((resolve) => {
      const socket = new WebSocket(address.replace("http", "ws") + "/frames");
      socket.onopen = () => resolve("open");
      socket.onerror = () => resolve("refused");
    });
    return { asked, posted, opened };
  }, here.gateway.address);
  assert.deepEqual(got, { asked: "refused", posted: "opaque", opened: "refused" });
  other.close();
  await own.browserContext().close();
});
