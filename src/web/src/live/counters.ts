// Rates from counters that are looked at now and then.

export interface Counters {
  [name: string]: unknown;
}

/** Frames that did not arrive, or bytes that were none: the rest of a link's numbers. */
const notDrops = new Set(["since_s", "heard_s", "frames_in", "bytes_in", "frames_out", "bytes_out", "empty_out", "waiting", "id", "baud", "port", "skipped_bytes"]);

const numberOf = (value: unknown): number => (typeof value === "number" ? value : typeof value === "string" ? Number(value) : 0);

/** Names and numbers of what was dropped, the most first. */
export function drops(counters: Counters): [string, number][] {
  return Object.entries(counters)
    .filter(([name, value]) => !notDrops.has(name) && typeof value === "number" && value > 0)
    .map(([name, value]): [string, number] => [name, numberOf(value)])
    .sort((a, b) => b[1] - a[1]);
}

/** Frames that no host takes are here on the page all the same. */
export const isTaken = (link: Counters, cause: string): boolean => cause === "no_route" && link.hint_id === "no_host_takes";

interface Look {
  at: number;
  values: Map<string, number>;
}

/** Of each of several things by name. A counter that has become less has begun anew. */
export class CounterRates {
  private readonly looks = new Map<string, Look>();
  private readonly rates = new Map<string, Map<string, number>>();

  /** `now` in seconds; looks closer than half a second are not counted. */
  look(of: string, counters: Counters, now: number): void {
    const before = this.looks.get(of);
    if (before && now - before.at < 0.5) return;
    const values = new Map(Object.entries(counters).flatMap(([name, value]): [string, number][] => (typeof value === "number" ? [[name, value]] : [])));
    this.looks.set(of, { at: now, values });
    if (!before) return;
    const rates = new Map<string, number>();
    for (const [name, value] of values) {
      const grown = value - (before.values.get(name) ?? 0);
      rates.set(name, grown >= 0 ? grown / (now - before.at) : 0);
    }
    this.rates.set(of, rates);
  }

  perSecond(of: string, name: string): number | undefined {
    return this.rates.get(of)?.get(name);
  }
}
