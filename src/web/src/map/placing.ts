// The tiles visible in a drawing and their positions: Web Mercator, north up. Pure.
import type { Place } from "./datum";

const equator = 2 * Math.PI * 6378137; // m
const tileSize = 256; // pixels: natural size of a tile
const minSize = 64; // pixels: with smaller tiles there would be too many
const maxLatitude = 85; // degrees; Web Mercator maps end there

export interface PlacedTile {
  zoom: number;
  x: number;
  y: number;
  left: number; // pixels in the drawing
  top: number;
  size: number;
}

/** As fractions of the whole map, from its upper left corner. */
export function onSquare({ lng, lat }: Place): { x: number; y: number } {
  const sine = Math.sin((lat * Math.PI) / 180);
  return { x: lng / 360 + 0.5, y: 0.5 - Math.log((1 + sine) / (1 - sine)) / (4 * Math.PI) };
}

/** `middle` is the centre of a drawing of `width` × `height` pixels. Uses the zoom of the map at which the tiles are nearest to their natural size. */
export function tilesUnder(middle: Place, metresPerPixel: number, width: number, height: number, minZoom: number, maxZoom: number): PlacedTile[] {
  if (Math.abs(middle.lat) > maxLatitude || !(metresPerPixel > 0)) return [];
  const square = (equator * Math.cos((middle.lat * Math.PI) / 180)) / metresPerPixel; // width of the whole map in pixels
  const zoom = Math.min(Math.max(Math.round(Math.log2(square / tileSize)), minZoom), maxZoom);
  const count = 2 ** zoom, size = square / count;
  if (size < minSize) return [];
  const at = onSquare(middle);
  const left = width / 2 - at.x * square, top = height / 2 - at.y * square;
  const all: PlacedTile[] = [];
  for (let y = Math.max(0, Math.floor(-top / size)); y < count && top + y * size < height; ++y)
    for (let column = Math.floor(-left / size); left + column * size < width; ++column)
      all.push({ zoom, x: ((column % count) + count) % count, y, left: left + column * size, top: top + y * size, size });
  return all;
}
