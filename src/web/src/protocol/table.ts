// The message table of the gateway (GET /messages), and reading frames by it. No message is treated by its name here.

export interface FieldRow {
  name: string;
  type: string; // "u8" … "f64", "text", "bytes", "ip", "frames", "list"
  offset: number;
  count?: number | null; // null: to the end
  scale?: number;
  unit?: string;
  range?: [number, number];
  no_data?: number;
  only?: [number, number];
  label?: string;
  note?: string;
  values?: Record<string, string>;
}

export interface MessageRow {
  id: number;
  name: string;
  title: string;
  layout?: string;
  length?: number;
  by_look?: boolean;
  size: number;
  class: string;
  replaces: string;
  acknowledged: string;
  source?: number; // a flexible layout of this sender only
  fields: FieldRow[];
  element?: FieldRow[];
}

/** null: "no data": a sentinel, or NaN. Bytes are hex. */
export type Value = number | bigint | string | null | Value[] | { [name: string]: Value };

export type Unreadable = "unknown_id" | "unknown_layout" | "too_short";

const numberSizes: Record<string, number> = { u8: 1, i8: 1, u16: 2, i16: 2, u32: 4, i32: 4, u64: 8, i64: 8, f32: 4, f64: 8 };

export const isNumeric = (type: string): boolean => type in numberSizes;

const isOpen = (field: FieldRow): boolean => field.count === null || field.type === "list";

/** The size of a field in bytes; 0 if it extends to the end. */
export function sizeOf(field: FieldRow): number {
  if (isOpen(field)) return 0;
  const one = field.type === "ip" ? 4 : (numberSizes[field.type] ?? 1);
  return one * (field.count ?? 1);
}

export function hexOf(bytes: Uint8Array): string {
  let text = "";
  for (const byte of bytes) text += byte.toString(16).padStart(2, "0");
  return text;
}

export const hexByte = (n: number): string => "0x" + n.toString(16).toUpperCase().padStart(2, "0");

function wireNumber(type: string, view: DataView, at: number): number | bigint {
  switch (type) {
    case "u8": return view.getUint8(at);
    case "i8": return view.getInt8(at);
    case "u16": return view.getUint16(at, true);
    case "i16": return view.getInt16(at, true);
    case "u32": return view.getUint32(at, true);
    case "i32": return view.getInt32(at, true);
    case "u64": return view.getBigUint64(at, true);
    case "i64": return view.getBigInt64(at, true);
    case "f32": return view.getFloat32(at, true);
    default: return view.getFloat64(at, true);
  }
}

/** 4567 hundredths are 45.67, not 45.67000000000001: divides if the scale is one over an integer. */
function scaled(wire: number, scale: number): number {
  if (scale === 1) return wire;
  const divisor = 1 / scale;
  const whole = Math.round(divisor);
  return whole > 1 && Math.abs(divisor - whole) < 1e-6 * whole ? wire / whole : wire * scale;
}

function numberAt(field: FieldRow, view: DataView, at: number): number | bigint | null {
  const wire = wireNumber(field.type, view, at);
  if (typeof wire === "bigint") return wire >= -9007199254740991n && wire <= 9007199254740991n ? Number(wire) : wire;
  if (field.no_data !== undefined && wire === field.no_data) return null;
  if (!Number.isFinite(wire)) return null;
  return scaled(wire, field.scale ?? 1);
}

const utf8 = new TextDecoder("utf-8");
const utf8Strict = new TextDecoder("utf-8", { fatal: true });
let gbk: TextDecoder | undefined;

/** Up to the first zero byte; decoded as GBK, which is common, when it is not UTF-8. */
export function textOf(bytes: Uint8Array): string {
  const end = bytes.indexOf(0);
  const used = end < 0 ? bytes : bytes.subarray(0, end);
  try {
    return utf8Strict.decode(used);
  } catch {
    try {
      gbk ??= new TextDecoder("gbk", { fatal: true });
      return gbk.decode(used);
    } catch {
      return utf8.decode(used);
    }
  }
}

const viewOf = (data: Uint8Array): DataView => new DataView(data.buffer, data.byteOffset, data.byteLength);

/** A frame's DATA in one layout of the table. */
export class Reading {
  constructor(
    readonly row: MessageRow,
    readonly data: Uint8Array,
  ) {}

