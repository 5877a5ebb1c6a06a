// Checks the input for a command against the types that the device declares. Pure.
import { isWide, numberIn, wholeRangeOf } from "./numbers";

/** The range of an integer type; undefined: not an integer type. */
export function rangeOf(type: string): [number, number] | undefined {
  const range = wholeRangeOf(type);
  return range && [Number(range[0]), Number(range[1])];
}

export const rangeText = (type: string): string => {
  const range = rangeOf(type);
  return range && !isWide(type) ? ` ${range[0]}…${range[1]}` : "";
};

/** The values in the types that the device declares; undefined: a value is not a number, or out of range. Integers beyond 2^53 stay text. */
export function valuesOf(types: readonly string[], typed: readonly string[]): unknown[] | undefined {
  const values = types.map((type, i) => {
    const text = typed[i] ?? "";
    const number = text.trim() === "" ? 0 : numberIn(text);
    if (number === undefined) return undefined;
    const range = rangeOf(type);
    if (range && (!Number.isInteger(number) || number < range[0] || number > range[1])) return undefined;
    return isWide(type) && !Number.isSafeInteger(number) ? text.trim() : number;
  });
  return values.some((value) => value === undefined) ? undefined : values;
}
