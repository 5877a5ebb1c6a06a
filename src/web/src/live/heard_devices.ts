// Which devices the gateway hears, as it tells with the alarms. Pure.

export interface HeardDevice {
  device: number;
  isLost: boolean;
  heardAt: number; // of a lost one, in seconds of the clock of `now`
  flag: number | undefined; // of a lost vehicle, of its last `mode`
  elsewhere?: string; // where a lost one is heard, though it is not known to be the same
}

/** A message of GET /alarms, which came at `now`. */
export function heardDevicesIn(body: unknown, now: number): HeardDevice[] {
  const list = (body as { devices?: unknown } | undefined | null)?.devices;
  if (!Array.isArray(list)) return [];
  return list.flatMap((row: Record<string, unknown> | null): HeardDevice[] => {
    const { address, lost, age, sflag, elsewhere } = row ?? {}, device = Number(address ?? Number.NaN);
    if (!Number.isInteger(device) || typeof lost !== "boolean" || (lost && typeof age !== "number")) return [];
    return [{ device, isLost: lost, heardAt: now - (typeof age === "number" ? age : 0), flag: typeof sflag === "number" ? sflag : undefined, ...(typeof elsewhere === "string" ? { elsewhere } : {}) }];
  });
}
