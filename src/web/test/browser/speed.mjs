// How fast the page is: ANOGATED=PATH npm run speed
// Prints figures, and judges none: they are of this computer and of what else it does.
import { readFileSync } from "node:fs";
import { Gateway, openBrowser, openPage } from "./gateway.mjs";

const fields = { 1: ["acc_x", "acc_y", "acc_z", "gyr_x", "gyr_y", "gyr_z"], 3: ["rol", "pit", "yaw"], 4: ["v0"] };
const chosen = [220, 221].flatMap((from) => Object.entries(fields).flatMap(([id, names]) => names.map((field) => ({ from, id: Number(id), field }))));
const pause = (seconds) => new Promise((done) => { setTimeout(done, seconds * 1000); });

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

const gateway = await Gateway.start(["sim:fc,hz=100", "sim:imu,hz=100", "sim:flow,hz=100"]);
const browser = await openBrowser();
try {
  await pause(3);
  let before = used(gateway.process.pid);
  await pause(5);
  console.log(`gateway, nobody looks: ${(((used(gateway.process.pid) - before) / 5) * 100).toFixed(1)} % of a core`);

  const page = await charts(browser, gateway);
  await pause(5);
  const framesIn = async () => (await page.evaluate(() => fetch("links").then((answer) => answer.json()))).reduce((sum, link) => sum + link.frames_in, 0);
  const session = await page.createCDPSession();
  await session.send("Performance.enable", { timeDomain: "threadTicks" }); // not while others have the processor
  const busy = async () => Object.fromEntries((await session.send("Performance.getMetrics")).metrics.map((one) => [one.name, one.value])).TaskDuration;
  const [frames, tasks] = [await framesIn(), await busy()];
  before = used(gateway.process.pid);
  const drawn = await page.evaluate(() => new Promise((done) => {
    let n = 0;
    const began = performance.now();
    const count = () => (performance.now() - began >= 5000 ? done(n / 5) : (++n, requestAnimationFrame(count)));
    requestAnimationFrame(count);
  }));
  console.log(`${chosen.length} series, ${(((await framesIn()) - frames) / 5).toFixed(0)} frames/s in: drawn ${drawn.toFixed(0)} times/s, main thread ${((((await busy()) - tasks) / 5) * 100).toFixed(0)} % of a core`);
  console.log(`gateway, one page looks: ${(((used(gateway.process.pid) - before) / 5) * 100).toFixed(1)} % of a core`);

  const others = [];
  for (let i = 0; i < 3; ++i) others.push(await charts(browser, gateway));
  await pause(4);
  const lost = await Promise.all([page, ...others].map((one) => one.evaluate(() => document.querySelector("main .note.warn")?.textContent ?? "")));
  console.log(`four pages at once: ${lost.every((words) => words === "") ? "none lost a frame" : lost.filter(Boolean).join("; ")}`);
  for (const one of others) await one.browserContext().close();

  // A page is there as soon as it has values.
  const took = [];
  for (let i = 0; i < 5; ++i) {
    const began = performance.now();
    await page.goto(gateway.address + "/?" + i + "#/220/vehicle", { waitUntil: "domcontentloaded" });
    await page.waitForFunction(() => document.querySelector(".contact.live") && /\d\.\d/.test(document.querySelector("main")?.innerText ?? ""), { polling: 10 });
    took.push(performance.now() - began);
  }
  console.log(`first values after ${took.map((ms) => ms.toFixed(0)).join(", ")} ms`);
} finally {
  await browser.close();
  await gateway.end();
}
