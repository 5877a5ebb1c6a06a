// How fast the page is: npm run speed:browser -- --anogated PATH
// Prints figures, and judges none: they are of this computer and of what else it does.
import { readFileSync } from "node:fs";
import { resolve } from "node:path";
import { close, launch, logIn, openPage } from "./browser.mjs";
import { Gateway } from "./gateway.mjs";

const at = process.argv.indexOf("--anogated");
if (at < 0 || !process.argv[at + 1]) {
  console.error("npm run speed:browser -- --anogated PATH");
  process.exit(2);
}

const fields = { 1: ["acc_x", "acc_y", "acc_z", "gyr_x", "gyr_y", "gyr_z"], 3: ["rol", "pit", "yaw"], 4: ["v0"] };
const chosen = [220, 221].flatMap((from) => Object.entries(fields).flatMap(([id, names]) => names.map((field) => ({ from, id: Number(id), field }))));
const pause = (seconds) => new Promise((done) => { setTimeout(done, seconds * 1000); });

/** Seconds of the processor that a process has used. */
function used(pid) {
  const words = readFileSync(`/proc/${pid}/stat`, "utf8").split(") ")[1].split(" ");
  return (Number(words[11]) + Number(words[12])) / 100;
}

async function charts(browser, gateway) {
  const page = await openPage(browser);
  await page.evaluateOnNewDocument((kept) => localStorage.setItem("anogate.charts", kept), JSON.stringify(chosen));
  await logIn(page, gateway.origin, gateway.token("control"), "#/charts");
  await page.waitForSelector("nav select");
  return page;
}

const gateway = new Gateway(resolve(process.argv[at + 1]));
await gateway.start("sim:fc,hz=100", "sim:imu,hz=100", "sim:flow,hz=100");
const browser = await launch();
try {
  await pause(3);
  let before = used(gateway.child.pid);
  await pause(5);
  console.log(`gateway, nobody looks: ${(((used(gateway.child.pid) - before) / 5) * 100).toFixed(1)} % of a core`);

  const page = await charts(browser, gateway);
  await pause(5);
  const framesIn = async () => (await gateway.ask("/links")).reduce((sum, link) => sum + link.frames_in, 0);
  const session = await page.createCDPSession();
  await session.send("Performance.enable", { timeDomain: "threadTicks" }); // not while others have the processor
  const busy = async () => Object.fromEntries((await session.send("Performance.getMetrics")).metrics.map((one) => [one.name, one.value])).TaskDuration;
  const [frames, tasks] = [await framesIn(), await busy()];
  before = used(gateway.child.pid);
  const drawn = await page.evaluate(() => new Promise((done) => {
    let n = 0;
    const began = performance.now();
    const count = () => (performance.now() - began >= 5000 ? done(n / 5) : (++n, requestAnimationFrame(count)));
    requestAnimationFrame(count);
  }));
  console.log(`${chosen.length} series, ${(((await framesIn()) - frames) / 5).toFixed(0)} frames/s in: drawn ${drawn.toFixed(0)} times/s, main thread ${((((await busy()) - tasks) / 5) * 100).toFixed(0)} % of a core`);
  console.log(`gateway, one page looks: ${(((used(gateway.child.pid) - before) / 5) * 100).toFixed(1)} % of a core`);

  const others = [];
  for (let i = 0; i < 3; ++i) others.push(await charts(browser, gateway));
  await pause(4);
  const lost = await Promise.all([page, ...others].map((one) => one.evaluate(() => document.querySelector("main .note.warn")?.textContent ?? "")));
  console.log(`four pages at once: ${lost.every((words) => words === "") ? "none lost a frame" : lost.filter(Boolean).join("; ")}`);
  for (const one of others) await close(one);

  // A page is there as soon as it has values.
  const took = [];
  for (let i = 0; i < 5; ++i) {
    const began = performance.now();
    await page.goto(gateway.origin + "/?" + i + "#/220/vehicle", { waitUntil: "domcontentloaded" });
    await page.waitForFunction(() => document.querySelector(".contact.live") && /\d\.\d/.test(document.querySelector("main")?.innerText ?? ""), { polling: 10 });
    took.push(performance.now() - began);
  }
  console.log(`first values after ${took.map((ms) => ms.toFixed(0)).join(", ")} ms`);
} finally {
  await browser.close();
  await gateway.stop();
  gateway.remove();
}
