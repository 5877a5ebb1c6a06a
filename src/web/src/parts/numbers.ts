// Numbers as people type them, and the types that devices declare. Pure.

/** As in C: -1.5, 1e-7, 0xDC; undefined: not a number. */
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

/** Integers that a double can't hold: they are sent and kept as text. */
export const isWide = (type: string): boolean => type.endsWith("64") && type !== "f64";

/** The least and the greatest value of an integer type; undefined: it is none. */
export function wholeRangeOf(type: string): [bigint, bigint] | undefined {
  const [, sign, bits] = /^([ui])(8|16|32|64)$/.exec(type) ?? [];
  if (!sign) return undefined;
  return sign === "u" ? [0n, (1n << BigInt(bits!)) - 1n] : [-(1n << (BigInt(bits!) - 1n)), (1n << (BigInt(bits!) - 1n)) - 1n];
}
