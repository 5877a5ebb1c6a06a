// Draws the ground from above: a grid or a map, the track, the planned route.
import { onMap, type Datum, type Place } from "../map/datum";
import { tilesUnder } from "../map/placing";
import { mapTiles } from "../map/tiles";
import { onEarth } from "./waypoint_set";

export interface Point {
  x: number; // m; up
  y: number; // m; left
}
export interface Mark extends Point {
  label: string;
}
export interface Scene {
  track: readonly Point[];
  marks: readonly Mark[];
  now: Point | undefined;
  origin?: Place; // position on earth of { x: 0, y: 0 }, if up is north
}

/** Spacing of the grid, with at least 45 pixels between lines: 1, 2 or 5 times a power of ten. */
export function gridStep(metresPerPixel: number): number {
  const minStep = metresPerPixel * 45;
  const power = 10 ** Math.floor(Math.log10(minStep));
  return power * ([1, 2, 5, 10].find((n) => n * power >= minStep) ?? 10);
}

/** The centre of the marks and the start. */
export function middleOf(marks: readonly Point[]): Point {
  const xs = [0, ...marks.map((mark) => mark.x)], ys = [0, ...marks.map((mark) => mark.y)];
  return { x: (Math.min(...xs) + Math.max(...xs)) / 2, y: (Math.min(...ys) + Math.max(...ys)) / 2 };
}

/** The scale in metres per pixel at which all marks are visible. */
export function scaleFor(marks: readonly Point[]): number {
  const middle = middleOf(marks);
  const farthest = Math.max(10, ...marks.map((mark) => Math.max(Math.abs(mark.x - middle.x), Math.abs(mark.y - middle.y))));
  return farthest / 150;
}

interface Sheet {
  pen: CanvasRenderingContext2D;
  width: number;
  height: number;
  scale: number; // metres per pixel
  middle: Point;
  px(p: Point): number;
  py(p: Point): number;
  colour(name: string): string;
}

function sheetOn(canvas: HTMLCanvasElement, middle: Point, scale: number): Sheet | undefined {
  const ratio = devicePixelRatio || 1;
  const width = canvas.clientWidth, height = canvas.clientHeight;
  if (canvas.width !== Math.round(width * ratio)) canvas.width = Math.round(width * ratio);
  if (canvas.height !== Math.round(height * ratio)) canvas.height = Math.round(height * ratio);
  const pen = canvas.getContext("2d");
  if (!pen || width === 0) return undefined;
  const style = getComputedStyle(canvas);
  pen.setTransform(ratio, 0, 0, ratio, 0, 0);
  pen.clearRect(0, 0, width, height);
  pen.font = "12px system-ui, sans-serif";
  const px = (p: Point): number => width / 2 - (p.y - middle.y) / scale;
  const py = (p: Point): number => height / 2 - (p.x - middle.x) / scale;
  return { pen, width, height, scale, middle, px, py, colour: (name) => style.getPropertyValue(name).trim() };
}

const maxZoomsUp = 4; // while a tile is missing, a part of a tile up to this many zooms lower is shown

function drawMap({ pen, width, height, scale, middle }: Sheet, origin: Place, datum: Datum): void {
  const zooms = mapTiles.zooms;
  if (!zooms) return;
  for (const { zoom, x, y, left, top, size } of tilesUnder(onMap(onEarth(origin, middle), datum), scale, width, height, zooms.minZoom, zooms.maxZoom))
    for (let up = 0; up <= Math.min(maxZoomsUp, zoom - zooms.minZoom); ++up) {
      const picture = mapTiles.picture(zoom - up, x >> up, y >> up, up === 0);
      if (!picture) continue;
      const part = picture.width / 2 ** up, mask = 2 ** up - 1;
      pen.drawImage(picture, (x & mask) * part, (y & mask) * part, part, part, left, top, size + 0.5, size + 0.5); // 0.5: avoids gaps between tiles
      break;
    }
}

