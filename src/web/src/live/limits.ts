// The alarm limits of a device, as the gateway keeps them, and the values that it finds beyond them. Pure.

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

export const keyOf = ({ field, side }: Pick<Limit, "field" | "side">): string => `${field} ${side}`;

type What = Pick<Limit, "key" | "field" | "side" | "cells">;

/** What `make` makes of the good rows of a list in the gateway's form, and of what each is about. */
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
  limit: What;
  level: "amber" | "red";
  value: number; // divided by the cells
  edge: number; // what it is beyond
  heardAt: number; // when the value last came, in seconds of the clock of `now`
}

/** A message of GET /alarms, which came at `now`. */
export const alarmsIn = (body: unknown, now: number): Alarm[] =>
  rowsOf((body as { alarms?: unknown } | undefined)?.alarms, (limit, { level, ...row }) => {
    const device = Number(row.device), value = numberIn(row.value), edge = numberIn(row.limit);
    if ((level !== "amber" && level !== "red") || !Number.isInteger(device) || value === undefined || edge === undefined) return undefined;
    return { device, limit, level, value, edge, heardAt: now - (numberIn(row.age_s) ?? 0) };
  });
