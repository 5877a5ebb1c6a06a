// Which devices the gateway receives and which are lost, as sent with the alarms. Pure.

export interface HeardDevice {
  device: number;
  isLost: boolean;
  heardAt: number; // for a lost device: time of its last frame, in seconds of the clock of `now`
  flag: number | undefined; // for a lost vehicle: sflag of its last `mode`
  elsewhere?: string; // where frames with the address of a lost device are received; it may be another device
}

/** Parses a message of GET /alarms received at `now`. */
export function heardDevicesIn(body: unknown, now: number): HeardDevice[] {
  const list = (body as { devices?: unknown } | undefined | null)?.devices;
  if (!Array.isArray(list)) return [];
  return list.flatMap((row: Record<string, unknown> | null): HeardDevice[] => {
    const { address, lost, age, sflag, elsewhere } = row ?? {}, device = Number(address ?? Number.NaN);
    if (!Number.isInteger(device) || typeof lost !== "boolean" || (lost && typeof age !== "number")) return [];
    return [{ device, isLost: lost, heardAt: now - (typeof age === "number" ? age : 0), flag: typeof sflag === "number" ? sflag : undefined, ...(typeof elsewhere === "string" ? { elsewhere } : {}) }];
  });
}
