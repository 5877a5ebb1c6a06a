// The alarm limits of a device, in the gateway's form, and the alarms. Pure.

export interface Limit {
  key: string; // unique for the device
  field: string; // "power.voltage"
  side: "below" | "above";
  amber: number | undefined;
  red: number | undefined;
  cells: number | undefined; // the value is divided by this number
  for_s: number; // seconds for which a value must exceed the limit
}

const numberIn = (value: unknown): number | undefined => (typeof value === "number" && Number.isFinite(value) ? value : undefined);

export const keyOf = ({ field, side }: Pick<Limit, "field" | "side">): string => `${field} ${side}`;

type What = Pick<Limit, "key" | "field" | "side" | "cells">;

/** The results of `make` for the valid rows of a list in the gateway's form; `of` is the value that a row is about. */
function rowsOf<T>(list: unknown, make: (of: What, row: Record<string, unknown>) => T | undefined): T[] {
  if (!Array.isArray(list)) return [];
  return list.flatMap((row: Record<string, unknown> | null): T[] => {
    const { field, side, cells } = row ?? {};
    if (!row || typeof field !== "string" || (side !== "below" && side !== "above")) return [];
    const made = make({ key: keyOf({ field, side }), field, side, cells: numberIn(cells) }, row);
    return made === undefined ? [] : [made];
  });
}

/** The body of GET /devices/A/limits. */
export const limitsIn = (body: unknown): Limit[] =>
  rowsOf((body as { limits?: unknown } | undefined)?.limits, (of, row) => ({ ...of, amber: numberIn(row.amber), red: numberIn(row.red), for_s: numberIn(row.for_s) ?? 0 }));

/** The body of PUT /devices/A/limits. */
export const bodyOf = (limits: readonly Limit[]): { limits: Record<string, unknown>[] } => ({
  limits: limits.map(({ field, side, amber, red, cells, for_s }) => ({
    field, side,
    ...(amber === undefined ? {} : { amber }), ...(red === undefined ? {} : { red }), ...(cells === undefined ? {} : { cells }), ...(for_s > 0 ? { for_s } : {}),
  })),
});

export const messageOf = (limit: Pick<Limit, "field">): string => limit.field.split(".")[0] ?? "";
export const fieldOf = (limit: Pick<Limit, "field">): string => limit.field.slice(limit.field.indexOf(".") + 1);

/** A value that has exceeded its limit for long enough, as evaluated by the gateway. */
export interface Alarm {
  device: number;
  limit: What;
  level: "amber" | "red";
  value: number; // divided by the number of cells
  edge: number; // the limit that it exceeds
  heardAt: number; // when the value was last received, in seconds of the clock of `now`
}

/** Parses a message of GET /alarms received at `now`. */
export const alarmsIn = (body: unknown, now: number): Alarm[] =>
  rowsOf((body as { alarms?: unknown } | undefined)?.alarms, (limit, { level, ...row }) => {
    const device = Number(row.device), value = numberIn(row.value), edge = numberIn(row.limit);
    if ((level !== "amber" && level !== "red") || !Number.isInteger(device) || value === undefined || edge === undefined) return undefined;
    return { device, limit, level, value, edge, heardAt: now - (numberIn(row.age_s) ?? 0) };
  });