  value(field: FieldRow): Value {
    const { data } = this;
    const end = isOpen(field) ? data.length : field.offset + sizeOf(field);
    if (field.type === "list") return this.elements(field.offset);
    const bytes = data.subarray(field.offset, end);
    if (field.type === "text") return textOf(bytes);
    if (field.type === "ip") return Array.from(bytes).join(".");
    if (!isNumeric(field.type)) return hexOf(bytes);
    const view = viewOf(data);
    if ((field.count ?? 1) === 1) return numberAt(field, view, field.offset);
    const step = numberSizes[field.type]!;
    const all: Value[] = [];
    for (let at = field.offset; at + step <= end; at += step) all.push(numberAt(field, view, at));
    return all;
  }

  private elements(from: number): Value[] {
    const element = this.row.element ?? [];
    const size = element.reduce((sum, f) => sum + sizeOf(f), 0);
    const view = viewOf(this.data);
    const all: Value[] = [];
    for (let at = from; size > 0 && at + size <= this.data.length; at += size)
      all.push(Object.fromEntries(element.map((f) => [f.name, numberAt(f, view, at + f.offset)])));
    return all;
  }

  get(name: string): Value | undefined {
    const field = this.row.fields.find((f) => f.name === name);
    return field && this.value(field);
  }

  fields(): { field: FieldRow; value: Value }[] {
    return this.row.fields.map((field) => ({ field, value: this.value(field) }));
  }

  /** Bytes after the layout: allowed, but their meaning is not known. */
  extra(): Uint8Array {
    const last = this.row.fields[this.row.fields.length - 1];
    if (last && last.type === "list") {
      const size = (this.row.element ?? []).reduce((sum, f) => sum + sizeOf(f), 0);
      return size > 0 ? this.data.subarray(this.data.length - ((this.data.length - last.offset) % size)) : this.data.subarray(last.offset);
    }
    return last && isOpen(last) ? new Uint8Array(0) : this.data.subarray(this.row.size);
  }
}

/** Whether these bytes can have this layout; the same rule as in the gateway. */
function isPlausible(row: MessageRow, data: Uint8Array): boolean {
  if (data.length < row.size) return false;
  const view = viewOf(data);
  for (const field of row.fields) {
    const first = data[field.offset] ?? 0;
    if (field.type === "text" && !isOpen(field) && (first < 0x20 || first === 0x7f || first === 0x80 || first === 0xff)) return false;
    if (!field.range || !isNumeric(field.type) || field.type.startsWith("f")) continue;
    const value = scaled(Number(wireNumber(field.type, view, field.offset)), field.scale ?? 1);
    if (value < field.range[0] || value > field.range[1]) return false;
  }
  return true;
}

function fits(row: MessageRow, base: MessageRow, data: Uint8Array): boolean {
  if (row.length !== undefined && row.length !== data.length) return false;
  if (row.by_look && (isPlausible(base, data) || !isPlausible(row, data))) return false;
  for (const field of row.fields) {
    if (!field.only) continue;
    if (data.length < field.offset + sizeOf(field)) return false;
    const value = Number(wireNumber(field.type, viewOf(data), field.offset));
    if (value < field.only[0] || value > field.only[1]) return false;
  }
  return true;
}

export class MessageTable {
  private readonly byId = new Map<number, MessageRow[]>();

  constructor(readonly rows: MessageRow[]) {
    for (const row of rows) {
      const known = this.byId.get(row.id);
      if (known) known.push(row);
      else this.byId.set(row.id, [row]);
    }
  }

  /** Every layout of an id, the base first. */
  layouts(id: number): readonly MessageRow[] {
    return this.byId.get(id) ?? [];
  }

  name(id: number): string {
    return this.layouts(id)[0]?.name ?? hexByte(id);
  }

  title(id: number): string {
    return this.layouts(id)[0]?.title ?? "";
  }

  /** The layout of DATA of `id` from `source`, or why there is none. */
  layoutOf(id: number, source: number, data: Uint8Array): MessageRow | Unreadable {
    const all = this.layouts(id);
    const base = all[0];
    if (!base) return "unknown_id";
    const row = this.chosen(all, base, source, data);
    if (row) return data.length < row.size ? "too_short" : row;
    return base.fields.length > 0 && data.length <= (base.fields[0]?.offset ?? 0) ? "too_short" : "unknown_layout";
  }

  private chosen(all: readonly MessageRow[], base: MessageRow, source: number, data: Uint8Array): MessageRow | undefined {
    const own = all.find((row) => row.source === source);
    if (own) return own;
    if (base.id >= 0xf1 && base.id <= 0xfa) return all.find((row) => row.source === undefined && row.fields.length > 0);
    return all.slice(1).find((row) => fits(row, base, data)) ?? (fits(base, base, data) ? base : undefined);
  }

  read(id: number, source: number, data: Uint8Array): Reading | Unreadable {
    const row = this.layoutOf(id, source, data);
    return typeof row === "string" ? row : new Reading(row, data);
  }
}
