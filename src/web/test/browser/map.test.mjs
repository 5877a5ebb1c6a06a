// A map under the track: its position, and the message if there is none.
import assert from "node:assert/strict";
import dgram from "node:dgram";
import { renameSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { test } from "node:test";
import { deflateSync } from "node:zlib";
import { asked, Gateway, openBrowser, openPage, press, shot, until, wider } from "./gateway.mjs";
import { frame } from "./hostile_device.mjs";
import { mapFile } from "./map_of.mjs";

const crcs = Array.from({ length: 256 }, (_, n) => { for (let k = 0; k < 8; ++k) n = n & 1 ? 0xedb88320 ^ (n >>> 1) : n >>> 1; return n >>> 0; });
const crc = (bytes) => (bytes.reduce((sum, byte) => crcs[(sum ^ byte) & 255] ^ (sum >>> 8), 0xffffffff) ^ 0xffffffff) >>> 0;

/** A picture of 256 × 256 pixels in one colour. */
function png(red, green, blue) {
  const chunk = (name, data) => {
    const body = Buffer.concat([Buffer.from(name, "latin1"), data]), all = Buffer.alloc(body.length + 8);
    all.writeUInt32BE(data.length);
    body.copy(all, 4);
    all.writeUInt32BE(crc(body), body.length + 4);
    return all;
  };
  const head = Buffer.from([0, 0, 1, 0, 0, 0, 1, 0, 8, 3, 0, 0, 0]); // 8 bits, with a palette
  return Buffer.concat([Buffer.from([137, 80, 78, 71, 13, 10, 26, 10]), chunk("IHDR", head), chunk("PLTE", Buffer.from([red, green, blue])), chunk("IDAT", deflateSync(Buffer.alloc(257 * 256))), chunk("IEND", Buffer.alloc(0))]);
}

const zoom = 18; // a tile is 117 m wide at the home position
const tileAt = (lng, lat) => {
  const sine = Math.sin((lat * Math.PI) / 180), n = 2 ** zoom;
  return { x: Math.floor((lng / 360 + 0.5) * n), y: Math.floor((0.5 - Math.log((1 + sine) / (1 - sine)) / (4 * Math.PI)) * n) };
};
const around = ({ x, y }, picture) => [-1, 0, 1].flatMap((i) => [-1, 0, 1].map((k) => ({ zoom, x: x + i, y: y + k, picture })));
/** Green at the origin of the simulated world, blue at its position on Chinese maps, 570 m to the east. */
const tiles = [...around(tileAt(116.3, 39.9), png(20, 160, 60)), ...around(tileAt(116.30624, 39.9014), png(30, 60, 200))];

/** A device that sends its satellite position: the origin of the simulated world. */
function satellites(port) {
  const data = Buffer.alloc(23);
  data.set([3, 12]);
  data.writeInt32LE(116.3e7, 2);
  data.writeInt32LE(39.9e7, 6);
  const socket = dgram.createSocket("udp4");
  const timer = setInterval(() => socket.send(frame(30, 255, 0x30, data), port, "127.0.0.1"), 100);
  return { stop: () => (clearInterval(timer), socket.close()) };
}

async function withMap(datum, content, look) {
  const gateway = await Gateway.start(["sim:fc", "udp-listen:127.0.0.1:0,name=ground"], (folder) => ({ control: { map: { file: join(folder, "map.pmtiles"), datum } } }));
  if (content) writeFileSync(join(gateway.folder, "map.pmtiles"), content);
  const browser = await openBrowser();
  const open = (options) => openPage(browser, gateway, { hash: "#/30/vehicle", ...options });
  let device;
  try {
    const page = await open({ hash: "#/30/log" });
    const ground = (await asked(page, "links")).find((link) => link.name === "ground");
    device = satellites(Number(/127\.0\.0\.1:(\d+)/.exec(JSON.stringify(ground))[1]));
    await page.browserContext().close();
    await look(gateway, open);
  } finally {
    device?.stop();
    await browser.close();
    await gateway.end();
  }
}

/** The colour next to the vehicle, which is in the middle. */
const colour = (page) => page.evaluate(() => {
  const canvas = document.querySelector(".track canvas");
  return canvas && [...canvas.getContext("2d").getImageData(canvas.width / 2 + 40, canvas.height / 2 + 23, 1, 1).data.slice(0, 3)].join(" ");
});
const isColoured = (page, wanted) => until("the map is " + wanted, async () => (await colour(page)) === wanted);

test("lies under the track where satellites say the vehicle is, by the datum of the map", async () => {
  for (const [datum, wanted] of [["wgs84", "20 160 60"], ["gcj02", "30 60 200"]])
    await withMap(datum, mapFile(tiles, { attribution: '<a href="https://example.org">© somebody</a>' }), async (gateway, open) => {
      const page = await open();
      await page.waitForSelector(".track canvas");
      await isColoured(page, wanted);
      await page.waitForFunction(() => document.querySelector(".about-map")?.textContent === "© somebody");
      await shot(page, "map-" + datum);
      await press(page, "Map"); // and without it
      await until("the grid is back", async () => (await colour(page)) !== wanted);
      await press(page, "Map");
      await page.evaluate(() => { location.hash = "#/220/waypoints"; });
      await page.waitForSelector(".waypoints tr");
      await isColoured(page, wanted);
      assert.deepEqual(page.faults, []);
      assert.deepEqual(page.elsewhere, []);
      await page.browserContext().close();
    });
});

test("another one may be put in its place, and what is none is said to be", async () => {
  await withMap("wgs84", undefined, async (gateway, open) => {
    const file = join(gateway.folder, "map.pmtiles");
    const page = await open({ width: 390, height: 844 });
    const says = (words) => until("it says " + words, () => page.$$eval(".about-map", (all, words) => all.some((one) => one.textContent.includes(words)), words));
    await says("No such file or directory");
    assert.ok((await wider(page)) <= 0);
    writeFileSync(file, "no map at all, but long enough to be looked at".repeat(9));
    await says("not a PMTiles file of version 3");
    const put = (content) => (writeFileSync(file + ".new", content), renameSync(file + ".new", file));
    const damaged = mapFile(tiles);
    damaged.fill(0x55, 127, 150);
    put(damaged);
    await says("a directory is damaged");
    put(mapFile(around(tileAt(116.3, 39.9), Buffer.from("no picture"))));
    await says("a tile is not an image");
    put(mapFile(tiles));
    await isColoured(page, "20 160 60");
    await until("nothing is said any more", () => page.$$eval(".about-map.warn", (all) => all.length === 0));
    put(mapFile(around(tileAt(116.3, 39.9), png(200, 10, 10))));
    await page.reload();
    await isColoured(page, "200 10 10");
    await page.browserContext().close();
  });
});
