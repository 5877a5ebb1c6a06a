// The received frames: one row for each link, sender and message, with its rate and its last frame.
import type { FrameRecord } from "../protocol/records";
import type { MessageTable } from "../protocol/table";
import { Rate } from "./rate";

export class FrameRow {
  count = 0;
  bytes = 0;
  to = 0;
  time = 0; // Unix seconds, by the gateway's clock
  cause = 0;
  data = new Uint8Array(0);
  readonly rate = new Rate();

  constructor(
    readonly key: string,
    readonly link: number,
    readonly from: number,
    readonly id: number,
    readonly variant: number, // first byte of DATA, if it distinguishes messages of the same id; otherwise -1
  ) {}
}

/** A hostile sender can use 254 sources × 256 messages; the page shows at most this many rows. */
const maxRows = 2000;

export class FrameRows {
  private readonly all = new Map<string, FrameRow>();
  private apart = new Set<number>();
  left_out = 0;

  constructor(table?: MessageTable) {
    this.setTable(table);
  }

  setTable(table: MessageTable | undefined): void {
    this.apart = new Set(table?.rows.filter((row) => row.replaces === "same_first_byte").map((row) => row.id));
  }

  /** `now`: seconds of the page's clock. */
  add(record: FrameRecord, now: number): FrameRow | undefined {
    const variant = this.apart.has(record.id) ? (record.data[0] ?? -1) : -1;
    const key = `${record.from}.${record.id}.${variant}.${record.link}`;
    let row = this.all.get(key);
    if (!row) {
      if (this.all.size >= maxRows) {
        ++this.left_out;
        return undefined;
      }
      row = new FrameRow(key, record.link, record.from, record.id, variant);
      this.all.set(key, row);
    }
    ++row.count;
    row.bytes += record.data.length + 8;
    row.to = record.to;
    row.time = record.time;
    row.cause = record.cause;
    if (row.data.length === record.data.length) row.data.set(record.data);
    else row.data = record.data.slice();
    row.rate.add(now);
    return row;
  }

  sorted(): FrameRow[] {
    return [...this.all.values()].sort((a, b) => a.from - b.from || a.id - b.id || a.variant - b.variant || a.link - b.link);
  }

  get(key: string): FrameRow | undefined {
    return this.all.get(key);
  }

  clear(): void {
    this.all.clear();
    this.left_out = 0;
  }
}
