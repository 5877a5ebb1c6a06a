// Parses typed numbers; the types that devices declare. Pure.

/** Parses C notation: -1.5, 1e-7, 0xDC. undefined: not a number. */
export function numberIn(text: string): number | undefined {
  const plain = text.trim();
  if (plain === "") return undefined;
  const number = Number(plain);
  return Number.isNaN(number) ? undefined : number;
}

export function bigIn(value: string | number): bigint | undefined {
  try {
    return BigInt(value);
  } catch {
    return undefined;
  }
}

/** Types whose integers may exceed a double: their values are sent and stored as text. */
export const isWide = (type: string): boolean => type.endsWith("64") && type !== "f64";

/** The smallest and the largest value of an integer type; undefined: not an integer type. */
export function wholeRangeOf(type: string): [bigint, bigint] | undefined {
  const [, sign, bits] = /^([ui])(8|16|32|64)$/.exec(type) ?? [];
  if (!sign) return undefined;
  return sign === "u" ? [0n, (1n << BigInt(bits!)) - 1n] : [-(1n << (BigInt(bits!) - 1n)), (1n << (BigInt(bits!) - 1n)) - 1n];
}
