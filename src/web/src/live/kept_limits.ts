// The alarm limits that the gateway keeps for all who look at it; read again when the gateway says that they changed.
import { ask, type Answer } from "../api";
import { bodyOf, limitsIn, type Limit } from "./limits";
import { devices } from "./gateway";
import { Store } from "./store";

interface Kept {
  version: number;
  limits: Limit[];
}

export const keptLimits = new Store<ReadonlyMap<number, Kept>>(new Map());

const set = (device: number, version: number, limits: Limit[]): void => keptLimits.update((all) => new Map([...all, [device, { version, limits }]]));
const path = (device: number): string => `/devices/${device}/limits`;
const asking = new Set<number>();

export async function readLimits(device: number): Promise<Answer<{ version?: number }>> {
  const answer = await ask<{ version?: number }>(path(device), { timeout: 5000 });
  if (answer.ok) set(device, answer.value.version ?? 0, limitsIn(answer.value));
  return answer;
}

export async function writeLimits(device: number, limits: readonly Limit[]): Promise<Answer<{ version?: number; kept?: boolean }>> {
  const answer = await ask<{ version?: number; kept?: boolean }>(path(device), { method: "PUT", body: bodyOf(limits), timeout: 10000 });
  if (answer.ok) set(device, answer.value.version ?? 0, limitsIn(answer.value));
  return answer;
}

export function beginLimits(): void {
  devices.subscribe(() => {
    for (const device of devices.get()) {
      const address = Number(device.address), version = device.limits ?? 0;
      if (version === (keptLimits.get().get(address)?.version ?? 0) || asking.has(address)) continue;
      asking.add(address);
      void readLimits(address).finally(() => asking.delete(address));
    }
  });
}
