// The last frame of each message from one device.
import { entryOf } from "../entries";
import type { FrameRecord } from "../protocol/records";
import { Reading, type MessageTable, type Value } from "../protocol/table";
import { FrameRow } from "./rows";

export interface Seen {
  value: number;
  unit: string;
  late: boolean;
}

/** Converts lengths and speeds to the units shown to users. */
export function inPeoplesUnits(value: number, unit: string): [number, string] {
  if (unit === "cm") return [value / 100, "m"];
  if (unit === "cm/s") return [value / 100, "m/s"];
  if (unit === "mm") return [value / 1000, "m"];
  return [value, unit];
}

export class Latest {
  private readonly rows = new Map<number, FrameRow>();
  version = 0;
  /** The device is lost: none of its values is current. */
  isGone = false;

  constructor(private readonly table: MessageTable) {}

  take(record: FrameRecord, now: number): void {
    const row = entryOf(this.rows, record.id, () => new FrameRow("", record.link, record.from, record.id, -1));
    row.data = record.data.slice();
    row.time = record.time;
    row.rate.add(now);
    ++this.version;
  }

  private row(message: string): FrameRow | undefined {
    const id = this.table.idOf(message);
    return id === undefined ? undefined : this.rows.get(id);
  }

  reading(message: string): Reading | undefined {
    const row = this.row(message);
    const reading = row && this.table.read(row.id, row.from, row.data);
    return reading instanceof Reading ? reading : undefined;
  }

  value(message: string, field: string): Value | undefined {
    return this.reading(message)?.get(field);
  }

  isLate(message: string, now: number): boolean {
    return this.isGone || (this.row(message)?.rate.isLate(now) ?? true);
  }

  /** Seconds since the last frame of this message; undefined: never received. */
  age(message: string, now: number): number | undefined {
    return this.row(message)?.rate.age(now);
  }

  /** A number in the units shown to users; undefined: never received, or "no data". */
  number(message: string, field: string, now: number): Seen | undefined {
    const reading = this.reading(message);
    const row = reading?.row.fields.find((one) => one.name === field);
    const value = row && reading?.value(row);
    if (typeof value !== "number") return undefined;
    const [said, unit] = inPeoplesUnits(value, row?.unit ?? "");
    return { value: said, unit, late: this.isLate(message, now) };
  }
}
