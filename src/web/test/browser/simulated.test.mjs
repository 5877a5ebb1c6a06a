// Texts of simulated devices on a Chinese page.
import assert from "node:assert/strict";
import { test } from "node:test";
import { confirm, go, outcome, until, world } from "./gateway.mjs";

const here = world(["sim:fc", "sim:imu", "sim:flow", "sim:radio", "sim:car"]);

const units = /^(?:|1\/s|m\/s|cm\/s|cm\/s²|dBm)$/;
const isChinese = (text) => units.test(text) || /\p{Script=Han}/u.test(text);

/** The texts of the elements, once there are any. */
const textsOf = (page, selector) => until(selector, async () => {
  const texts = await page.$$eval(selector, (all) => all.map((one) => one.textContent));
  return texts.length > 0 && texts;
});

for (const [name, device, hasCommands] of [["fc", 220, true], ["imu", 221, false], ["flow", 222, false], ["radio", 230, false], ["car", 40, true]])
  test(`of sim:${name} are Chinese`, async () => {
    const page = await here.open({ language: "zh-CN", hash: `#/${device}/parameters` });
    const texts = await textsOf(page, ".about > .muted");
    if (hasCommands) {
      await go(page, `#/${device}/commands`);
      await page.waitForSelector(".command");
      texts.push(...await page.$$eval(".command > p.muted", (all) => all.map((one) => one.textContent)));
    }
    assert.deepEqual([...new Set(texts)].filter((text) => !isChinese(text)), []);
    await page.browserContext().close();
  });

test("that are logged are Chinese, and their names are those that programs use", async () => {
  const page = await here.open({ language: "zh-CN", hash: "#/220/commands" });
  await page.waitForSelector(".command");
  const unlock = (await page.$$eval(".command h2", (all) => all.map((one) => one.textContent))).indexOf("UNLOCK") + 1;
  await page.click(`.command:nth-child(${unlock}) button.main`);
  await confirm(page);
  await go(page, "#/log");
  await outcome(page, "ol.log", /已解锁/);
  await page.browserContext().close();
});
