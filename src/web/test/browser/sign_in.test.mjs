// Signing in by a link, as on a phone that has scanned it, and by digits.
import assert from "node:assert/strict";
import { request } from "node:http";
import { join } from "node:path";
import { test } from "node:test";
import { openPage, outcome, shot, textOf, until, wider, world } from "./gateway.mjs";

const phone = { access: null, width: 390, height: 844 };
const here = world();
const options = { skip: process.getuid() !== 0 && "a user's own gateway asks for no token" };

/** The answer of the gateway on its socket. */
const asked = (method, path, body) => new Promise((done, failed) => {
  const sent = request({ socketPath: join(here.gateway.folder, "control.sock"), method, path, headers: { "Content-Type": "application/json", "Content-Length": Buffer.byteLength(body) } }, (answer) => {
    let text = "";
    answer.on("data", (part) => (text += part));
    answer.on("end", () => done(JSON.parse(text)));
  });
  sent.on("error", failed);
  sent.end(body);
});
const codeOf = async (wanted) => (await asked("POST", "/login/code", JSON.stringify(wanted))).code;
const states = async () => (await asked("GET", "/status", "")).http.codes;
const mayControl = (page) => page.evaluate(() => fetch("send", { method: "POST", headers: { "Content-Type": "application/json" }, body: "{}" }).then((answer) => answer.status !== 401 && answer.status !== 403));

test("a link signs a phone in, once, and leaves no code in the address", options, async () => {
  const hash = `#once=${await codeOf({})}`;
  const page = await openPage(here.browser, here.gateway, { ...phone, hash });
  await page.waitForSelector(".branch");
  assert.equal(await page.evaluate(() => location.href), here.gateway.address + "/#/");
  assert.equal(await mayControl(page), true);
  assert.ok((await wider(page)) <= 0);
  assert.equal((await states()).link, "used");
  await page.reload();
  await page.waitForSelector(".branch");
  await page.browserContext().close();

  const again = await openPage(here.browser, here.gateway, { ...phone, hash });
  await outcome(again, ".login [role=alert]", /This link was already used or has expired/);
  assert.ok((await wider(again)) <= 0);
  await shot(again, "link-is-over-390");
  await again.browserContext().close();
});

test("a link for watching does not control", options, async () => {
  const page = await openPage(here.browser, here.gateway, { ...phone, hash: `#once=${await codeOf({ access: "view" })}` });
  await page.waitForSelector(".only-view");
  assert.equal(await mayControl(page), false);
  await page.browserContext().close();
});

test("a link that is opened in a page that asks for a token signs it in", options, async () => {
  const page = await openPage(here.browser, here.gateway, phone);
  await page.waitForSelector(".login");
  await page.evaluate((hash) => { location.hash = hash; }, `once=${await codeOf({})}`);
  await page.waitForSelector(".branch");
  await page.browserContext().close();
});

test("a page that a browser loads in advance signs in only once it is shown", options, async () => {
  const code = await codeOf({}), page = await openPage(here.browser, here.gateway, phone);
  await page.evaluateOnNewDocument(() => Object.defineProperty(document, "prerendering", { configurable: true, get: () => true }));
  await page.goto("about:blank");
  await page.goto(`${here.gateway.address}/#once=${code}`);
  await until("the code is taken from the address", () => page.evaluate(() => location.hash === "#/"));
  assert.equal((await states()).link, "valid");
  await page.evaluate(() => {
    Object.defineProperty(document, "prerendering", { get: () => false });
    document.dispatchEvent(new Event("prerenderingchange"));
  });
  await page.waitForSelector(".branch");
  assert.equal((await states()).link, "used");
  await page.browserContext().close();
});

// A page of another site can open any address, and would have three tries.
test("digits in the address are not tried", options, async () => {
  await codeOf({ form: "digits" });
  for (let i = 0; i < 4; ++i) {
    const page = await openPage(here.browser, here.gateway, { ...phone, hash: `#once=00000${i}` });
    await page.waitForSelector(".login");
    await page.browserContext().close();
  }
  assert.equal((await states()).digits, "valid");
});

test("digits sign a phone in; wrong ones say what to do", options, async () => {
  const digits = await codeOf({ form: "digits" });
  const page = await openPage(here.browser, here.gateway, phone);
  const enter = async (typed) => {
    await page.waitForSelector(".login input");
    await page.click(".login input", { count: 3 });
    await page.type(".login input", typed);
    await page.click(".login button");
  };
  await enter(digits === "000000" ? "000001" : "000000");
  await outcome(page, ".login [role=alert]", /wrong or no longer valid\. They become void after three wrong attempts.*without sudo if you started anogated yourself/);
  assert.match(await textOf(page, ".login p"), /sudo anoctl web --pair.*Leave out “sudo” if you started anogated yourself/);
  assert.ok((await wider(page)) <= 0);
  await shot(page, "digits-390");
  await enter(`${digits.slice(0, 3)} ${digits.slice(3)}`);
  await page.waitForSelector(".branch");
  assert.equal(await mayControl(page), true);
  assert.equal((await states()).digits, "used");
  await page.browserContext().close();
});
