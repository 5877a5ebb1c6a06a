// The message table of the gateway (GET /messages), and decoding of frames. No message has special treatment by its name here.
import { entryOf } from "../entries";

export interface FieldRow {
  name: string;
  type: string; // "u8" … "f64", "text", "bytes", "ip", "frames", "list"
  offset: number;
  count?: number | null; // null: up to the end of DATA
  endian?: "big"; // most significant byte first
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
  source?: number; // flexible layout for only this sender
  fields: FieldRow[];
  element?: FieldRow[];
}

/** null: "no data", by a sentinel or NaN. Bytes are hex text. */
export type Value = number | bigint | string | null | Value[] | { [name: string]: Value };

export type Unreadable = "unknown_id" | "unknown_layout" | "too_short";

const numberSizes: Record<string, number> = { u8: 1, i8: 1, u16: 2, i16: 2, u32: 4, i32: 4, u64: 8, i64: 8, f32: 4, f64: 8 };

/** Addresses of hosts, which are not devices. */
export const hosts: readonly number[] = [0xfe, 0xd2];
export const isHost = (address: number): boolean => hosts.includes(address);

export const isNumeric = (type: string): boolean => type in numberSizes;

/** Whether it is a single number. */
export const isNumber = ({ type, count }: FieldRow): boolean => isNumeric(type) && (count ?? 1) === 1;

/** Messages whose fields are defined by devices. */
export const isFlexible = (id: number): boolean => id >= 0xf1 && id <= 0xfa;

const isOpen = (field: FieldRow): boolean => field.count === null || field.type === "list";

/** The size of a field in bytes; 0 if it extends to the end of DATA. */
export function sizeOf(field: FieldRow): number {
  if (isOpen(field)) return 0;
  const one = field.type === "ip" ? 4 : (numberSizes[field.type] ?? 1);
  return one * (field.count ?? 1);
}

const bytesOf = (field: FieldRow, data: Uint8Array): Uint8Array => data.subarray(field.offset, isOpen(field) ? data.length : field.offset + sizeOf(field));
const sizeOfAll = (fields: readonly FieldRow[] = []): number => fields.reduce((sum, field) => sum + sizeOf(field), 0);

export function hexOf(bytes: Uint8Array): string {
  let text = "";
  for (const byte of bytes) text += byte.toString(16).padStart(2, "0");
  return text;
}

export const hexByte = (n: number): string => "0x" + n.toString(16).toUpperCase().padStart(2, "0");

function wireNumber(field: FieldRow, view: DataView, at: number): number | bigint {
  const little = field.endian !== "big";
  switch (field.type) {
    case "u8": return view.getUint8(at);
    case "i8": return view.getInt8(at);
    case "u16": return view.getUint16(at, little);
    case "i16": return view.getInt16(at, little);
    case "u32": return view.getUint32(at, little);
    case "i32": return view.getInt32(at, little);
    case "u64": return view.getBigUint64(at, little);
    case "i64": return view.getBigInt64(at, little);
    case "f32": return view.getFloat32(at, little);
    default: return view.getFloat64(at, little);
  }
}

/** 4567 hundredths are 45.67, not 45.67000000000001: divides if 1 / scale is an integer. */
function scaled(wire: number, scale: number): number {
  if (scale === 1) return wire;
  const divisor = 1 / scale;
  const whole = Math.round(divisor);
  return whole > 1 && Math.abs(divisor - whole) < 1e-6 * whole ? wire / whole : wire * scale;
}

function numberAt(field: FieldRow, view: DataView, at: number): number | bigint | null {
  const wire = wireNumber(field, view, at);
  if (typeof wire === "bigint") return wire >= -9007199254740991n && wire <= 9007199254740991n ? Number(wire) : wire;
  if (field.no_data !== undefined && wire === field.no_data) return null;
  if (!Number.isFinite(wire)) return null;
  return scaled(wire, field.scale ?? 1);
}

const utf8 = new TextDecoder("utf-8");
const utf8Strict = new TextDecoder("utf-8", { fatal: true });
let gbk: TextDecoder | undefined;

/** Number of bytes of an incomplete UTF-8 character at the end; 0: none. */
function cutUtf8(bytes: Uint8Array): number {
  for (let n = 1; n <= 3 && n <= bytes.length; n++) {
    const byte = bytes[bytes.length - n] ?? 0;
    if ((byte & 0xc0) === 0x80) continue;
    return byte >= 0xc2 && byte <= 0xf4 && n < (byte < 0xe0 ? 2 : byte < 0xf0 ? 3 : 4) ? n : 0;
  }
  return 0;
}