function drawGrid({ pen, width, height, scale, middle, px, py, colour }: Sheet): void {
  const step = gridStep(scale);
  pen.lineWidth = 1;
  const line = (k: number, x0: number, y0: number, x1: number, y1: number): void => {
    pen.strokeStyle = colour(k === 0 ? "--bed" : "--line");
    pen.beginPath(); pen.moveTo(x0, y0); pen.lineTo(x1, y1); pen.stroke();
  };
  for (let k = Math.ceil((middle.y - (width / 2) * scale) / step); k * step <= middle.y + (width / 2) * scale; ++k) {
    const at = Math.round(px({ x: 0, y: k * step })) + 0.5;
    line(k, at, 0, at, height);
  }
  for (let k = Math.ceil((middle.x - (height / 2) * scale) / step); k * step <= middle.x + (height / 2) * scale; ++k) {
    const at = Math.round(py({ x: k * step, y: 0 })) + 0.5;
    line(k, 0, at, width, at);
  }
}

/** Text with an outline, to be readable on any background. */
function write({ pen, colour }: Sheet, words: string, x: number, y: number, ink: string): void {
  pen.lineWidth = 3;
  pen.strokeStyle = colour("--card");
  pen.strokeText(words, x, y);
  pen.fillStyle = colour(ink);
  pen.fillText(words, x, y);
}

/** A scale bar with the spacing of the grid. */
function drawScale(sheet: Sheet): void {
  const { pen, height, scale, colour } = sheet;
  const step = gridStep(scale);
  pen.fillStyle = colour("--ink");
  pen.fillRect(8, height - 7, step / scale, 2);
  write(sheet, step >= 1000 ? `${step / 1000} km` : `${step >= 1 ? step : step.toFixed(2)} m`, 8, height - 12, "--ink");
}

function stroke({ pen, px, py }: Sheet, points: readonly Point[]): void {
  pen.beginPath();
  points.forEach((point, i) => (i === 0 ? pen.moveTo(px(point), py(point)) : pen.lineTo(px(point), py(point))));
  pen.stroke();
}

function drawWays(sheet: Sheet, { track, marks }: Scene, way: boolean): void {
  const { pen, px, py, colour } = sheet;
  pen.lineJoin = "round";
  pen.lineWidth = 2;
  pen.strokeStyle = colour("--accent");
  stroke(sheet, track);
  const home = { x: 0, y: 0 };
  if (way) {
    pen.strokeStyle = colour("--warn");
    pen.setLineDash([6, 5]);
    stroke(sheet, [home, ...marks]);
    pen.setLineDash([]);
  }
  pen.strokeStyle = colour("--ink");
  pen.beginPath(); pen.arc(px(home), py(home), 5, 0, 7); pen.stroke();
  for (const mark of marks) {
    pen.fillStyle = colour("--ink");
    pen.beginPath(); pen.arc(px(mark), py(mark), 4, 0, 7); pen.fill();
    write(sheet, mark.label, px(mark) + 7, py(mark) + 4, "--ink");
  }
}

function drawVehicle({ pen, px, py, colour }: Sheet, now: Point, yaw: number): void {
  pen.save();
  pen.translate(px(now), py(now));
  pen.rotate((-yaw * Math.PI) / 180);
  pen.fillStyle = colour("--bad");
  pen.beginPath(); pen.moveTo(0, -12); pen.lineTo(8, 10); pen.lineTo(0, 5); pen.lineTo(-8, 10); pen.closePath();
  pen.lineWidth = 2; // outline, to be visible on any background
  pen.strokeStyle = colour("--card");
  pen.stroke();
  pen.fill();
  pen.restore();
}

/** `datum`: of the map, which is drawn instead of the grid; `way`: connects the marks in order. */
export function drawGround(canvas: HTMLCanvasElement, scene: Scene, yaw: number, scale: number, way: boolean, datum: Datum | undefined): void {
  const sheet = sheetOn(canvas, scene.now ?? middleOf(scene.marks), scale);
  if (!sheet) return;
  if (datum && scene.origin) drawMap(sheet, scene.origin, datum);
  else drawGrid(sheet);
  drawWays(sheet, scene, way);
  drawScale(sheet);
  if (scene.now) drawVehicle(sheet, scene.now, yaw);
}
