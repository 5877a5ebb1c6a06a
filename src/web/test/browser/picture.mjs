// Makes page.png, the picture of the README, from a simulated flight: node test/browser/picture.mjs
// If no font has Chinese letters, which the language button shows: CHINESE_FONT=FILE.
import { readFileSync } from "node:fs";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";
import { asked, Gateway, go, launchBrowser, openPage, outcome, until } from "./gateway.mjs";

const file = join(dirname(fileURLToPath(import.meta.url)), "../../page.png");
const gateway = await Gateway.start(["sim:fc"]), browser = await launchBrowser();
try {
  const page = await openPage(browser, gateway, { hash: "#/220/vehicle", width: 1200, height: 900 });
  const post = (path, body) => asked(page, path, { method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(body) });
  const call = async (name, ...values) => {
    const answer = await post(`devices/220/commands/${name}`, { values });
    if (answer.error) throw new Error(`${name}: ${answer.error}`);
  };
  const figure = (label) => page.$$eval(".vehicle .figure", (all, label) => all.find((one) => one.textContent.startsWith(label))?.textContent ?? "", label);
  await page.waitForSelector(".flag");
  if (process.env.CHINESE_FONT)
    await page.evaluate(async (font) => {
      const bytes = Uint8Array.from(atob(font), (c) => c.charCodeAt(0));
      document.fonts.add(await new FontFace("picture", bytes, { unicodeRange: "U+4E00-9FFF" }).load());
      document.body.style.fontFamily = `picture, ${getComputedStyle(document.body).fontFamily}`;
    }, readFileSync(process.env.CHINESE_FONT).toString("base64"));
  await post("devices/scan", {}); // the device's name
  await call("UNLOCK");
  await call("TAKE_OFF", 400);
  await until("it is up", async () => /^altitude\s*[34]\.\d/.test(await figure("altitude")));
  for (const [north, west] of [[800, 300], [1000, -200], [300, -700]]) {
    await call("GO_TO", north, west, 400);
    await new Promise((done) => setTimeout(done, 6000));
  }
  await go(page, "#/220/vehicle");
  await outcome(page, ".flag", /airborne/);
  await page.screenshot({ path: file });
  console.log(file);
} finally {
  await browser.close();
  await gateway.end();
}
