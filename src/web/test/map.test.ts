import assert from "node:assert/strict";
import { test } from "node:test";
import { gcj02Of, onMap } from "../src/map/datum";
import { MapFile } from "../src/map/map_file";
import { tilesUnder, onSquare } from "../src/map/placing";
import { directoryOf, entryFor, headerOf, MapFault, tileNumber } from "../src/map/pmtiles";
import { mapFile, type Tile } from "./browser/map_of.mjs";

test("knows where Chinese maps have a place", () => {
  const near = (a: number, b: number): boolean => Math.abs(a - b) < 1e-9;
  const beijing = gcj02Of({ lng: 116.404, lat: 39.915 });
  assert.ok(near(beijing.lng, 116.41024449916938) && near(beijing.lat, 39.91640428150164), JSON.stringify(beijing));
  assert.deepEqual(gcj02Of({ lng: 2.35, lat: 48.85 }), { lng: 2.35, lat: 48.85 }, "Paris");
  assert.deepEqual(onMap({ lng: 116.404, lat: 39.915 }, "wgs84"), { lng: 116.404, lat: 39.915 });
  assert.deepEqual(onMap({ lng: 116.404, lat: 39.915 }, "gcj02"), beijing);
});

test("counts tiles along the curve", () => {
  assert.deepEqual([[0, 0, 0], [1, 0, 0], [1, 0, 1], [1, 1, 1], [1, 1, 0], [2, 0, 0]].map(([z, x, y]) => tileNumber(z!, x!, y!)), [0, 1, 2, 3, 4, 5]);
  assert.equal(tileNumber(12, 3423, 1763), 19078479);
  for (let zoom = 1; zoom < 7; ++zoom) {
    const all = new Map<number, [number, number]>();
    for (let x = 0; x < 2 ** zoom; ++x) for (let y = 0; y < 2 ** zoom; ++y) all.set(tileNumber(zoom, x, y), [x, y]);
    const first = (4 ** zoom - 1) / 3;
    for (let n = first + 1; n < first + 4 ** zoom; ++n) {
      const [a, b] = [all.get(n - 1)!, all.get(n)!];
      assert.equal(Math.abs(a[0] - b[0]) + Math.abs(a[1] - b[1]), 1, `${zoom}: ${n} lies beside the one before`);
    }
  }
  assert.ok(Number.isSafeInteger(tileNumber(26, 2 ** 26 - 1, 2 ** 26 - 1)));
});

const open = (bytes: Uint8Array): Promise<MapFile> => MapFile.open(({ at, size }) => Promise.resolve(new Uint8Array(bytes.subarray(at, at + size)).buffer));
const words = async (blob: Blob | undefined): Promise<string | undefined> => blob && blob.text();
const tile = (zoom: number, x: number, y: number, says: string): Tile => ({ zoom, x, y, picture: Buffer.from(says) });

for (const [leaves, packed] of [[false, true], [true, true], [true, false]])
  test(`finds tiles ${leaves ? "by two levels of directories" : "in one directory"}, ${packed ? "packed" : "as they are"}`, async () => {
    const tiles = [tile(0, 0, 0, "world"), tile(1, 1, 0, "sea"), tile(1, 1, 1, "sea"), tile(14, 13490, 6203, "field"), tile(14, 13491, 6203, "wood")];
    const file = await open(mapFile(tiles, { leaves, packed, attribution: '<a href="https://example.org">&copy; somebody</a>' }));
    assert.deepEqual([file.header.minZoom, file.header.maxZoom, file.header.type], [0, 14, "image/png"]);
    for (const one of tiles) assert.equal(await words(await file.tile(one.zoom, one.x, one.y)), one.picture.toString());
    for (const [z, x, y] of [[1, 0, 0], [14, 13492, 6203], [13, 0, 0]]) assert.equal(await file.tile(z!, x!, y!), undefined);
    assert.equal(await file.attribution(), "© somebody");
  });

test("an unfit or damaged file is said to be one, whatever is in it", async () => {
  const good = mapFile([tile(0, 0, 0, "world"), tile(1, 1, 1, "sea")], { leaves: true, packed: false });
  const damaged = (change: (bytes: Uint8Array) => void): Uint8Array => { const bytes = Uint8Array.from(good); change(bytes); return bytes; };
  for (const [why, bytes] of [
    ["empty", new Uint8Array(0)], ["short", good.slice(0, 90)], ["another", damaged((b) => (b[0] = 0x51))], ["version 2", damaged((b) => (b[7] = 2))],
    ["vector tiles", damaged((b) => (b[99] = 1))], ["brotli", damaged((b) => (b[97] = 3))], ["zooms", damaged((b) => (b[101] = 40))], ["far root", damaged((b) => (b[14] = 1))],
  ] as [string, Uint8Array][]) await assert.rejects(open(bytes), MapFault, why);
  const inGzip = mapFile([tile(0, 0, 0, "world")]);
  inGzip.fill(0x55, 127, 140);
  await assert.rejects(open(inGzip), MapFault, "what is no gzip");
  let seed = 1;
  const random = (below: number): number => (seed = (seed * 48271) % 2147483647) % below;
  for (let i = 0; i < 2000; ++i) {
    const bytes = damaged((b) => { for (let k = 0; k < 4; ++k) b[random(b.length)] = random(256); });
    await open(bytes).then((file) => file.tile(1, 1, 1)).catch((fault: unknown) => assert.ok(fault instanceof Error));
  }
  assert.throws(() => directoryOf(Uint8Array.of(0xff, 0xff, 0xff, 0xff, 0x7f)));
  assert.throws(() => directoryOf(Uint8Array.of(1, 5, 1, 1)));
  assert.throws(() => headerOf(new ArrayBuffer(126)));
});

test("one entry stands for tiles that are the same", () => {
  const entries = [{ tile: 5, run: 3, size: 1, at: 0 }, { tile: 20, run: 0, size: 9, at: 0 }];
  assert.deepEqual([4, 5, 7, 8, 19, 20, 99].map((n) => entryFor(entries, n)?.tile), [undefined, 5, 5, undefined, undefined, 20, 20]);
  assert.equal(entryFor([], 5), undefined);
});

test("lays tiles so that the place in the middle is in the middle, and no pixel is bare", () => {
  const middle = { lng: 116.391, lat: 39.907 };
  for (const metres of [0.002, 0.05, 0.6, 5, 100]) {
    const all = tilesUnder(middle, metres, 390, 384, 0, 18);
    assert.ok(all.length > 0 && all.length < 60, `${metres}: ${all.length}`);
    const under = all.find((one) => one.left <= 195 && one.left + one.size > 195 && one.top <= 192 && one.top + one.size > 192)!;
    const at = onSquare(middle), count = 2 ** under.zoom;
    assert.ok(Math.abs(under.left + (at.x * count - under.x) * under.size - 195) < 1e-3 * 390);
    assert.ok(Math.abs(under.top + (at.y * count - under.y) * under.size - 192) < 1e-3 * 390);
    assert.ok(Math.min(...all.map((one) => one.left)) <= 0 && Math.max(...all.map((one) => one.left + one.size)) >= 390);
  }
  assert.deepEqual(tilesUnder(middle, 100, 390, 384, 18, 18), [], "too many of them");
  assert.deepEqual(tilesUnder({ lng: 0, lat: 89 }, 1, 390, 384, 0, 18), []);
  assert.deepEqual(tilesUnder({ lng: 179.9999, lat: 0 }, 5, 390, 384, 0, 14).map((one) => one.x).sort((a, b) => a - b)[0], 0, "it goes round");
});
