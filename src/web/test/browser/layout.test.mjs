// The layout of every page at every usual width.
import assert from "node:assert/strict";
import { test } from "node:test";
import { go, shot, wider, world } from "./gateway.mjs";

const here = world();

const pages = {
  "overview": ".branch", "frames": ".rows li", "charts": ".uplot", "log": "h1", "images": "canvas.picture", "recordings": "h1 ~ *",
  "220/vehicle": ".figure dd small", "220/alarms": ".limits", "220/parameters": ".set li", "220/commands": ".command", "220/waypoints": ".waypoints tr",
  "220/calibration": "button.main", "220/firmware": ".file",
};
const widths = [360, 390, 768, 820, 960, 1024, 1280, 1440];

/** Words of labels, buttons, headings and links that are split over two lines. */
const brokenWords = (page) => page.evaluate(() => {
  const found = [], range = document.createRange();
  for (const element of document.querySelectorAll("label, button, nav a, h1, h2, h3, th, dt, .brand, .contact, .contact-of-device, .tag, legend, summary")) {
    const walker = document.createTreeWalker(element, NodeFilter.SHOW_TEXT);
    for (let node = walker.nextNode(); node; node = walker.nextNode()) {
      if (node.parentElement.closest("code, bdi, small") && !node.parentElement.closest("button, nav")) continue; // names of devices and addresses: of any length
      for (const { 0: word, index } of node.data.matchAll(/[A-Za-z]{2,}/g)) {
        range.setStart(node, index);
        range.setEnd(node, index + word.length);
        const tops = [...range.getClientRects()].filter((rect) => rect.width > 0).map((rect) => Math.round(rect.top));
        if (new Set(tops).size > 1) found.push(`${word} in ${element.outerHTML.slice(0, 80)}`);
      }
    }
  }
  return found;
});

/** The number of pixels by which a page scrolls although its content ends within the window. */
const needlessScroll = (page) => page.evaluate(() => {
  const last = [...document.querySelectorAll("main > *")].reduce((end, one) => Math.max(end, one.getBoundingClientRect().bottom + scrollY), 0);
  const bar = document.querySelector(".pinned")?.getBoundingClientRect().height ?? 0;
  const more = document.documentElement.scrollHeight - innerHeight;
  return last + bar + 24 < innerHeight ? Math.max(0, more) : 0;
});

/** Fields and buttons of the page that are covered by the action bar or the header when they have the focus. */
const hiddenFields = (page) => page.evaluate(async () => {
  const found = [], fields = [...document.querySelectorAll("main input, main select, main button")].filter((one) => !one.disabled && one.offsetParent !== null);
  const step = Math.max(1, Math.floor(fields.length / 25));
  for (const field of [...fields.filter((_, i) => i % step === 0), ...fields.slice(-3)]) {
    let rect, bar, head, isHidden = true;
    for (let tries = 0; isHidden && tries < 3 && field.isConnected; ++tries) { // new rows may move it
      scrollTo(0, 0);
      field.blur();
      field.focus();
      await new Promise((drawn) => requestAnimationFrame(() => requestAnimationFrame(drawn)));
      rect = field.getBoundingClientRect();
      bar = document.querySelector(".pinned")?.getBoundingClientRect().top ?? innerHeight;
      head = document.querySelector(".top").getBoundingClientRect().bottom;
      isHidden = document.activeElement === field && rect.height < innerHeight / 2 && (rect.bottom > bar + 1 || rect.top < head - 1);
    }
    if (isHidden && field.isConnected) found.push(`${field.outerHTML.slice(0, 90)}: ${rect.top} to ${rect.bottom}, the bar is at ${bar}`);
  }
  return found;
});

for (const width of widths)
  test(`every page at ${width} px`, async () => {
    const page = await here.open({ width, height: width < 700 ? 780 : 900 });
    await page.waitForSelector(".branch");
    const wrong = [];
    await go(page, "#/recordings");
    await page.waitForSelector("main h1 ~ *");
    for (const [name, sign] of Object.entries(pages)) {
      await page.evaluate(() => scrollTo(0, document.documentElement.scrollHeight));
      await go(page, "#/" + name);
      await page.waitForSelector("main " + sign, { timeout: 30000 });
      const at = await page.evaluate(() => scrollY);
      if (at !== 0) wrong.push(`${name} begins at ${at} px`);
      if (name === "220/vehicle") await page.waitForSelector(".pinned");
      const more = await wider(page);
      if (more > 0) wrong.push(`${name} is ${more} px wider than the screen`);
      for (const word of await brokenWords(page)) wrong.push(`${name}: ${word} is broken`);
      const needless = await needlessScroll(page);
      if (needless > 0) wrong.push(`${name} scrolls by ${needless} px for nothing`);
      for (const field of await hiddenFields(page)) wrong.push(`${name}: ${field}`);
      if (width === 960 || width === 360) await shot(page, `layout-${name.replace("/", "-")}-${width}`);
    }
    assert.deepEqual(wrong, []);
    await page.browserContext().close();
  });

test("the first rates are there within 500 ms of the first values", async () => {
  const page = await here.open();
  await page.waitForSelector(".branch");
  await page.evaluateOnNewDocument(() => {
    let began, last = performance.now(), late = 0;
    const timer = setInterval(() => {
      const now = performance.now(), first = document.querySelector(".branch .flows dd");
      if (began !== undefined) late += Math.max(0, now - last - 10);
      last = now;
      if (first) began ??= now;
      if (!first || first.textContent.startsWith("–")) return;
      clearInterval(timer);
      window.firstRates = { took: now - began, late };
    }, 10);
  });
  await page.reload();
  const { took, late } = await (await page.waitForFunction(() => window.firstRates)).jsonValue();
  console.log(`first rates after ${took.toFixed(0)} ms, of which timers were late by ${late.toFixed(0)} ms`);
  assert.ok(took - late <= 500, `${took} ms, of which ${late} ms were late timers`);
  await page.browserContext().close();
});
