// A gateway with simulated devices, and a browser that shows its page.
import { spawn } from "node:child_process";
import { mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { dirname, join } from "node:path";
import { after, before } from "node:test";
import { fileURLToPath } from "node:url";
import puppeteer from "puppeteer-core";

const root = join(dirname(fileURLToPath(import.meta.url)), "../../../..");
const program = process.env.ANOGATED ?? join(root, "build/run/src/anogated");
export const shots = process.env.ANOGATE_SHOTS ?? join(root, "build/web-shots");

/** Repeats `ask` and returns its first true value; throws after `patience` ms. */
export async function until(what, ask, patience = 30000) {
  const end = Date.now() + patience;
  for (;;) {
    const value = await ask();
    if (value) return value;
    if (Date.now() > end) throw new Error("it never came: " + what);
    await new Promise((resolve) => setTimeout(resolve, 30));
  }
}

const usualLinks = ["sim:fc", "sim:imu", "serial:/dev/absent", "udp-listen:127.0.0.1:0,name=ground"];

export class Gateway {
  /** `sections`: a function that returns further sections of the configuration; its argument is the folder in which the gateway may write. */
  static async start(links = usualLinks, sections = undefined) {
    const gateway = new Gateway();
    gateway.folder = mkdtempSync(join(tmpdir(), "anogate-web-"));
    gateway.arguments = [...links];
    if (sections) {
      const file = join(gateway.folder, "anogate.json");
      writeFileSync(file, JSON.stringify(sections(gateway.folder)));
      gateway.arguments.push("--config", file);
    }
    await gateway.run(0);
    return gateway;
  }

  async run(port) {
    this.said = "";
    const environment = { ...process.env, XDG_STATE_HOME: this.folder, HOME: this.folder };
    this.process = spawn(program, ["--http", `127.0.0.1:${port}`, "--control", join(this.folder, "control.sock"), ...this.arguments], { env: environment });
    for (const stream of [this.process.stdout, this.process.stderr]) stream.on("data", (text) => (this.said += text));
    this.ended = new Promise((resolve) => this.process.on("exit", resolve));
    const up = () => /(http:\/\/127\.0\.0\.1:\d+): up/.exec(this.said)?.[1];
    this.address = await until("the gateway listens", () => up() ?? (this.process.exitCode !== null && Promise.reject(new Error(this.said))));
    this.port = Number(new URL(this.address).port);
  }

  /** A gateway of root requires a token; a user's own on a loopback address does not. */
  token(access) {
    const file = /the tokens are in (\S+)/.exec(this.said)?.[1];
    return file && new RegExp(`^${access} (\\S+)`, "m").exec(readFileSync(file, "utf8"))[1];
  }

  async stop() {
    this.process.kill("SIGCONT");
    this.process.kill("SIGTERM");
    await this.ended;
  }
  /** Starts it again after it was killed. */
  async runAgain() {
    await this.ended;
    await this.run(this.port);
  }
  async restart() {
    await this.stop();
    await this.run(this.port);
  }
  async end() {
    await this.stop();
    rmSync(this.folder, { recursive: true, force: true });
  }
}

const launch = { executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium", args: ["--disable-gpu", "--mute-audio", ...(process.getuid() === 0 ? ["--no-sandbox"] : [])], protocolTimeout: 60000 };
export const launchBrowser = () => puppeteer.launch(launch);

/** The browser of the whole run if there is one, otherwise a new one. */
export async function openBrowser() {
  const address = process.env.ANOGATE_BROWSER;
  if (!address) return launchBrowser();
  const browser = await puppeteer.connect({ browserWSEndpoint: address, protocolTimeout: 60000 });
  browser.close = () => browser.disconnect();
  return browser;
}

/** The gateway of a test file, and `open`, which opens one of its pages. */
export function world(links, sections) {
  const it = {};
  before(async () => ([it.gateway, it.browser] = await Promise.all([Gateway.start(links, sections), openBrowser()])));
  after(async () => {
    await it.browser?.close();
    await it.gateway?.end();
  });
  it.open = (options) => openPage(it.browser, it.gateway, options);
  return it;
}

/** A page in its own context, signed in with a token if one is needed. `faults`: errors reported by the browser; `elsewhere`: requests to other servers. */
export async function openPage(browser, gateway, { access = "control", language = "en", width = 1440, height = 900, dark = false, hash = "#/" } = {}) {
  const context = await browser.createBrowserContext();
  const page = await context.newPage();
  page.setDefaultTimeout(40000);
  page.faults = [];
  page.elsewhere = [];
  page.on("pageerror", (error) => page.faults.push(error.message));
  page.on("console", (message) => message.type() === "error" && !/40[1349]|422|504/.test(message.text()) && page.faults.push(message.text()));
  page.on("request", (request) => !/^(data|blob):/.test(request.url()) && !request.url().startsWith(gateway.address) && page.elsewhere.push(request.url()));
  await page.evaluateOnNewDocument((tag) => Object.defineProperty(navigator, "languages", { get: () => [tag] }), language);
  // Without a graphics card, continuous animations use up one processor.
  await page.emulateMediaFeatures([{ name: "prefers-reduced-motion", value: "reduce" }, { name: "prefers-color-scheme", value: dark ? "dark" : "light" }]);
  await page.setViewport({ width, height });
  await page.goto(gateway.address + "/" + hash);
  const token = access && gateway.token(access);
  if (token) await logIn(page, token);
  return page;
}

export async function logIn(page, token) {
  await page.waitForSelector(".login input");
  await page.click(".login input", { count: 3 });
  await page.type(".login input", token);
  await page.click(".login button");
  await page.waitForSelector("nav");
}

export const textOf = (page, selector) => page.$eval(selector, (element) => element.textContent);
export const go = (page, hash) => page.evaluate((to) => { location.hash = to; }, hash);
export const asked = (page, route, options) => page.evaluate((path, options) => fetch(path, options).then((answer) => answer.json()), route, options);
export const wider = (page) =>
  page.evaluate(() =>
    Math.max(document.documentElement.scrollWidth - innerWidth, ...[...document.querySelectorAll(".scroll")].map((one) => one.scrollWidth - one.clientWidth)),
  );

/** Waits until the drawn content has changed `times` times: the page is updated, and pending values have arrived. */
export const drawnAgain = (page, selector, times) =>
  page.evaluate((selector, times) => new Promise((done) => {
    let left = times;
    const observer = new MutationObserver(() => --left <= 0 && (observer.disconnect(), done()));
    observer.observe(document.querySelector(selector), { subtree: true, childList: true, characterData: true, attributes: true });
  }), selector, times);

export async function shot(page, name) {
  mkdirSync(shots, { recursive: true });
  await page.screenshot({ path: join(shots, name + ".png") });
}

export async function press(page, words, within = "main") {
  await until(`a button “${words}”`, () =>
    page.evaluate((words, within) => {
      const button = [...document.querySelectorAll(`${within} button`)].find((one) => one.textContent.trim() === words && !one.disabled);
      button?.click();
      return button !== undefined;
    }, words, within));
}

/** Confirms a question, which ignores clicks at first. */
export async function confirm(page, within = "main") {
  await page.waitForSelector(`${within} .confirm .main`);
  await until("the question is answered", () =>
    page.evaluate((within) => {
      document.querySelector(`${within} .confirm .main`)?.click();
      return new Promise((done) => setTimeout(() => done(!document.querySelector(`${within} .confirm`)), 50));
    }, within));
}

/** Waits until the text of the element matches `words`; returns the text. */
export const outcome = (page, selector, words) => until(`${selector} says ${words}`, async () => {
  const text = await page.$eval(selector, (element) => element.textContent).catch(() => "");
  return words.test(text) && text;
});

export async function type(page, selector, text) {
  await page.waitForSelector(selector);
  await page.click(selector, { count: 3 });
  await page.keyboard.press("Backspace");
  await page.type(selector, text);
}

/** Writes a file and selects it in a form. */
export async function choose(page, gateway, name, content) {
  const file = join(gateway.folder, name);
  writeFileSync(file, content);
  await (await page.waitForSelector("input[type=file]")).uploadFile(file);
}
