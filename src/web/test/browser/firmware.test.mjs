// Firmware: refused if it does not fit, cancelled halfway, and complete at the end.
import assert from "node:assert/strict";
import { test } from "node:test";
import { asked, choose, confirm, go, outcome, press, textOf, until, world } from "./gateway.mjs";

const here = world(["sim:imu,delay=20ms"]);
const open = async () => {
  const page = await here.open();
  await until("the device is heard", async () => (await asked(page, "devices/scan", { method: "POST", headers: { "Content-Type": "application/json" }, body: "{}" })).devices?.some((one) => one.hw));
  await go(page, "#/221/firmware");
  await page.waitForFunction(() => /hardware \d/.test(document.querySelector("main").textContent));
  return page;
};
const upgrade = async (page) => {
  await press(page, "Upgrade");
  await confirm(page);
};

/** An image for hardware of these versions, in the vendor's frame. */
function bia(size, least, most) {
  const header = Buffer.alloc(100);
  header.write("bia", "latin1");
  header.writeUInt16LE(120, 10);
  header.writeUInt16LE(least, 30);
  header.writeUInt16LE(most, 32);
  return Buffer.concat([header, Buffer.alloc(size, 7)]);
}

test("a file for other hardware is warned of and refused, and taken by force", async () => {
  const page = await open();
  await choose(page, here.gateway, "other.bia", bia(3000, 900, 901));
  await page.waitForSelector("main .note.warn");
  assert.match(await textOf(page, "main .note.warn"), /for hardware versions 900 to 901/);
  await upgrade(page);
  await outcome(page, "main p.bad[role=alert]", /✕ Refused/);
  await page.click("main .check input");
  await upgrade(page);
  await outcome(page, "main", /✓ The device has checked the image: 3000 bytes|✕/);
  await page.browserContext().close();
});

test("an upgrade that is cancelled leaves the device in its loader, and another one gets it out", async () => {
  const page = await open();
  await choose(page, here.gateway, "long.bin", Buffer.alloc(400_000, 7));
  await upgrade(page);
  await page.waitForFunction(() => document.querySelector("main progress")?.value > 0);
  await press(page, "Cancel");
  await confirm(page);
  await outcome(page, "main p.bad[role=alert]", /cancelled/);
  await until("it is told to be in its loader", () => page.$eval("main", (main) => /is in its boot loader/.test(main.textContent)));
  await choose(page, here.gateway, "image.bin", Buffer.alloc(5000, 7));
  await upgrade(page);
  await outcome(page, "main", /✓ The device has checked the image: 5000 bytes/);
  // No later text contradicts that: not now, not when the devices are requested again, and not when the page is reopened.
  const stale = () => page.$eval("main", (main) => /is in its boot loader|cancelled|✕|Refused/.exec(main.textContent)?.[0]);
  const end = Date.now() + 4000;
  while (Date.now() < end) assert.equal(await stale(), undefined);
  await until("the gateway knows it", async () => (await asked(page, "devices")).devices.every((one) => !one.in_loader));
  await go(page, "#/221/parameters");
  await page.waitForFunction(() => /Parameters/.test(document.querySelector("main h1")?.textContent));
  await go(page, "#/221/firmware");
  await page.waitForFunction(() => /hardware \d/.test(document.querySelector("main").textContent));
  assert.equal(await stale(), undefined);
  await page.browserContext().close();
});
