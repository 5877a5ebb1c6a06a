// Devices in recordings that are being replayed.
import type { Status } from "./gateway";

const hosts: readonly number[] = [0xfe, 0xd2];

/** Devices that exist only in a recording, by address, with the link that plays it: they can be watched, but do not answer. */
export function replayedDevices(status: Pick<Status, "links" | "routes"> | undefined): Map<number, string> {
  const alive = new Set(status?.routes.map((route) => Number(route.address)));
  const found = new Map<number, string>();
  for (const link of status?.links ?? [])
    for (const { address } of link.replayed ?? [])
      if (!alive.has(Number(address)) && !hosts.includes(Number(address)) && !found.has(Number(address))) found.set(Number(address), link.name);
  return found;
}
