// Devices in replayed recordings.
import { isHost } from "../protocol/table";
import type { Status } from "./gateway";


/** Devices that exist only in a replayed recording, by address, with the link that replays it. They can be watched, but don't respond. */
export function replayedDevices(status: Pick<Status, "links" | "routes"> | undefined): Map<number, string> {
  const alive = new Set(status?.routes.map((route) => Number(route.address)));
  const found = new Map<number, string>();
  for (const link of status?.links ?? [])
    for (const { address } of link.replayed ?? [])
      if (!alive.has(Number(address)) && !isHost(Number(address)) && !found.has(Number(address))) found.set(Number(address), link.name);
  return found;
}
