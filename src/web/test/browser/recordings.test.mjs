// Recordings: started, ended, downloaded, deleted; and the message if the disk accepts no data.
import assert from "node:assert/strict";
import { copyFileSync, readdirSync, rmSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { test } from "node:test";
import { asked, confirm, Gateway, openPage, outcome, press, shot, textOf, type, until, wider, world } from "./gateway.mjs";

const folderIn = (folder) => join(folder, "recordings");
const here = world(["sim:fc"], (folder) => ({ record: { start: false, folder: folderIn(folder), keep_last: "60s" } }));
const all = (page) => asked(page, "recordings");

test("one is begun by a name, ended, taken home and deleted", async () => {
  const page = await here.open({ hash: "#/recordings" });
  await type(page, ".begin input", "flight");
  await press(page, "Record");
  await outcome(page, ".outcome", /✓ flight is being recorded/);
  await until("frames are counted", async () => (await all(page)).running[0]?.frames > 10);
  await page.waitForFunction(() => /flight/.test(document.querySelector(".running h3")?.textContent) && /[1-9]\d* frames/.test(document.querySelector(".running .number")?.textContent));
  await page.waitForFunction(() => /\d/.test(document.querySelectorAll(".recordings .number")[1]?.textContent)); // its length
  await shot(page, "recording");
  await press(page, "Stop…");
  await confirm(page);
  await outcome(page, ".outcome", /✓ flight stopped: .* frames/);
  const link = await page.waitForSelector(".recordings a");
  const name = await link.evaluate((one) => one.textContent);
  const size = await link.evaluate((one) => fetch(one.href).then((answer) => answer.arrayBuffer()).then((bytes) => bytes.byteLength));
  assert.equal(size, (await all(page)).recordings[0].bytes);
  assert.deepEqual(readdirSync(folderIn(here.gateway.folder)).filter((one) => !one.startsWith(".")), [name]);
  await press(page, "Delete…");
  await page.waitForSelector(".recordings .confirm button:focus"); // a confirmation is shown first
  await page.keyboard.press("Escape");
  assert.equal((await all(page)).recordings.length, 1);
  await press(page, "Delete…");
  await confirm(page);
  await outcome(page, ".outcome", /✓ .* deleted/);
  await page.waitForFunction(() => !document.querySelector(".recordings a"));
  assert.deepEqual(page.faults, []);
  await page.browserContext().close();
});

test("a name that another one has is refused, in words", async () => {
  const page = await here.open({ hash: "#/recordings" });
  for (const words of [/✓ twice is being recorded/, /✕ (Busy|Refused): .*twice/]) {
    await type(page, ".begin input", "twice");
    await press(page, "Record");
    await outcome(page, ".outcome", words);
  }
  await press(page, "Stop…");
  await confirm(page);
  await outcome(page, ".outcome", /✓ twice stopped/);
  await page.browserContext().close();
});

test("only what is asked for is recorded, and a filter that can't be meant is said to be none", async () => {
  const page = await here.open({ hash: "#/recordings", width: 390, height: 844 });
  await page.waitForSelector(".begin summary");
  await page.click(".begin summary");
  await type(page, ".begin details label:nth-of-type(5) input", "euler");
  await page.waitForSelector(".begin [role=alert]");
  assert.equal(await page.$eval(".begin button.main", (button) => button.disabled), true);
  await type(page, ".begin details label:nth-of-type(5) input", "euler=10");
  await type(page, ".begin details .field input", "euler");
  await type(page, ".begin input", "attitude");
  await press(page, "Record");
  await outcome(page, ".outcome", /✓ attitude is being recorded/);
  await until("some are written", async () => (await all(page)).running[0]?.frames >= 5);
  await press(page, "Stop…");
  await confirm(page);
  await outcome(page, ".outcome", /✓ attitude stopped/);
  await page.browserContext().close();
});

test("what was just now is saved when it is asked for", async () => {
  const page = await here.open({ hash: "#/recordings" });
  await press(page, "Save them here");
  await outcome(page, ".outcome", /✓ .*\.pcapng: \d+ frames/);
  await page.browserContext().close();
});

test("a thousand of them are listed, and one that is gone meanwhile is said to be", async () => {
  const gateway = await Gateway.start(["sim:fc"], (folder) => ({ record: { start: false, folder: folderIn(folder) } }));
  try {
    const page = await openPage(here.browser, gateway, { width: 390, height: 844, hash: "#/recordings" });
    await type(page, ".begin input", "first");
    await press(page, "Record");
    await press(page, "Stop…");
    await confirm(page);
    await outcome(page, ".outcome", /✓ first stopped/);
    const [first] = readdirSync(folderIn(gateway.folder)).filter((name) => name.endsWith(".pcapng"));
    const copy = (n) => join(folderIn(gateway.folder), first.replace("first", "copy-" + n));
    for (let n = 1; n < 1000; ++n) copyFileSync(join(folderIn(gateway.folder), first), copy(n));
    await page.waitForFunction(() => document.querySelectorAll(".recordings li").length === 1000);
    await shot(page, "recordings-1000");
    assert.ok((await wider(page)) <= 0);
    await page.evaluate(() => document.querySelector(".recordings li button").click());
    await page.waitForSelector(".recordings .confirm");
    const name = await page.$eval(".recordings li:first-child a", (link) => link.textContent);
    rmSync(join(folderIn(gateway.folder), name));
    const last = await page.$eval(".recordings li:last-child a", (link) => link.textContent);
    await page.waitForFunction((name) => document.querySelector(".recordings li:first-child a").textContent !== name, {}, name);
    assert.equal(await page.$(".recordings .confirm"), null, "the question was of that one");
    rmSync(join(folderIn(gateway.folder), last));
    assert.equal(await page.evaluate((name) => fetch("recordings/" + name, { method: "DELETE" }).then((answer) => answer.status), last), 404);
    assert.deepEqual(page.faults, []);
    await page.browserContext().close();
  } finally {
    await gateway.end();
  }
});

test("a disk that is too full is said to be", async () => {
  const gateway = await Gateway.start(["sim:fc"], (folder) => ({ record: { folder: folderIn(folder), free: 900e12 } }));
  try {
    const page = await openPage(here.browser, gateway, { hash: "#/recordings" });
    await outcome(page, "main .note[role=alert]", /Recording stopped: less than 900 TB/);
    await shot(page, "recordings-full");
    await page.browserContext().close();
  } finally {
    await gateway.end();
  }
});

test("the overview says that a recording fails, and leads there", async () => {
  const gateway = await Gateway.start(["sim:fc", "udp-listen:127.0.0.1:0,name=ground"], (folder) => {
    writeFileSync(join(folder, "file"), "");
    return { record: { folder: join(folder, "file") } };
  });
  try {
    for (const [language, width, height, words] of [["en", 1440, 900, /Recording .*: Not a directory/], ["zh-CN", 390, 844, /录制 .*：不是文件夹/]]) {
      const page = await openPage(here.browser, gateway, { language, width, height });
      await outcome(page, ".troubles .bad", words);
      await shot(page, `overview-recording-fails-${language}-${width}`);
      assert.equal(await page.$(".well"), null);
      assert.ok((await wider(page)) <= 0);
      await page.click(".troubles .bad a");
      await page.waitForSelector(".running .bad[role=alert]");
      assert.equal(await page.evaluate(() => location.hash), "#/recordings");
      await page.browserContext().close();
    }
  } finally {
    await gateway.end();
  }
});

test("who only looks sees them, and can begin, end or delete none", { skip: process.getuid() !== 0 && "a user's own gateway asks for no token" }, async () => {
  const page = await here.open({ access: "view", hash: "#/recordings" });
  await page.waitForFunction(() => /free/.test(document.querySelector("main .facts")?.textContent));
  assert.deepEqual(await page.$$eval("main :not(.only-view) > button", (found) => found.map((one) => one.textContent)), []);
  const tried = (method, path) => page.evaluate((method, path) => fetch(path, { method, headers: { "Content-Type": "application/json" }, body: method === "POST" ? "{}" : undefined }).then((answer) => answer.status), method, path);
  assert.deepEqual([await tried("POST", "recordings"), await tried("DELETE", "recordings/x.pcapng"), await tried("POST", "recordings/x/end")], [403, 403, 403]);
  assert.match(await textOf(page, "main h1"), /Recordings/);
  await page.browserContext().close();
});
