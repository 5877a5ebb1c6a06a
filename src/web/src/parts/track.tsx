// Where a vehicle was, seen from above on a metric grid: up is x, forward at take-off, left is y.
import { useEffect, useRef, useState } from "preact/hooks";
import { t } from "../i18n";

export interface Point {
  x: number; // m
  y: number;
}

const mostPoints = 6000;
const nearest = 0.05; // m: nearer ones are the same point

/** Of each device as long as the page is open. */
const tracks = new Map<number, Point[]>();
export function trackOf(device: number): Point[] {
  let track = tracks.get(device);
  if (!track) tracks.set(device, (track = []));
  return track;
}

export function addPoint(track: Point[], point: Point): void {
  const last = track[track.length - 1];
  if (last && Math.hypot(last.x - point.x, last.y - point.y) < nearest) return;
  track.push(point);
  // Every second point of the older half goes: the way stays.
  if (track.length > mostPoints) {
    const half = track.splice(0, mostPoints / 2).filter((_, i) => i % 2 === 0);
    track.unshift(...half);
  }
}

/** A step of the grid that leaves lines at least 45 pixels apart: 1, 2 or 5 times a power of ten. */
export function gridStep(metresPerPixel: number): number {
  const least = metresPerPixel * 45;
  const power = 10 ** Math.floor(Math.log10(least));
  return power * ([1, 2, 5, 10].find((n) => n * power >= least) ?? 10);
}

export interface Mark extends Point {
  label: string;
}

/** Between the marks and where it began. */
function middleOf(marks: readonly Point[]): Point {
  const xs = [0, ...marks.map((mark) => mark.x)], ys = [0, ...marks.map((mark) => mark.y)];
  return { x: (Math.min(...xs) + Math.max(...xs)) / 2, y: (Math.min(...ys) + Math.max(...ys)) / 2 };
}

/** Metres a pixel with which all marks are seen. */
function scaleFor(marks: readonly Point[]): number {
  const middle = middleOf(marks);
  const farthest = Math.max(10, ...marks.map((mark) => Math.max(Math.abs(mark.x - middle.x), Math.abs(mark.y - middle.y))));
  return farthest / 150;
}

function draw(canvas: HTMLCanvasElement, track: readonly Point[], marks: readonly Mark[], now: Point | undefined, yaw: number, scale: number, way: boolean): void {
  const ratio = devicePixelRatio || 1;
  const width = canvas.clientWidth, height = canvas.clientHeight;
  if (canvas.width !== Math.round(width * ratio)) canvas.width = Math.round(width * ratio);
  if (canvas.height !== Math.round(height * ratio)) canvas.height = Math.round(height * ratio);
  const pen = canvas.getContext("2d");
  if (!pen || width === 0) return;
  const style = getComputedStyle(canvas);
  const colour = (name: string): string => style.getPropertyValue(name).trim();
  pen.setTransform(ratio, 0, 0, ratio, 0, 0);
  pen.clearRect(0, 0, width, height);
  const middle = now ?? middleOf(marks);
  const px = (p: Point): number => width / 2 - (p.y - middle.y) / scale;
  const py = (p: Point): number => height / 2 - (p.x - middle.x) / scale;

  const step = gridStep(scale);
  pen.lineWidth = 1;
  pen.font = "12px system-ui, sans-serif";
  pen.fillStyle = colour("--soft");
  for (let k = Math.ceil((middle.y - (width / 2) * scale) / step); k * step <= middle.y + (width / 2) * scale; ++k) {
    pen.strokeStyle = colour(k === 0 ? "--bed" : "--line");
    const at = Math.round(px({ x: 0, y: k * step })) + 0.5;
    pen.beginPath(); pen.moveTo(at, 0); pen.lineTo(at, height); pen.stroke();
  }
  for (let k = Math.ceil((middle.x - (height / 2) * scale) / step); k * step <= middle.x + (height / 2) * scale; ++k) {
    pen.strokeStyle = colour(k === 0 ? "--bed" : "--line");
    const at = Math.round(py({ x: k * step, y: 0 })) + 0.5;
    pen.beginPath(); pen.moveTo(0, at); pen.lineTo(width, at); pen.stroke();
  }
  pen.fillText(`${step >= 1 ? step : step.toFixed(2)} m`, 8, height - 8);

  pen.strokeStyle = colour("--accent");
  pen.lineWidth = 2;
  pen.lineJoin = "round";
  pen.beginPath();
  track.forEach((point, i) => (i === 0 ? pen.moveTo(px(point), py(point)) : pen.lineTo(px(point), py(point))));
  pen.stroke();

  const home = { x: 0, y: 0 };
  if (way) {
    pen.strokeStyle = colour("--warn");
    pen.setLineDash([6, 5]);
    pen.beginPath();
    pen.moveTo(px(home), py(home));
    for (const mark of marks) pen.lineTo(px(mark), py(mark));
    pen.stroke();
    pen.setLineDash([]);
  }
  pen.strokeStyle = colour("--ink");
  pen.beginPath(); pen.arc(px(home), py(home), 5, 0, 7); pen.stroke();
  pen.fillStyle = colour("--ink");
  for (const mark of marks) {
    pen.beginPath(); pen.arc(px(mark), py(mark), 4, 0, 7); pen.fill();
    pen.fillText(mark.label, px(mark) + 7, py(mark) + 4);
  }
  if (now) {
    pen.save();
    pen.translate(px(now), py(now));
    pen.rotate((-yaw * Math.PI) / 180);
    pen.fillStyle = colour("--bad");
    pen.beginPath(); pen.moveTo(0, -12); pen.lineTo(8, 10); pen.lineTo(0, 5); pen.lineTo(-8, 10); pen.closePath(); pen.fill();
    pen.restore();
  }
}

/** `way`: the marks are gone to in their order. */
export function Track({ device, now, yaw, marks = [], way = false }: { device: number; now: Point | undefined; yaw: number; marks?: Mark[]; way?: boolean }) {
  const canvas = useRef<HTMLCanvasElement>(null);
  const [chosen, setScale] = useState<number>(); // metres a pixel
  const scale = chosen ?? (way ? scaleFor(marks) : 0.05);
  const current = useRef(scale);
  current.current = scale;
  const zoom = (factor: number): void => setScale(Math.min(Math.max(current.current * factor, 0.002), 100));
  const track = trackOf(device);
  useEffect(() => {
    if (canvas.current) draw(canvas.current, track, marks, now, yaw, scale, way);
  });
  useEffect(() => {
    const element = canvas.current;
    const wheel = (event: WheelEvent): void => {
      event.preventDefault();
      zoom(event.deltaY > 0 ? 1.25 : 0.8);
    };
    element?.addEventListener("wheel", wheel, { passive: false });
    return () => element?.removeEventListener("wheel", wheel);
  }, []);
  const where = now ? `x ${now.x.toFixed(1)} m, y ${now.y.toFixed(1)} m` : t("no_data");
  return (
    <div class="track">
      <canvas ref={canvas} role="img" aria-label={`${t("track")}: ${where}`} />
      <div class="zoom">
        <button aria-label={t("zoom_in")} onClick={() => zoom(0.67)}>+</button>
        <button aria-label={t("zoom_out")} onClick={() => zoom(1.5)}>−</button>
        <button aria-label={t("clear_track")} title={t("clear_track")} onClick={() => void (track.length = 0)}>⌫</button>
      </div>
    </div>
  );
}
