// The alarm limits of a device, as the gateway keeps them, and the values that it finds beyond them. Pure.

export type Level = "none" | "amber" | "red";

export interface Limit {
  key: string; // tells it from the others of the device
  field: string; // "power.voltage"
  side: "below" | "above";
  amber: number | undefined;
  red: number | undefined;
  cells: number | undefined; // the value is divided by it
  for_s: number; // as long as a value must be beyond the limit
}

const numberIn = (value: unknown): number | undefined => (typeof value === "number" && Number.isFinite(value) ? value : undefined);

/** The body of GET /devices/A/limits. */
export function limitsIn(body: unknown): Limit[] {
  const list = (body as { limits?: unknown } | undefined)?.limits;
  if (!Array.isArray(list)) return [];
  return list.flatMap((one: Record<string, unknown> | null): Limit[] => {
    if (!one || typeof one.field !== "string" || (one.side !== "below" && one.side !== "above")) return [];
    const cells = numberIn(one.cells);
    return [{ key: `${one.field} ${one.side}`, field: one.field, side: one.side, amber: numberIn(one.amber), red: numberIn(one.red), cells, for_s: numberIn(one.for_s) ?? 0 }];
  });
}

/** The body of PUT. */
export const bodyOf = (limits: readonly Limit[]): { limits: Record<string, unknown>[] } => ({
  limits: limits.map(({ field, side, amber, red, cells, for_s }) => ({
    field, side,
    ...(amber === undefined ? {} : { amber }), ...(red === undefined ? {} : { red }), ...(cells === undefined ? {} : { cells }), ...(for_s > 0 ? { for_s } : {}),
  })),
});

export const messageOf = (limit: Pick<Limit, "field">): string => limit.field.split(".")[0] ?? "";
export const fieldOf = (limit: Pick<Limit, "field">): string => limit.field.slice(limit.field.indexOf(".") + 1);

/** A value beyond its limit for long enough, as the gateway judges it. */
export interface Alarm {
  device: number;
  limit: Pick<Limit, "key" | "field" | "side" | "cells">;
  level: Exclude<Level, "none">;
  value: number; // divided by the cells
  edge: number; // what it is beyond
  heardAt: number; // when the value last came, in seconds of the clock of `now`
}

/** A message of GET /alarms, which came at `now`. */
export function alarmsIn(body: unknown, now: number): Alarm[] {
  const list = (body as { alarms?: unknown } | undefined)?.alarms;
  if (!Array.isArray(list)) return [];
  return list.flatMap((one: Record<string, unknown> | null): Alarm[] => {
    if (!one || typeof one.field !== "string" || (one.side !== "below" && one.side !== "above") || (one.level !== "amber" && one.level !== "red")) return [];
    const device = Number(one.device), value = numberIn(one.value), edge = numberIn(one.limit);
    if (!Number.isInteger(device) || value === undefined || edge === undefined) return [];
    const limit = { key: `${one.field} ${one.side}`, field: one.field, side: one.side, cells: numberIn(one.cells) } as const;
    return [{ device, limit, level: one.level, value, edge, heardAt: now - (numberIn(one.age_s) ?? 0) }];
  });
}
