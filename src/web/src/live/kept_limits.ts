// The alarm limits stored in the gateway for all viewers; read again when the gateway reports a new version.
import { ask, type Answer, type Options } from "../api";
import { path } from "./device";
import { bodyOf, limitsIn, type Limit } from "./limits";
import { devices } from "./gateway";
import { Store } from "./store";

interface Kept {
  version: number;
  limits: Limit[];
}

export const keptLimits = new Store<ReadonlyMap<number, Kept>>(new Map());

const asking = new Set<number>();

interface Told {
  version?: number;
  kept?: boolean; // false: lost when the gateway restarts
}

async function answered(device: number, options: Options): Promise<Answer<Told>> {
  const answer = await ask<Told>(path(device, "limits"), options);
  if (answer.ok) keptLimits.update((all) => new Map([...all, [device, { version: answer.value.version ?? 0, limits: limitsIn(answer.value) }]]));
  return answer;
}

export const readLimits = (device: number): Promise<Answer<Told>> => answered(device, { timeout: 5000 });
export const writeLimits = (device: number, limits: readonly Limit[]): Promise<Answer<Told>> => answered(device, { method: "PUT", body: bodyOf(limits), timeout: 10000 });

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
