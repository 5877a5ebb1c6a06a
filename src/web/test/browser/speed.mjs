// The speed of the page: ANOGATED=PATH npm run speed
// and the cost of an open page for the gateway: ANOGATED=PATH npm run speed cost
// Prints figures without judging them: they depend on this computer and its other load.
import { readdirSync, readFileSync } from "node:fs";
import { Gateway, openBrowser, openPage } from "./gateway.mjs";
import { Traffic } from "./traffic.mjs";

const fields = { 1: ["acc_x", "acc_y", "acc_z", "gyr_x", "gyr_y", "gyr_z"], 3: ["rol", "pit", "yaw"], 4: ["v0"] };
const chosen = [220, 221].flatMap((from) => Object.entries(fields).flatMap(([id, names]) => names.map((field) => ({ from, id: Number(id), field }))));
const pause = (seconds) => new Promise((done) => { setTimeout(done, seconds * 1000); });
const median = (all) => [...all].sort((a, b) => a - b)[Math.floor(all.length / 2)];
const percent = (share) => `${(share * 100).toFixed(1)} %`;

/** CPU time of all threads of a process, in seconds. */
const used = (pid) => readdirSync(`/proc/${pid}/task`).reduce((sum, thread) => sum + Number(readFileSync(`/proc/${pid}/task/${thread}/schedstat`, "utf8").split(" ")[0]) / 1e9, 0);

async function charts(browser, gateway) {
  const page = await openPage(browser, gateway);
  await page.evaluate((kept) => localStorage.setItem("anogate.charts", kept), JSON.stringify(chosen));
  await page.goto(gateway.address + "/?charts#/charts");
  await page.waitForSelector(".uplot");
  return page;
}

const framesIn = (page) => page.evaluate(() => fetch("links").then((answer) => answer.json()).then((links) => links.reduce((sum, link) => sum + link.frames_in, 0)));

/** The share of a processor that the gateway uses, and its routed frames per second, measured for `seconds`. */
async function costs(gateway, counter, seconds) {
  const [before, frames, began] = [used(gateway.process.pid), await framesIn(counter), performance.now()];
  await pause(seconds);
  const took = (performance.now() - began) / 1000;
  return { processor: (used(gateway.process.pid) - before) / took, frames: ((await framesIn(counter)) - frames) / took };
}

const looked = { "#/": ".branch", "#/220/vehicle": ".figure dd small", "#/charts": ".uplot" };

/** Alternates between rounds with and without an open page, so that other load of the computer affects both. */
async function inTurns(browser, gateway, counter, hash) {
  const alone = [], watched = [];
  for (let round = 0; round < 5; ++round) {
    alone.push(await costs(gateway, counter, 2));
    const page = await openPage(browser, gateway, { hash });
    await page.waitForSelector(looked[hash]);
    await pause(1); // requests that are sent only once
    watched.push(await costs(gateway, counter, 2));
    await page.browserContext().close();
  }
  const of = (all, name) => median(all.map((one) => one[name]));
  const ratios = alone.map((one, i) => watched[i].processor / watched[i].frames / (one.processor / one.frames)).sort((a, b) => a - b);
  const [without, beside] = [of(alone, "processor"), of(watched, "processor")];
  console.log(`${hash} at ${of(alone, "frames").toFixed(0)} and ${of(watched, "frames").toFixed(0)} frames/s: ${percent(without)} of a core without a page, ${percent(beside)} with one; ${(beside / of(watched, "frames") * 1e6).toFixed(2)} against ${(without / of(alone, "frames") * 1e6).toFixed(2)} µs a frame, ${median(ratios).toFixed(3)} times that (${ratios[1].toFixed(3)} to ${ratios.at(-2).toFixed(3)})`);
}

/** The cost of a page, with frames that are received by UDP and forwarded to one receiver. */
async function cost() {
  const gateway = await Gateway.start(["udp-listen:127.0.0.1:0,name=vehicle", "udp-listen:127.0.0.1:0,name=ground"]);
  const browser = await openBrowser();
  const traffic = new Traffic();
  try {
    const counter = await openPage(browser, gateway, { hash: "#/none" });
    await counter.goto(gateway.address + "/status");
    const port = async (name) => (await counter.evaluate(() => fetch("links").then((answer) => answer.json()))).find((link) => link.name === name).port;
    for (const [rate, alone] of [[1000, true], [1200, false], [20000, false]]) {
      traffic.begin(await port("vehicle"), await port("ground"), rate, alone);
      console.log(alone ? "each frame in a datagram of its own:" : "frames packed into datagrams, every 4 ms:");
      await pause(1);
      for (const hash of Object.keys(looked)) await inTurns(browser, gateway, counter, hash);
    }
  } finally {
    traffic.end();
    await browser.close();
    await gateway.end();
  }
}

async function drawing(page, gateway) {
  const session = await page.createCDPSession();
  await session.send("Performance.enable", { timeDomain: "threadTicks" }); // excludes the time of other processes
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

/** Requests and frames of a hidden tab within some seconds. */
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

/** A page counts as open as soon as it shows values. */
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

async function speed() {
  const gateway = await Gateway.start(["sim:fc,hz=100", "sim:imu,hz=100", "sim:flow,hz=100"]);
  const browser = await openBrowser();
  try {
    const page = await charts(browser, gateway);
    await pause(8);
    await drawing(page, gateway);
    await fourPages(browser, gateway, page);
    await hidden(browser, gateway);
    await opening(page, gateway);
  } finally {
    await browser.close();
    await gateway.end();
  }
}

await { cost, speed }[process.argv[2] ?? "speed"]();
