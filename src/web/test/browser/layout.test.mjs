// The layout of every page at every usual width.
import assert from "node:assert/strict";
import { join } from "node:path";
import { test } from "node:test";
import { asked, confirm, go, outcome, press, shot, until, wider, world } from "./gateway.mjs";
import { FlyingDevice } from "./hostile_device.mjs";

const here = world(undefined, (folder) => ({ record: { start: false, folder: join(folder, "recordings") } }));

const pages = {
  "overview": ".branch", "frames": ".rows li", "charts": ".uplot", "log": "h1", "images": "canvas.picture", "recordings": ".recordings li",
  "220/vehicle": ".figure dd small", "220/alarms": ".limits", "220/parameters": ".set li", "220/commands": ".command", "220/waypoints": ".waypoints tr",
  "220/calibration": "button.main", "220/firmware": ".file",
};
const widths = [360, 390, 768, 820, 960, 1040, 1120, 1200, 1280, 1440];

/** Words of labels, buttons, headings and links that are split over two lines. */
const brokenWords = (page) => page.evaluate(() => {
  const found = [], range = document.createRange();
  for (const element of document.querySelectorAll("label, button, nav a, h1, h2, h3, th, dt, .flows dd, .calm code, .recordings a, .recordings button, .brand, .contact, .contact-of-device, .tag, legend, summary")) {
    const walker = document.createTreeWalker(element, NodeFilter.SHOW_TEXT);
    for (let node = walker.nextNode(); node; node = walker.nextNode()) {
      if (node.parentElement.closest("code:not(.whole), bdi, small") && !node.parentElement.closest("button, nav")) continue; // names of devices and addresses: of any length
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

/** Neighbours in the header that overlap, by their texts. */
const overlapping = (page) => page.evaluate(() => {
  const range = document.createRange(), parts = [];
  const walker = document.createTreeWalker(document.querySelector(".top"), NodeFilter.SHOW_TEXT);
  for (let node = walker.nextNode(); node; node = walker.nextNode()) {
    range.selectNodeContents(node);
    const rect = range.getBoundingClientRect(), frame = node.parentElement.closest("b, .of")?.getBoundingClientRect() ?? rect; // cut there, by CSS
    if (rect.width > 0) parts.push({ words: node.data, left: rect.left, right: Math.min(rect.right, frame.right) });
  }
  for (const button of document.querySelectorAll(".top button")) {
    const { left, right } = button.getBoundingClientRect();
    if (button.querySelector("svg")) parts.push({ words: button.title, left, right });
  }
  parts.sort((a, b) => a.left - b.left);
  return parts.slice(1).flatMap((part, i) => (parts[i].right > part.left + 1 ? [`${parts[i].words} | ${part.words}`] : []));
});

test("a recording for the list of recordings", async () => {
  const page = await here.open({ hash: "#/recordings" });
  await page.waitForSelector(".begin button");
  await press(page, "Record");
  await until("it is recorded", async () => (await asked(page, "recordings")).running[0]?.frames > 0);
  await press(page, "Stop…");
  await confirm(page);
  await page.waitForSelector(".recordings button:enabled");
  await page.browserContext().close();
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
      if (name === "frames") {
        await press(page, "Send a frame");
        const gap = await page.evaluate(() => document.querySelector(".rows").getBoundingClientRect().top - document.querySelector("form.send").getBoundingClientRect().bottom);
        if (gap < 8) wrong.push(`the form for a frame is ${gap} px above the list`);
        const addresses = await page.$$eval("#send-from, #send-to", (inputs) => inputs.map((input) => input.value).join());
        if (addresses !== "0xFE,0xFF") wrong.push(`the form for a frame has the addresses ${addresses}`);
      }
      if (name === "overview" && width >= 1280) {
        const lines = await page.$$eval(".flows", (all) => Math.max(...all.map((one) => new Set([...one.children].map((part) => part.getBoundingClientRect().top)).size)));
        if (lines > 1) wrong.push(`the rates of a link take ${lines} lines`);
      }
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

for (const language of ["en", "zh-CN"])
  test(`nothing overlaps in the header of a phone while neither the device nor the gateway answers, ${language}`, async () => {
    const page = await here.open({ language, width: 390, height: 844, hash: "#/57/vehicle" });
    await page.waitForSelector(".top .sound");
    const { port } = (await asked(page, "links")).find((link) => link.name === "ground");
    const device = new FlyingDevice(port, { address: 57, name: "Kestrel" });
    try {
      await page.waitForSelector(".contact-of-device.live");
      device.kill();
      await page.waitForSelector(".contact-of-device.lost");
      assert.deepEqual(await overlapping(page), []);
      here.gateway.process.kill("SIGSTOP");
      await outcome(page, ".contact.lost", /[5-9]|\d\d/);
      await shot(page, `no-answer-390-${language}`);
      assert.deepEqual(await overlapping(page), []);
      assert.ok((await wider(page)) <= 0);
    } finally {
      here.gateway.process.kill("SIGCONT");
      device.stop();
    }
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
