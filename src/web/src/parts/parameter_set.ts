// The parameters of a device, typed values, and parameter files. Pure.
import { jsonIn } from "../json";
import { bigIn, isWide, numberIn, wholeRangeOf } from "./numbers";

export interface Parameter {
  id: number;
  key: string; // the name used by the gateway and in files
  name?: string;
  type?: string | null;
  value?: number | string; // "nan", "inf", "-inf" for values not possible in JSON
  text?: string;
  min?: number;
  max?: number;
  mul?: number; // the device stores the value times this as an integer
  missing?: boolean;
  unreadable?: string; // "4 bytes for u8": the received value does not have its type
}

/** Adds the keys, as in files of anoctl: the name; or with the number, "GAIN#3", if the name is empty or not unique. */
export function keyed(all: readonly Omit<Parameter, "key">[]): Parameter[] {
  const known = new Map<string, number>();
  for (const { name = "" } of all) known.set(name, (known.get(name) ?? 0) + 1);
  return all.map((one) => ({ ...one, key: one.name && known.get(one.name) === 1 ? one.name : `${one.name ?? ""}#${one.id}` }));
}

/** Calibration values are valid only for one piece of hardware. */
export const isCalibration = (name: string): boolean => name.startsWith("CAL_");

/** Own properties only, because a device may name a parameter "constructor". */
export const has = (all: object, name: string): boolean => Object.prototype.hasOwnProperty.call(all, name);
export const named = <T>(all: Readonly<Record<string, T>> | undefined, name: string): T | undefined => (all && has(all, name) ? all[name] : undefined);

/** Whether the values are equal, regardless of notation: 5, 5.0, 0x05. */
export function isSame(value: number | string | undefined, text: string, type: string | null | undefined): boolean {
  if (value === undefined) return false;
  if (type === "string" || type === "text") return String(value) === text;
  const words = text.trim();
  if (words === String(value)) return true;
  if (words === "" || (typeof value === "string" && !/^-?\d+$/.test(value))) return false;
  if (isWide(type ?? "")) {
    const whole = bigIn(words);
    return whole !== undefined && whole === bigIn(value);
  }
  const number = Number(words);
  return type === "f32" ? Math.fround(number) === Math.fround(Number(value)) : number === Number(value);
}

type ValueFault = { key: "not_a_number" | "not_whole" } | { key: "out_of_range"; min: number | string; max: number | string };

/** Why the value is not possible; undefined: it is possible according to the parameter's description. */
export function faultOf(parameter: Omit<Parameter, "key">, text: string): ValueFault | undefined {
  const { type, min, max, mul } = parameter;
  if (!type || type === "string" || type === "text") return undefined;
  const words = text.trim();
  const isFloat = type.startsWith("f") || mul !== undefined;
  if (type.startsWith("f") && /^[+-]?(nan|inf)$/i.test(words)) return undefined;
  const number = numberIn(words);
  if (number === undefined || !Number.isFinite(number)) return { key: "not_a_number" };
  if (min !== undefined && max !== undefined && (number < min || number > max)) return { key: "out_of_range", min, max };
  if (isFloat) return undefined;
  const range = wholeRangeOf(type);
  if (!range) return undefined;
  if (!Number.isInteger(number)) return { key: "not_whole" };
  const [least, most] = range, exact = bigIn(words) ?? BigInt(number);
  return exact < least || exact > most ? { key: "out_of_range", min: String(least), max: String(most) } : undefined;
}

/** The typed values that differ from those of the device, by key. */
export function changesOf(parameters: readonly Parameter[], typed: Readonly<Record<string, string>>): Record<string, string> {
  return Object.fromEntries(parameters.flatMap((parameter): [string, string][] => {
    const text = named(typed, parameter.key);
    return text !== undefined && !isSame(parameter.value, text, parameter.type) ? [[parameter.key, text]] : [];
  }));
}

/** The same format as anoctl writes: {device, name, sw, parameters: {NAME: value}}. */
export function fileOf(device: { address: string; name?: string; sw?: number }, parameters: readonly Parameter[]): string {
  const values = Object.fromEntries(parameters.filter((one) => one.value !== undefined).map((one) => [one.key, one.value]));
  return JSON.stringify({ device: device.address, name: device.name, sw: device.sw, parameters: values }, null, 2) + "\n";
}

/** Values by name; undefined: not a parameter file. Integers keep all digits. Texts with U+FFFD are omitted: older versions wrote it instead of GBK. */
export function valuesIn(text: string): Record<string, string> | undefined {
  const json = jsonIn(text.replace(/(:\s*)(-?\d{16,})(?=\s*[,}\]])/g, '$1"$2"'));
  if (typeof json !== "object" || json === null) return undefined;
  const values = (json as { parameters?: unknown }).parameters ?? json;
  if (typeof values !== "object" || values === null || Array.isArray(values)) return undefined;
  return Object.fromEntries(Object.entries(values).filter(([, value]) => typeof value === "number" || (typeof value === "string" && !value.includes("\ufffd"))).map(([name, value]) => [name, String(value)]));
}

/** The device of the file if it is known and differs from `device`, compared by name, or by address if there is no name. Otherwise undefined. */
export function strangerIn(text: string, device: { address: string; name?: string | undefined }): string | undefined {
  const said = (jsonIn(text) ?? {}) as { device?: unknown; name?: unknown };
  if (typeof said.name === "string" && said.name && device.name) return said.name === device.name ? undefined : said.name;
  return typeof said.device === "string" && said.device.toLowerCase() !== device.address.toLowerCase() ? said.device : undefined;
}