/** Whether the last byte begins an incomplete GBK character. */
function isCutGbk(bytes: Uint8Array): boolean {
  let at = 0;
  while (at < bytes.length) at += (bytes[at] ?? 0) > 0x80 && bytes[at] !== 0xff ? 2 : 1;
  return at > bytes.length;
}

const isUtf8 = (bytes: Uint8Array): boolean => {
  try {
    utf8Strict.decode(bytes.subarray(0, bytes.length - cutUtf8(bytes)));
    return true;
  } catch {
    return false;
  }
};

function gbkOf(bytes: Uint8Array): string | undefined {
  try {
    gbk ??= new TextDecoder("gbk", { fatal: true });
    return gbk.decode(isCutGbk(bytes) ? bytes.subarray(0, -1) : bytes);
  } catch {
    return undefined;
  }
}

const used = (bytes: Uint8Array): Uint8Array => {
  const end = bytes.indexOf(0);
  return end < 0 ? bytes : bytes.subarray(0, end);
};

/** Whether the text is GBK and not UTF-8. */
export const isGbk = (bytes: Uint8Array): boolean => !isUtf8(used(bytes)) && gbkOf(used(bytes)) !== undefined;

/**
 * The text up to the first zero byte, without an incomplete last character. Decoded as GBK if it is not UTF-8, or if the sender is known to
 * write GBK.
 */
export function textOf(bytes: Uint8Array, writesGbk = false): string {
  const text = used(bytes);
  if (!writesGbk && isUtf8(text)) return utf8.decode(text.subarray(0, text.length - cutUtf8(text)));
  return gbkOf(text) ?? utf8.decode(text);
}

const viewOf = (data: Uint8Array): DataView => new DataView(data.buffer, data.byteOffset, data.byteLength);

/** DATA of a frame, decoded with a layout of the table. */
export class Reading {
  constructor(
    readonly row: MessageRow,
    readonly data: Uint8Array,
    private readonly isGbk = false,
  ) {}

  value(field: FieldRow): Value {
    const { data } = this;
    if (field.type === "list") return this.elements(field.offset);
    const bytes = bytesOf(field, data);
    if (field.type === "text") return textOf(bytes, this.isGbk);
    if (field.type === "ip") return Array.from(bytes).join(".");
    if (!isNumeric(field.type)) return hexOf(bytes);
    const view = viewOf(data);
    if (isNumber(field)) return numberAt(field, view, field.offset);
    const step = numberSizes[field.type]!, end = field.offset + bytes.length;
    const all: Value[] = [];
    for (let at = field.offset; at + step <= end; at += step) all.push(numberAt(field, view, at));
    return all;
  }

  private elements(from: number): Value[] {
    const element = this.row.element ?? [];
    const size = sizeOfAll(element), view = viewOf(this.data);
    const all: Value[] = [];
    for (let at = from; size > 0 && at + size <= this.data.length; at += size)
      all.push(Object.fromEntries(element.map((f) => [f.name, numberAt(f, view, at + f.offset)])));
    return all;
  }

  get(name: string): Value | undefined {
    const field = this.row.fields.find((f) => f.name === name);
    return field && this.value(field);
  }

  number(name: string): number | undefined {
    const value = this.get(name);
    return typeof value === "number" ? value : undefined;
  }

  fields(): { field: FieldRow; value: Value }[] {
    return this.row.fields.map((field) => ({ field, value: this.value(field) }));
  }

  /** Bytes after the layout: allowed, but with unknown meaning. */
  extra(): Uint8Array {
    const last = this.row.fields[this.row.fields.length - 1];
    if (last && last.type === "list") {
      const size = sizeOfAll(this.row.element);
      return size > 0 ? this.data.subarray(this.data.length - ((this.data.length - last.offset) % size)) : this.data.subarray(last.offset);
    }
    return last && isOpen(last) ? new Uint8Array(0) : this.data.subarray(this.row.size);
  }
}

/** Whether this is text without control characters, followed only by zero bytes. */
function isPaddedText(bytes: Uint8Array): boolean {
  const text = used(bytes);
  return text.every((byte) => byte >= 0x20 && byte !== 0x7f) && bytes.subarray(text.length).every((byte) => byte === 0);
}

