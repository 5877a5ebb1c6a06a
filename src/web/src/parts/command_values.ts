// Checks the input for a command against the types that the device declares. Pure.
import { numberIn } from "./frame_of";

/** The range of an integer type; undefined: not an integer type. */
export function rangeOf(type: string): [number, number] | undefined {
  const [, sign, bits] = /^([ui])(8|16|32|64)$/.exec(type) ?? [];
  if (!sign) return undefined;
  return sign === "u" ? [0, 2 ** Number(bits) - 1] : [-(2 ** (Number(bits) - 1)), 2 ** (Number(bits) - 1) - 1];
}

export const rangeText = (type: string): string => {
  const range = rangeOf(type);
  return range && !type.endsWith("64") ? ` ${range[0]}…${range[1]}` : "";
};

/** The values for the types that the device declares; undefined: one is not a number, or out of range. Integers beyond 2^53 stay text. */
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
