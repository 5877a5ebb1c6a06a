// The parameters of a device, the input for them, and files of them. Pure.
export interface Parameter {
  id: number;
  name?: string;
  type?: string | null;
  value?: number | string; // "nan", "inf", "-inf" for values that JSON does not have
  text?: string;
  min?: number;
  max?: number;
  mul?: number; // the device has the value times this, as an integer
  missing?: boolean;
  unreadable?: string; // "4 bytes for u8": what came is no value of its type
}

export const nameOf = (parameter: Parameter): string => parameter.name || String(parameter.id);

/** Calibration values, which are valid for one piece of hardware only. */
export const isCalibration = (name: string): boolean => name.startsWith("CAL_");

/** Devices choose the names of their parameters, also "constructor". */
export const has = (all: object, name: string): boolean => Object.prototype.hasOwnProperty.call(all, name);
export const named = <T>(all: Readonly<Record<string, T>> | undefined, name: string): T | undefined => (all && has(all, name) ? all[name] : undefined);

/** Whether the values are equal, independent of notation: 5, 5.0, 0x05. */
export function isSame(value: number | string | undefined, text: string, type: string | null | undefined): boolean {
  if (value === undefined) return false;
  if (type === "string" || type === "text") return String(value) === text;
  const words = text.trim();
  if (words === String(value)) return true;
  if (words === "" || (typeof value === "string" && !/^-?\d+$/.test(value))) return false;
  if (/64$/.test(type ?? "") && type !== "f64") {
    try {
      return BigInt(words) === BigInt(value);
    } catch {
      return false;
    }
  }
  const number = Number(words);
  return type === "f32" ? Math.fround(number) === Math.fround(Number(value)) : number === Number(value);
}

export type ValueFault = { key: "not_a_number" | "not_whole" } | { key: "out_of_range"; min: number | string; max: number | string };

/** Why the device can't have this value; undefined: it can, as far as its description says. */
export function faultOf(parameter: Parameter, text: string): ValueFault | undefined {
  const { type, min, max, mul } = parameter;
  if (!type || type === "string" || type === "text") return undefined;
  const words = text.trim();
  const isFloat = type.startsWith("f") || mul !== undefined;
  if (type.startsWith("f") && /^[+-]?(nan|inf)$/i.test(words)) return undefined;
  const number = words === "" ? Number.NaN : Number(words);
  if (Number.isNaN(number) || !Number.isFinite(number)) return { key: "not_a_number" };
  if (min !== undefined && max !== undefined && (number < min || number > max)) return { key: "out_of_range", min, max };
  if (isFloat) return undefined;
  const [, sign, bits] = /^([ui])(8|16|32|64)$/.exec(type) ?? [];
  if (!sign) return undefined;
  if (!Number.isInteger(number)) return { key: "not_whole" };
  const least = sign === "u" ? 0n : -(1n << BigInt(Number(bits) - 1)), most = (1n << BigInt(Number(bits) - (sign === "u" ? 0 : 1))) - 1n;
  const exact = bigIn(words) ?? BigInt(number);
  return exact < least || exact > most ? { key: "out_of_range", min: String(least), max: String(most) } : undefined;
}

function bigIn(words: string): bigint | undefined {
  try {
    return BigInt(words);
  } catch {
    return undefined;
  }
}

/** The values that differ from those of the device, by name. */
export function changesOf(parameters: readonly Parameter[], typed: Readonly<Record<string, string>>): Record<string, string> {
  return Object.fromEntries(parameters.flatMap((parameter): [string, string][] => {
    const text = named(typed, nameOf(parameter));
    return text !== undefined && !isSame(parameter.value, text, parameter.type) ? [[nameOf(parameter), text]] : [];
  }));
}

/** In the same form as of anoctl: {device, name, sw, parameters: {NAME: value}}. */
export function fileOf(device: { address: string; name?: string; sw?: number }, parameters: readonly Parameter[]): string {
  const values = Object.fromEntries(parameters.filter((one) => one.value !== undefined).map((one) => [nameOf(one), one.value]));
  return JSON.stringify({ device: device.address, name: device.name, sw: device.sw, parameters: values }, null, 2) + "\n";
}

/** Values by name; undefined: not such a file. Integers keep all their digits. Texts with U+FFFD, which older versions wrote in place of GBK, are left out. */
export function valuesIn(text: string): Record<string, string> | undefined {
  let json: unknown;
  try {
    json = JSON.parse(text.replace(/(:\s*)(-?\d{16,})(?=\s*[,}\]])/g, '$1"$2"'));
  } catch {
    return undefined;
  }
  if (typeof json !== "object" || json === null) return undefined;
  const values = (json as { parameters?: unknown }).parameters ?? json;
  if (typeof values !== "object" || values === null || Array.isArray(values)) return undefined;
  return Object.fromEntries(Object.entries(values).filter(([, value]) => typeof value === "number" || (typeof value === "string" && !value.includes("\ufffd"))).map(([name, value]) => [name, String(value)]));
}

/** The device that a file is of, if it is known and differs from `device`: compared by name, or without one by address. */
export function strangerIn(text: string, device: { address: string; name?: string | undefined }): string | undefined {
  let said: { device?: unknown; name?: unknown };
  try {
    said = (JSON.parse(text) ?? {}) as typeof said;
  } catch {
    return undefined;
  }
  if (typeof said.name === "string" && said.name && device.name) return said.name === device.name ? undefined : said.name;
  return typeof said.device === "string" && said.device.toLowerCase() !== device.address.toLowerCase() ? said.device : undefined;
}
