// Reads the structure of .pmtiles files, version 3. Pure. Each number in the file is checked before use.
import type { Fault, Key } from "../i18n";

export interface Part {
  at: number; // bytes from the start of the file
  size: number;
}

export interface MapHeader {
  root: Part;
  about: Part; // metadata (JSON)
  leaves: Part;
  tiles: Part;
  packed: boolean; // directories and metadata are compressed with gzip
  type: string; // media type of the pictures
  minZoom: number;
  maxZoom: number;
}

export interface Entry {
  tile: number;
  run: number; // number of consecutive tiles with this picture; 0: the entry is a directory
  size: number;
  at: number;
}

export const headerSize = 127;
const maxWholeZoom = 26; // at higher zooms, a double can't represent the numbers of tiles exactly
const maxEntries = 1 << 20;
const pictures: Record<number, string> = { 2: "image/png", 3: "image/jpeg", 4: "image/webp", 5: "image/avif" };

/** The reason why a map can't be shown: a text of the page with its arguments, or the reason of the gateway. */
export class MapFault extends Error {
  constructor(
    readonly why: Key | Fault,
    readonly args: Record<string, unknown> = {},
  ) {
    super(typeof why === "string" ? why : why.error);
  }
}
export const damaged = (why: string): MapFault => new MapFault("map_damaged", { why });

function whole(view: DataView, at: number): number {
  const number = Number(view.getBigUint64(at, true));
  if (!Number.isSafeInteger(number)) throw damaged("an offset beyond 2^53");
  return number;
}

export function headerOf(bytes: ArrayBuffer): MapHeader {
  const view = new DataView(bytes);
  const magic = [0x50, 0x4d, 0x54, 0x69, 0x6c, 0x65, 0x73, 3]; // "PMTiles", version 3
  if (bytes.byteLength < headerSize || magic.some((byte, i) => view.getUint8(i) !== byte)) throw new MapFault("map_of_other_version");
  const part = (at: number): Part => ({ at: whole(view, at), size: whole(view, at + 8) });
  const packing = view.getUint8(97), type = pictures[view.getUint8(99)];
  if (packing !== 1 && packing !== 2) throw new MapFault("map_not_gzip");
  if (!type) throw new MapFault("map_no_images");
  const minZoom = view.getUint8(100), maxZoom = view.getUint8(101);
  if (minZoom > maxZoom || maxZoom > maxWholeZoom) throw new MapFault("map_zooms", { minZoom, maxZoom });
  return { root: part(8), about: part(24), leaves: part(40), tiles: part(56), packed: packing === 2, type, minZoom, maxZoom };
}

/** Numbers with seven bits per byte, least significant first (varints). */
class Numbers {
  private at = 0;

  constructor(private readonly bytes: Uint8Array) {}

  next(): number {
    let number = 0;
    for (let factor = 1; factor <= 2 ** 49; factor *= 128) {
      const byte = this.bytes[this.at++];
      if (byte === undefined) throw damaged("a directory ends too early");
      number += (byte & 127) * factor;
      if (byte < 128) return number;
    }
    throw damaged("a number in a directory is too large");
  }
}

export function directoryOf(bytes: Uint8Array): Entry[] {
  const numbers = new Numbers(bytes);
  const count = numbers.next();
  if (count > maxEntries || count > bytes.length) throw damaged("a directory has too many entries");
  const entries: Entry[] = [];
  let tile = 0;
  for (let i = 0; i < count; ++i) entries.push({ tile: (tile += numbers.next()), run: 0, size: 0, at: 0 });
  for (const entry of entries) entry.run = numbers.next();
  for (const entry of entries) entry.size = numbers.next();
  let end = 0; // end of the previous entry: most entries are contiguous
  for (const [i, entry] of entries.entries()) {
    const said = numbers.next();
    if (said === 0 && i === 0) throw damaged("a directory has no start offset");
    entry.at = said === 0 ? end : said - 1;
    end = entry.at + entry.size;
  }
  return entries;
}

/** The entry that contains `tile`; undefined: none. */
export function entryFor(entries: readonly Entry[], tile: number): Entry | undefined {
  let low = 0, high = entries.length; // all entries before `low` begin at or before `tile`
  while (low < high) {
    const middle = (low + high) >> 1;
    if (entries[middle]!.tile <= tile) low = middle + 1;
    else high = middle;
  }
  const entry = entries[low - 1];
  return entry && (entry.run === 0 || tile < entry.tile + entry.run) ? entry : undefined;
}

/** Tiles are numbered zoom by zoom, and within a zoom along the Hilbert curve, so that neighbours have similar numbers. */
export function tileNumber(zoom: number, x: number, y: number): number {
  let number = (4 ** zoom - 1) / 3;
  for (let side = 2 ** (zoom - 1); side >= 1; side /= 2) {
    const right = (x & side) !== 0, down = (y & side) !== 0;
    number += side * side * (right ? (down ? 2 : 3) : down ? 1 : 0);
    if (down) continue;
    if (right) (x = side - 1 - (x & (side - 1))), (y = side - 1 - (y & (side - 1)));
    [x, y] = [y, x];
  }
  return number;
}
