// A .pmtiles file (version 3) of given pictures, all of the type PNG.
import { gzipSync } from "node:zlib";

/** The position on Hilbert's curve, by the textbook algorithm. */
function numberOf({ zoom, x, y }) {
  const n = 2 ** zoom;
  let number = 0;
  for (let s = n / 2; s >= 1; s /= 2) {
    const rx = (x & s) > 0 ? 1 : 0, ry = (y & s) > 0 ? 1 : 0;
    number += s * s * ((3 * rx) ^ ry);
    if (ry === 0) {
      if (rx === 1) [x, y] = [n - 1 - x, n - 1 - y];
      [x, y] = [y, x];
    }
  }
  return (n * n - 1) / 3 + number;
}

function varint(n) {
  const bytes = [];
  for (; n >= 128; n = Math.floor(n / 128)) bytes.push((n % 128) + 128);
  return [...bytes, n];
}

function directory(entries) {
  const out = varint(entries.length);
  entries.forEach((one, i) => out.push(...varint(one.tile - (i > 0 ? entries[i - 1].tile : 0))));
  for (const one of entries) out.push(...varint(one.run));
  for (const one of entries) out.push(...varint(one.size));
  entries.forEach((one, i) => out.push(...(i > 0 && one.at === entries[i - 1].at + entries[i - 1].size ? [0] : varint(one.at + 1))));
  return Buffer.from(out);
}

function entriesOf(tiles) {
  const places = new Map(), contents = [], entries = [];
  let end = 0;
  for (const tile of [...tiles].sort((a, b) => numberOf(a) - numberOf(b))) {
    const key = Buffer.from(tile.picture).toString("hex");
    if (!places.has(key)) {
      places.set(key, end);
      contents.push(Buffer.from(tile.picture));
      end += tile.picture.length;
    }
    const number = numberOf(tile), at = places.get(key), last = entries[entries.length - 1];
    if (last && last.at === at && last.tile + last.run === number) ++last.run;
    else entries.push({ tile: number, run: 1, size: tile.picture.length, at });
  }
  return { entries, content: Buffer.concat(contents) };
}

export function mapFile(tiles, { leaves = false, packed = true, attribution = "" } = {}) {
  const pack = (bytes) => (packed ? gzipSync(bytes) : bytes);
  const { entries, content } = entriesOf(tiles);
  const half = Math.ceil(entries.length / 2);
  const halves = leaves ? [entries.slice(0, half), entries.slice(half)].filter((part) => part.length > 0) : [];
  const leafBytes = halves.map((part) => pack(directory(part)));
  const rootEntries = leaves ? halves.map((part, i) => ({ tile: part[0].tile, run: 0, size: leafBytes[i].length, at: i === 0 ? 0 : leafBytes[0].length })) : entries;
  const parts = [pack(directory(rootEntries)), pack(Buffer.from(JSON.stringify({ attribution }))), Buffer.concat(leafBytes), content];
  const header = Buffer.alloc(127);
  header.write("PMTiles", "latin1");
  header[7] = 3;
  let at = header.length;
  parts.forEach((part, i) => {
    header.writeBigUInt64LE(BigInt(at), 8 + 16 * i);
    header.writeBigUInt64LE(BigInt(part.length), 16 + 16 * i);
    at += part.length;
  });
  header[97] = packed ? 2 : 1;
  header[98] = 1;
  header[99] = 2;
  header[100] = Math.min(...tiles.map((tile) => tile.zoom));
  header[101] = Math.max(...tiles.map((tile) => tile.zoom));
  return Buffer.concat([header, ...parts]);
}
