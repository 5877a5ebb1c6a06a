// A gateway with simulated devices, and a browser that looks at it.
import { spawn } from "node:child_process";
import { mkdirSync, mkdtempSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";
import puppeteer from "puppeteer-core";

const root = join(dirname(fileURLToPath(import.meta.url)), "../../../..");
const program = process.env.ANOGATED ?? join(root, "build/run/src/anogated");
export const shots = process.env.ANOGATE_SHOTS ?? join(root, "build/web-shots");

/** Whatever comes true in the end; else the test fails. */
export async function until(what, ask, patience = 20000) {
  const end = Date.now() + patience;
  for (;;) {
    const value = await ask();
    if (value) return value;
    if (Date.now() > end) throw new Error("it never came: " + what);
    await new Promise((resolve) => setTimeout(resolve, 30));
  }
}

export class Gateway {
  static async start(links = ["sim:fc", "sim:imu", "serial:/dev/absent", "udp-listen:127.0.0.1:0,name=ground"]) {
    const gateway = new Gateway();
    gateway.folder = mkdtempSync(join(tmpdir(), "anogate-web-"));
    gateway.links = links;
    await gateway.run(0);
    return gateway;
  }

  async run(port) {
    this.said = "";
    const environment = { ...process.env, XDG_STATE_HOME: this.folder, HOME: this.folder };
    this.process = spawn(program, ["--http", `127.0.0.1:${port}`, "--control", join(this.folder, "control.sock"), ...this.links], { env: environment });
    for (const stream of [this.process.stdout, this.process.stderr]) stream.on("data", (text) => (this.said += text));
    this.ended = new Promise((resolve) => this.process.on("exit", resolve));
    this.address = await until("the gateway listens\n" + this.said, () => /(http:\/\/127\.0\.0\.1:\d+): up/.exec(this.said)?.[1]);
    this.port = Number(new URL(this.address).port);
  }

  /** Root's gateways ask for a token; a user's own at a loopback address does not. */
  token(access) {
    const file = /the tokens are in (\S+)/.exec(this.said)?.[1];
    return file && new RegExp(`^${access} (\\S+)`, "m").exec(readFileSync(file, "utf8"))[1];
  }

  async stop() {
    this.process.kill("SIGCONT");
    this.process.kill("SIGTERM");
    await this.ended;
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

export const openBrowser = () =>
  puppeteer.launch({ executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium", args: ["--disable-gpu", ...(process.getuid() === 0 ? ["--no-sandbox"] : [])] });

/** A page in a context of its own, let in with a token where one is needed. `faults`: what the browser complained of; `elsewhere`: what was asked of others. */
export async function openPage(browser, gateway, { access = "control", language = "en", width = 1440, height = 900, dark = false, hash = "#/" } = {}) {
  const context = await browser.createBrowserContext();
  const page = await context.newPage();
  page.faults = [];
  page.elsewhere = [];
  page.on("pageerror", (error) => page.faults.push(error.message));
  page.on("console", (message) => message.type() === "error" && !/401|404|409|422|403|504/.test(message.text()) && page.faults.push(message.text()));
  page.on("request", (request) => !/^(data|blob):/.test(request.url()) && !request.url().startsWith(gateway.address) && page.elsewhere.push(request.url()));
  await page.evaluateOnNewDocument((tag) => Object.defineProperty(navigator, "languages", { get: () => [tag] }), language);
  if (dark) await page.emulateMediaFeatures([{ name: "prefers-color-scheme", value: "dark" }]);
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

/** Says yes to a question; it is deaf to a second touch at first. */
export async function confirm(page, within = "main") {
  await page.waitForSelector(`${within} .confirm .main`);
  await until("the question is answered", () =>
    page.evaluate((within) => {
      document.querySelector(`${within} .confirm .main`)?.click();
      return new Promise((done) => setTimeout(() => done(!document.querySelector(`${within} .confirm`)), 50));
    }, within));
}