/** Whether these bytes can have this layout; the same rule as in the gateway. */
function isPlausible(row: MessageRow, data: Uint8Array): boolean {
  if (data.length < row.size) return false;
  const view = viewOf(data);
  if (row.by_look) {
    const min = row.fields.find((field) => field.name === "min"), max = row.fields.find((field) => field.name === "max");
    if (min && max && view.getInt32(min.offset, true) > view.getInt32(max.offset, true)) return false;
    const texts = row.fields.filter((field) => field.type === "text" && !isOpen(field));
    if (!texts.every((field) => isPaddedText(bytesOf(field, data)))) return false;
  }
  for (const field of row.fields) {
    const first = data[field.offset] ?? 0;
    if (field.type === "text" && !isOpen(field) && (first < 0x20 || first === 0x7f || first === 0x80 || first === 0xff)) return false;
    if (!field.range || !isNumeric(field.type) || field.type.startsWith("f")) continue;
    const value = scaled(Number(wireNumber(field, view, field.offset)), field.scale ?? 1);
    if (value < field.range[0] || value > field.range[1]) return false;
  }
  return true;
}

/** In DATA longer than the layout, other fields may precede the known ones. Applies only to messages whose frames replace earlier ones. */
function isPerhapsShifted(row: MessageRow, data: Uint8Array): boolean {
  const last = row.fields.at(-1);
  return row.replaces !== "nothing" && data.length > row.size && last !== undefined && !isOpen(last);
}

function fits(row: MessageRow, base: MessageRow, data: Uint8Array): boolean {
  if (isPerhapsShifted(row, data)) return false;
  if (row.length !== undefined && (row === base ? data.length > row.length : data.length !== row.length)) return false;
  if (row.by_look && (isPlausible(base, data) || !isPlausible(row, data))) return false;
  for (const field of row.fields) {
    if (!field.only) continue;
    if (data.length < field.offset + sizeOf(field)) return false;
    const value = Number(wireNumber(field, viewOf(data), field.offset));
    if (value < field.only[0] || value > field.only[1]) return false;
  }
  return true;
}

export class MessageTable {
  private readonly byId = new Map<number, MessageRow[]>();
  private readonly gbkSenders = new Set<number>(); // senders of at least one text that was GBK and not UTF-8

  constructor(readonly rows: MessageRow[]) {
    for (const row of rows) entryOf(this.byId, row.id, (): MessageRow[] => []).push(row);
  }

  /** All layouts of an id, the base layout first. */
  layouts(id: number): readonly MessageRow[] {
    return this.byId.get(id) ?? [];
  }

  name(id: number): string {
    return this.layouts(id)[0]?.name ?? hexByte(id);
  }

  idOf(name: string): number | undefined {
    return this.rows.find((row) => row.name === name)?.id;
  }

  title(id: number): string {
    return this.layouts(id)[0]?.title ?? "";
  }

  /** The layout of DATA of `id` from `source`, or the reason why there is none. */
  layoutOf(id: number, source: number, data: Uint8Array): MessageRow | Unreadable {
    const all = this.layouts(id);
    const base = all[0];
    if (!base) return "unknown_id";
    const row = this.chosen(all, base, source, data);
    if (row) return data.length < row.size ? "too_short" : row;
    return base.fields.length > 0 && data.length <= (base.fields[0]?.offset ?? 0) ? "too_short" : "unknown_layout";
  }

  private chosen(all: readonly MessageRow[], base: MessageRow, source: number, data: Uint8Array): MessageRow | undefined {
    if (isFlexible(base.id)) {
      const rank = (row: MessageRow): number => (row.source === undefined ? 0 : 2) + (row.fields[0]?.only ? 1 : 0);
      const fitting = all.filter((row) => row.fields.length > 0 && (row.source ?? source) === source && fits(row, base, data));
      return fitting.sort((a, b) => rank(b) - rank(a))[0];
    }
    return all.slice(1).find((row) => fits(row, base, data)) ?? (fits(base, base, data) ? base : undefined);
  }

  read(id: number, source: number, data: Uint8Array): Reading | Unreadable {
    const row = this.layoutOf(id, source, data);
    if (typeof row === "string") return row;
    const texts = row.fields.filter((field) => field.type === "text");
    if (!this.gbkSenders.has(source) && texts.some((field) => isGbk(bytesOf(field, data)))) this.gbkSenders.add(source);
    return new Reading(row, data, this.gbkSenders.has(source));
  }
}
