// Draws the chart with uPlot, with only as many points as there are pixel columns.
import uPlot from "uplot";
import { clockText } from "../format";
import type { Line } from "../live/chart_data";
import { columnTimes, envelope, wentOver } from "../live/series";

export const colours = ["#1f77d0", "#d9541e", "#2a9d4a", "#a13fc4", "#c49a00", "#d43a6b", "#0a9aa8", "#7a5a3a", "#6a72e8", "#7d8b00", "#b0402f", "#3d7f6a"];
const maxAxes = 4;

const css = (name: string): string => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
const scaleOf = (unit: string): string => "y" + unit;

/** Draws one or two values per pixel column: vertical bars for adjacent columns, lines over gaps. Bars cost a tenth of a line through all values.
 * Where an angle wraps around, its ends are not connected. */
export function drawColumns(plot: uPlot, values: readonly (number | null)[], unit: string, colour: string): void {
  const { ctx, bbox } = plot;
  const range = plot.scales[scaleOf(unit)];
  if (range?.min == null || range.max == null || values.length === 0) return;
  const { min, max } = range, times = plot.data[0] as number[];
  const perUnit = bbox.height / (max - min || 1), bottom = bbox.top + bbox.height;
  const thick = Math.max(1, Math.round(devicePixelRatio));
  const x = plot.scales.x!, perSecond = bbox.width / (x.max! - x.min!);
  ctx.save();
  ctx.beginPath();
  ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
  ctx.clip();
  ctx.fillStyle = ctx.strokeStyle = colour;
  ctx.lineWidth = thick;
  ctx.beginPath();
  const upright = (at: number, top: number, low: number): void => ctx.fillRect(Math.round(at), Math.round(top - thick / 2), thick, Math.max(thick, Math.round(low - top)));
  let before = -4, beforeX = 0, beforeY = 0, last = 0, gaps = false;
  for (let i = 0; i + 1 < values.length; i += 2) {
    const first = values[i], second = values[i + 1];
    if (first == null) continue;
    if (second == null || Number.isNaN(first)) {
      before = -4; // the line ends here
      continue;
    }
    const at = bbox.left + (times[i]! - x.min!) * perSecond;
    const y1 = bottom - (first - min) * perUnit, y2 = bottom - (second - min) * perUnit;
    let top = Math.min(y1, y2), low = Math.max(y1, y2);
    const over = before >= 0 && wentOver(unit, last, first);
    if (wentOver(unit, first, second)) {
      upright(at, y1, y1);
      top = low = y2;
    } else if (before === i - 2 && !over) {
      if (beforeY < top) top = beforeY;
      else if (beforeY > low) low = beforeY;
    } else if (before >= 0 && !over) {
      ctx.moveTo(beforeX, beforeY);
      ctx.lineTo(at, y1);
      gaps = true;
    }
    upright(at, top, low);
    before = i;
    last = second;
    beforeX = at;
    beforeY = y2;
  }
  if (gaps) ctx.stroke();
  ctx.restore();
}

export class Plot {
  private plot: uPlot;
  private readonly data: (number | null)[][];
  private columns = 0;
  private from = 0;
  private to = 1;

  /** `onLook` receives the time at the pointer, or undefined; `onZoom` receives a range selected by the user. */
  constructor(
    private readonly holder: HTMLElement,
    private readonly lines: readonly Line[],
    onLook: (time: number | undefined) => void,
    onZoom: (from: number, to: number) => void,
  ) {
    this.data = [[], ...lines.map(() => [])];
    const units = [...new Set(lines.map((line) => line.unit))];
    const ink = css("--soft"), grid = { stroke: css("--line"), width: 1 };
    const options: uPlot.Options = {
      width: 300,
      height: 300,
      legend: { show: false },
      cursor: { drag: { x: true, y: false, setScale: false }, points: { show: false } },
      scales: { x: { time: true, auto: false }, ...Object.fromEntries(units.map((unit) => [scaleOf(unit), { auto: true }])) },
      axes: [
        { stroke: ink, grid, ticks: grid, space: 100, values: (_, all, __, ___, step) => all.map((at) => clockText(at, step < 1).slice(0, step >= 60 ? 5 : undefined)) },
        ...units.slice(0, maxAxes).map((unit, i): uPlot.Axis => ({ scale: scaleOf(unit), side: i % 2 === 0 ? 3 : 1, stroke: ink, ticks: grid, grid: i === 0 ? grid : { show: false }, label: unit || "–", labelSize: 18, size: 54 })),
      ],
      series: [{}, ...lines.map((line, i): uPlot.Series => ({ label: line.label, scale: scaleOf(line.unit), stroke: colours[i % colours.length]!, paths: () => null, points: { show: false } }))],
      hooks: {
        draw: [(plot) => lines.forEach((line, i) => drawColumns(plot, this.data[i + 1]!, line.unit, colours[i % colours.length]!))],
        setCursor: [(plot) => onLook(plot.cursor.left !== undefined && plot.cursor.left >= 0 ? plot.posToVal(plot.cursor.left, "x") : undefined)],
        setSelect: [
          (plot) => {
            const { left, width } = plot.select;
            if (width > 8) onZoom(plot.posToVal(left, "x"), plot.posToVal(left + width, "x"));
            plot.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
          },
        ],
      },
    };
    this.plot = new uPlot(options, this.data as unknown as uPlot.AlignedData, holder);
    this.fit();
  }

  fit(): void {
    const width = this.holder.clientWidth, height = this.holder.clientHeight;
    if (width > 0 && (width !== this.plot.width || height !== this.plot.height)) this.plot.setSize({ width, height });
    this.columns = Math.max(16, Math.floor(this.plot.bbox.width / devicePixelRatio));
  }

  /** Does nothing if no pixel would change. */
  draw(from: number, to: number, changed: boolean): void {
    const pixel = (to - from) / Math.max(this.columns, 1);
    if (!changed && Math.abs(from - this.from) < pixel && Math.abs(to - this.to) < pixel) return;
    this.from = from;
    this.to = to;
    // Columns are aligned to fixed times, so that a peak does not change its height while the chart moves.
    const start = Math.floor(from / pixel) * pixel, end = start + (this.columns + 1) * pixel;
    columnTimes(start, end, this.columns + 1, this.data[0] as number[]);
    this.lines.forEach((line, i) => envelope(line.series, start, end, this.columns + 1, this.data[i + 1]!));
    this.plot.batch(() => {
      this.plot.setData(this.data as unknown as uPlot.AlignedData, false);
      this.plot.setScale("x", { min: from, max: to });
    });
  }

  canvas(): HTMLCanvasElement {
    return this.plot.ctx.canvas;
  }

  destroy(): void {
    this.plot.destroy();
  }
}
