// Chromium, and a page in it that tells of every fault.
import { existsSync } from "node:fs";
import puppeteer from "puppeteer-core";

const chromium = ["/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome"].find((path) => existsSync(path));

export async function launch() {
  if (!chromium) throw new Error("chromium is not here: apt install chromium");
  return puppeteer.launch({ executablePath: chromium, args: ["--no-sandbox", "--disable-gpu", "--host-resolver-rules=MAP evil.example 127.0.0.1"] });
}

/** Without what others left: cookies, the language, the theme. `faults` gathers what went wrong in it. */
export async function openPage(browser, { language = "en", theme = "light", width = 1440, height = 900 } = {}) {
  const context = await browser.createBrowserContext();
  const page = await context.newPage();
  page.faults = [];
  page.elsewhere = [];
  page.on("pageerror", (error) => page.faults.push(String(error)));
  page.on("console", (message) => message.type() === "error" && page.faults.push(message.text()));
  page.on("dialog", (dialog) => { page.faults.push("dialog: " + dialog.message()); void dialog.dismiss(); });
  page.on("request", (request) => page.elsewhere.push(new URL(request.url()).host));
  await page.evaluateOnNewDocument((tag) => Object.defineProperty(navigator, "languages", { get: () => [tag] }), language);
  await page.emulateMediaFeatures([{ name: "prefers-color-scheme", value: theme }]);
  await page.setViewport({ width, height });
  return page;
}

export const close = (page) => page.browserContext().close();

export async function logIn(page, origin, token, hash = "#/") {
  await page.goto(origin + "/" + hash);
  const input = await page.waitForSelector(".login input", { timeout: 15000 });
  await input.type(token);
  await page.click(".login button");
}

export async function go(page, hash) {
  await page.evaluate((to) => { location.hash = to; }, hash);
  await page.waitForSelector('nav a[aria-current="page"]', { timeout: 15000 });
}

/** Clicks what has these words, and waits until it may be clicked. */
export async function press(page, words, inside = "main") {
  await page.waitForFunction((text, where) => [...document.querySelectorAll(where + " button, " + where + " a")].some((one) => one.textContent.includes(text) && !one.disabled), { timeout: 20000 }, words, inside);
  await page.evaluate((text, where) => [...document.querySelectorAll(where + " button, " + where + " a")].find((one) => one.textContent.includes(text) && !one.disabled).click(), words, inside);
}

/** A question is deaf to a second touch: it is answered when it hears. */
export async function answer(page, words) {
  await page.waitForSelector(".confirm .main", { timeout: 10000 });
  await page.evaluate(() => new Promise((done) => { setTimeout(done, 450); }));
  await press(page, words, ".confirm");
}

export const sees = (page, words, timeout = 20000) => page.waitForFunction((text) => document.body.innerText.includes(text), { timeout }, words);
