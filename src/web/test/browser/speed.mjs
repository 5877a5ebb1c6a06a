// How fast the page is: ANOGATED=PATH npm run speed
// Prints figures, and judges none: they are of this computer and of what else it does.
import { readFileSync } from "node:fs";
import { Gateway, openBrowser, openPage } from "./gateway.mjs";

const fields = { 1: ["acc_x", "acc_y", "acc_z", "gyr_x", "gyr_y", "gyr_z"], 3: ["rol", "pit", "yaw"], 4: ["v0"] };
const chosen = [220, 221].flatMap((from) => Object.entries(fields).flatMap(([id, names]) => names.map((field) => ({ from, id: Number(id), field }))));
const pause = (seconds) => new Promise((done) => { setTimeout(done, seconds * 1000); });
const median = (all) => [...all].sort((a, b) => a - b)[Math.floor(all.length / 2)];
const percent = (share) => `${(share * 100).toFixed(1)} %`;

/** Seconds of the processor that a process has used. */
function used(pid) {
  const words = readFileSync(`/proc/${pid}/stat`, "utf8").split(") ")[1].split(" ");
  return (Number(words[11]) + Number(words[12])) / 100;
}

async function charts(browser, gateway) {
  const page = await openPage(browser, gateway);
  await page.evaluate((kept) => localStorage.setItem("anogate.charts", kept), JSON.stringify(chosen));
  await page.goto(gateway.address + "/?charts#/charts");
  await page.waitForSelector(".uplot");
  return page;
}

const framesIn = (page) => page.evaluate(() => fetch("links").then((answer) => answer.json()).then((links) => links.reduce((sum, link) => sum + link.frames_in, 0)));

/** What of a processor the gateway takes, and frames a second that it routes, for so many seconds. */
async function costs(gateway, counter, seconds) {
  const [before, frames, began] = [used(gateway.process.pid), await framesIn(counter), performance.now()];
  await pause(seconds);
  const took = (performance.now() - began) / 1000;
  return { processor: (used(gateway.process.pid) - before) / took, frames: ((await framesIn(counter)) - frames) / took };
}

/** With and without a page that looks, in turns: what else the computer does is in both. */
async function inTurns(browser, gateway, counter) {
  const alone = [], watched = [];
  for (let round = 0; round < 5; ++round) {
    alone.push(await costs(gateway, counter, 3));
    const page = await openPage(browser, gateway, { hash: "#/220/vehicle" });
    await page.waitForSelector(".figure dd small");
    watched.push(await costs(gateway, counter, 3));
    await page.browserContext().close();
  }
  const of = (all, name) => median(all.map((one) => one[name]));
  console.log(`gateway: ${percent(of(alone, "processor"))} of a core without a page, ${percent(of(watched, "processor"))} with one, ${(of(watched, "processor") / of(alone, "processor")).toFixed(2)} times that; frames/s in: ${of(alone, "frames").toFixed(0)} and ${of(watched, "frames").toFixed(0)}`);
}

async function drawing(page, gateway) {
  const session = await page.createCDPSession();
  await session.send("Performance.enable", { timeDomain: "threadTicks" }); // not while others have the processor
  const busy = async () => Object.fromEntries((await session.send("Performance.getMetrics")).metrics.map((one) => [one.name, one.value])).TaskDuration;
  const [frames, tasks] = [await framesIn(page), await busy()];
  const drawn = await page.evaluate(() => new Promise((done) => {
    let n = 0;
    const began = performance.now();
    const count = () => (performance.now() - began >= 5000 ? done(n / 5) : (++n, requestAnimationFrame(count)));
    requestAnimationFrame(count);
  }));
  console.log(`${chosen.length} series, ${(((await framesIn(page)) - frames) / 5).toFixed(0)} frames/s in: drawn ${drawn.toFixed(0)} times/s, main thread ${percent(((await busy()) - tasks) / 5)} of a core`);
}

/** Questions and frames in so many seconds, of a tab that nobody sees. */
async function hidden(browser, gateway) {
  const page = await charts(browser, gateway);
  const session = await page.createCDPSession();
  let asked = 0, came = 0;
  await session.send("Network.enable");
  await page.evaluate(() => {
    Object.defineProperty(document, "hidden", { configurable: true, get: () => true });
    document.dispatchEvent(new Event("visibilitychange"));
  });
  await pause(1);
  session.on("Network.requestWillBeSent", () => ++asked);
  session.on("Network.webSocketFrameReceived", () => ++came);
  await pause(5);
  console.log(`hidden for 5 s: ${asked} questions, ${came} messages`);
  await page.browserContext().close();
}

async function fourPages(browser, gateway, first) {
  const others = [];
  for (let i = 0; i < 3; ++i) others.push(await charts(browser, gateway));
  await pause(4);
  const lost = await Promise.all([first, ...others].map((one) => one.evaluate(() => document.querySelector("main .note.warn")?.textContent ?? "")));
  console.log(`four pages at once: ${lost.every((words) => words === "") ? "none lost a frame" : lost.filter(Boolean).join("; ")}`);
  for (const one of others) await one.browserContext().close();
}

/** A page is there as soon as it has values. */
async function opening(page, gateway) {
  const took = [];
  for (let i = 0; i < 5; ++i) {
    const began = performance.now();
    await page.goto(gateway.address + "/?" + i + "#/220/vehicle", { waitUntil: "domcontentloaded" });
    await page.waitForFunction(() => document.querySelector(".contact.live") && /\d\.\d/.test(document.querySelector("main")?.innerText ?? ""), { polling: 10 });
    took.push(performance.now() - began);
  }
  console.log(`first values after ${took.map((ms) => ms.toFixed(0)).join(", ")} ms`);
}

const gateway = await Gateway.start(["sim:fc,hz=100", "sim:imu,hz=100", "sim:flow,hz=100"]);
const browser = await openBrowser();
try {
  const counter = await openPage(browser, gateway, { hash: "#/none" });
  await counter.goto(gateway.address + "/status"); // no page any more, but it may ask
  await pause(3);
  await inTurns(browser, gateway, counter);
  const page = await charts(browser, gateway);
  await pause(5);
  await drawing(page, gateway);
  await fourPages(browser, gateway, page);
  await hidden(browser, gateway);
  await opening(page, gateway);
} finally {
  await browser.close();
  await gateway.end();
}
