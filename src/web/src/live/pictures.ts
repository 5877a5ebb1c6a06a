// Assembles pictures from frames that contain some rows each. Frames of one picture have the same sender, flag, colour and size, and arrive in the
// order of the rows. Rows have no numbers, so a lost frame is detected only when the next picture begins. Pure.
import type { Reading } from "../protocol/table";

export interface Picture {
  from: number;
  flag: number;
  colour: number; // 0: grey, one byte per pixel; otherwise one bit per pixel, most significant first
  width: number;
  height: number;
  pixels: Uint8Array;
  filled: number; // received bytes
  began: number; // Unix seconds
}

const maxBytes = 16 * 1024 * 1024;
const pause = 1; // seconds without frames, after which the next picture begins

export const rowBytes = (picture: { colour: number; width: number }): number => (picture.colour === 0 ? picture.width : (picture.width + 7) >> 3);

export class Pictures {
  private readonly begun = new Map<number, { picture: Picture; last: number }>();
  refused = 0;

  /** Returns the pictures that end with this frame: complete, or with missing rows. */
  take(reading: Reading, from: number, time: number): Picture[] {
    const number = (name: string): number => reading.number(name) ?? 0;
    const picture: Picture = { from, flag: number("flag"), colour: number("color"), width: number("width"), height: number("height"), pixels: new Uint8Array(0), filled: 0, began: time };
    const field = reading.row.fields.find((one) => one.name === "pixels");
    const rows = field ? reading.data.subarray(field.offset) : new Uint8Array(0);
    const row = rowBytes(picture), size = row * picture.height;
    if (picture.colour > 6 || size === 0 || size > maxBytes || rows.length === 0 || rows.length % row !== 0 || rows.length > size) {
      ++this.refused;
      return [];
    }
    const ended: Picture[] = [];
    let known = this.begun.get(from);
    const before = known?.picture;
    const same = before && before.flag === picture.flag && before.colour === picture.colour && before.width === picture.width && before.height === picture.height;
    if (known && before && (!same || before.filled + rows.length > size || time - known.last > pause)) {
      ended.push(before);
      known = undefined;
    }
    if (!known) {
      picture.pixels = new Uint8Array(size);
      known = { picture, last: time };
      this.begun.set(from, known);
    }
    known.picture.pixels.set(rows, known.picture.filled);
    known.picture.filled += rows.length;
    known.last = time;
    if (known.picture.filled === size) {
      ended.push(known.picture);
      this.begun.delete(from);
    }
    return ended;
  }
}

const tints: [number, number, number][] = [[255, 255, 255], [255, 255, 255], [255, 60, 60], [60, 220, 90], [80, 140, 255], [255, 220, 60], [200, 90, 255]];

/** Red, green, blue and opacity of each pixel; missing pixels are transparent. */
export function pixelsOf(picture: Picture): Uint8ClampedArray<ArrayBuffer> {
  const { width, height, colour, pixels, filled } = picture;
  const row = rowBytes(picture), all = new Uint8ClampedArray(width * height * 4);
  const [r, g, b] = tints[colour] ?? tints[0]!;
  const rows = Math.floor(filled / row);
  for (let y = 0; y < rows; ++y)
    for (let x = 0; x < width; ++x) {
      const to = (y * width + x) * 4;
      const light = colour === 0 ? pixels[y * row + x]! / 255 : (pixels[y * row + (x >> 3)]! >> (7 - (x & 7))) & 1;
      all[to] = r * light;
      all[to + 1] = g * light;
      all[to + 2] = b * light;
      all[to + 3] = 255;
    }
  return all;
}
