// The fields shown in the chart, and their values from frames.
import { entryOf } from "../entries";
import type { FrameRecord } from "../protocol/records";
import { Reading, type FieldRow, type MessageRow, type MessageTable } from "../protocol/table";
import { Series } from "./series";

export interface Chosen {
  from: number;
  id: number;
  field: string;
}

export const keyOf = (one: Chosen): string => `${one.from}.${one.id}.${one.field}`;

export interface Line extends Chosen {
  series: Series;
  unit: string;
  label: string;
}

export class ChartData {
  readonly lines: Line[] = [];
  private readonly byFrame = new Map<number, Line[]>();
  private readonly fieldsOf = new Map<MessageRow, Map<string, FieldRow | undefined>>();
  /** Received senders and messages: from × 256 + id. */
  readonly heard = new Set<number>();
  private offset: number | undefined; // Unix time of the boot of the gateway's computer; kept, because its clock may be changed later
  newest = Number.NEGATIVE_INFINITY;

  constructor(
    readonly table: MessageTable,
    private readonly nameOf: (address: number) => string,
  ) {}

  add(chosen: Chosen): void {
    if (this.lines.some((line) => keyOf(line) === keyOf(chosen))) return;
    const field = this.table.layouts(chosen.id).flatMap((row) => row.fields).find((one) => one.name === chosen.field);
    const line: Line = { ...chosen, series: new Series(), unit: field?.unit ?? "", label: `${this.nameOf(chosen.from)} ${this.table.name(chosen.id)}.${chosen.field}` };
    this.lines.push(line);
    this.regroup();
  }

  remove(key: string): void {
    const at = this.lines.findIndex((line) => keyOf(line) === key);
    if (at >= 0) this.lines.splice(at, 1);
    this.regroup();
  }

  private regroup(): void {
    this.byFrame.clear();
    for (const line of this.lines) entryOf(this.byFrame, line.from * 256 + line.id, (): Line[] => []).push(line);
  }

  take(record: FrameRecord): void {
    const frame = record.from * 256 + record.id;
    this.heard.add(frame);
    const lines = this.byFrame.get(frame);
    if (!lines) return;
    this.offset ??= record.time - record.boot;
    const time = record.boot + this.offset;
    if (time > this.newest) this.newest = time;
    const row = this.table.layoutOf(record.id, record.from, record.data);
    if (typeof row === "string") return;
    const reading = new Reading(row, record.data);
    for (const line of lines) {
      const field = this.fieldIn(row, line.field);
      const value = field && reading.value(field);
      if (typeof value === "number") line.series.push(time, value);
      else if (value === null) line.series.push(time, Number.NaN);
    }
  }

  private fieldIn(row: MessageRow, name: string): FieldRow | undefined {
    let fields = this.fieldsOf.get(row);
    if (!fields) this.fieldsOf.set(row, (fields = new Map()));
    if (!fields.has(name)) fields.set(name, row.fields.find((field) => field.name === name));
    return fields.get(name);
  }

  /** Frames after this were missed: the curves end until the next value. */
  gap(): void {
    for (const { series } of this.lines) if (series.length > 0) series.push(series.lastTime(), Number.NaN);
  }

  clear(): void {
    for (const line of this.lines) line.series.clear();
    this.newest = Number.NEGATIVE_INFINITY;
  }
}
