// What was typed for a command, checked against the types that the device declares. Pure.
import { numberIn } from "./frame_of";

/** What a whole number of the type can be; undefined: it is no whole number. */
export function rangeOf(type: string): [number, number] | undefined {
  const [, sign, bits] = /^([ui])(8|16|32|64)$/.exec(type) ?? [];
  if (!sign) return undefined;
  return sign === "u" ? [0, 2 ** Number(bits) - 1] : [-(2 ** (Number(bits) - 1)), 2 ** (Number(bits) - 1) - 1];
}

export const rangeText = (type: string): string => {
  const range = rangeOf(type);
  return range && !type.endsWith("64") ? ` ${range[0]}…${range[1]}` : "";
};

/** What was typed, for each type that the device declares; undefined: that is no number, or none of the type. A whole number beyond 2^53 stays text. */
export function valuesOf(types: readonly string[], typed: readonly string[]): unknown[] | undefined {
  const values = types.map((type, i) => {
    const text = typed[i] ?? "";
    const number = text.trim() === "" ? 0 : numberIn(text);
    if (number === undefined) return undefined;
    const range = rangeOf(type);
    if (range && (!Number.isInteger(number) || number < range[0] || number > range[1])) return undefined;
    return type.endsWith("64") && type !== "f64" && !Number.isSafeInteger(number) ? text.trim() : number;
  });
  return values.some((value) => value === undefined) ? undefined : values;
}
