// Formats numbers and times for people.
import type { FieldRow, Value } from "./protocol/table";

/** The number of decimal places for a scale. */
export function digitsOf(scale: number | undefined): number {
  if (scale === undefined || scale >= 1) return 0;
  return Math.min(Math.max(Math.ceil(-Math.log10(scale) - 1e-9), 0), 7);
}

/** Without a minus sign before zero. */
export const fixed = (value: number, digits: number): string => value.toFixed(digits).replace(/^-(0(\.0*)?)$/, "$1");

/** With at most this number of significant digits. */
export const significant = (value: number, digits: number): string => String(Number(value.toPrecision(digits)));

/** Short text for tables: about four significant digits. */
export function shortNumber(value: number): string {
  const size = Math.abs(value);
  if (!Number.isFinite(value)) return "–";
  if (size >= 1e9) return (value / 1e9).toFixed(size >= 1e10 ? 1 : 2) + " G";
  if (size >= 1e6) return (value / 1e6).toFixed(size >= 1e7 ? 1 : 2) + " M";
  if (size >= 1e4) return (value / 1e3).toFixed(size >= 1e5 ? 0 : 1) + " k";
  if (size >= 100 || size === 0 || Number.isInteger(value)) return value.toFixed(0);
  return value.toFixed(size >= 10 ? 1 : 2);
}

export function bytesText(bytes: number): string {
  if (bytes < 1000) return `${bytes} B`;
  const power = Math.min(Math.floor(Math.log10(bytes) / 3), 4);
  const size = bytes / 1000 ** power;
  return `${size.toFixed(size < 10 ? 1 : 0)} ${["", "kB", "MB", "GB", "TB"][power]}`;
}

export function rateText(perSecond: number | undefined): string {
  if (perSecond === undefined) return "–";
  if (perSecond === 0) return "0";
  return perSecond > 0 && perSecond < 0.05 ? "<0.1" : perSecond >= 10 ? shortNumber(Math.round(perSecond)) : perSecond.toFixed(1);
}

export function duration(seconds: number, zh = false): string {
  const s = Math.max(0, Math.floor(seconds));
  const unit = zh ? [" 天 ", " 小时", " 分", " 秒"] : [" d ", " h", " min", " s"];
  if (s >= 86400) return `${Math.floor(s / 86400)}${unit[0]}${Math.floor((s % 86400) / 3600)}${unit[1]}`;
  if (s >= 3600) return `${Math.floor(s / 3600)}${unit[1]} ${Math.floor((s % 3600) / 60)}${unit[2]}`;
  if (s >= 60) return `${Math.floor(s / 60)}${unit[2]} ${s % 60}${unit[3]}`;
  return `${s}${unit[3]}`;
}

/** In local time: 2026-11-23. */
export function dayText(time: number): string {
  const date = new Date(time * 1000), two = (n: number): string => String(n).padStart(2, "0");
  return `${date.getFullYear()}-${two(date.getMonth() + 1)}-${two(date.getDate())}`;
}
/** In local time: 14:05:09, or 14:05:09.123. */
export function clockText(time: number, isPrecise = false): string {
  const date = new Date(time * 1000), whole = date.toTimeString().slice(0, 8);
  return isPrecise ? `${whole}.${String(date.getMilliseconds()).padStart(3, "0")}` : whole;
}

export function numberText(value: number | bigint, field: FieldRow): string {
  if (typeof value === "bigint") return value.toString();
  if (field.type === "f32") return significant(value, 7);
  if (field.type === "f64") return value.toString();
  return field.scale !== undefined && field.scale < 1 ? value.toFixed(digitsOf(field.scale)) : String(value);
}

const maxText = 400; // characters of a text from a device

/** Without the unit. Text from a device is never interpreted as HTML. */
export function valueText(value: Value, field: FieldRow): string {
  if (value === null) return "–";
  if (typeof value === "number" || typeof value === "bigint") return numberText(value, field);
  if (typeof value === "string") return value.length > maxText ? value.slice(0, maxText) + "…" : value;
  if (Array.isArray(value)) {
    const shown = value.slice(0, 16).map((one) => valueText(one, field));
    return "[" + shown.join(", ") + (value.length > 16 ? `, … ${value.length}` : "") + "]";
  }
  return Object.entries(value).map(([name, one]) => `${name} ${one === null ? "–" : String(one)}`).join(" ");
}

/** The meaning of an enumeration value; undefined: not known. */
export const meaningOf = (value: Value, field: FieldRow): string | undefined =>
  typeof value === "number" ? field.values?.[String(value)] : undefined;
