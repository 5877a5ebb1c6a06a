// Rates from counters that are read at intervals.

import { entryOf } from "../entries";

export interface Counters {
  [name: string]: unknown;
}

/** The counters of frames that did not arrive. The other numbers of a link are traffic, a position, a port, a rate. */
const losses: ReadonlySet<string> = new Set([
  "bad_check", "bad_length", "expired", "denied_in", "inhibited", "looped", "duplicate", "no_route", "over_share", "suspended",
  "superseded", "queue_full", "stale", "limited", "denied_out", "link_down", "too_big", "send_failed", "held_back",
  "kernel_drops", "refused", "transfer_errors", // of some kinds of links; wrong_source is contained in denied_in
  "faults_lost", "faults_unheard", // simulated; faults_corrupted is counted as bad_check by the receiver
]);

/** Names and numbers of dropped frames, the highest number first. */
export function drops(counters: Counters): [string, number][] {
  return Object.entries(counters)
    .filter((entry): entry is [string, number] => losses.has(entry[0]) && typeof entry[1] === "number" && entry[1] > 0)
    .sort((a, b) => b[1] - a[1]);
}

/** Without a host, or with a replayed recording, frames without a receiver are no loss: the page shows them anyway. */
const isAlone = (link: Counters): boolean => link.hint_id === "no_host_takes" || link.replayed !== undefined;

/** Dropped frames that should have arrived, the highest number first. */
export const lost = (link: Counters): [string, number][] => drops(link).filter(([cause]) => cause !== "no_route" || !isAlone(link));

/** Of each cause: how many frames should have arrived, and of which links. */
export function lossesByCause<L extends Counters>(links: L[]): Map<string, { total: number; of: L[] }> {
  const all = new Map<string, { total: number; of: L[] }>();
  for (const link of links)
    for (const [cause, count] of lost(link)) {
      const losses = entryOf(all, cause, () => ({ total: 0, of: [] as L[] }));
      losses.total += count;
      losses.of.push(link);
    }
  return all;
}

interface Look {
  at: number;
  values: Map<string, number>;
}

/** Rates of several objects, by name. A counter that has decreased was restarted. */
export class CounterRates {
  private readonly looks = new Map<string, Look>();
  private readonly rates = new Map<string, Map<string, number>>();

  /** `now` in seconds; readings less than half a second apart are ignored, except the second: the first rates are wanted soon. */
  look(of: string, counters: Counters, now: number): void {
    const before = this.looks.get(of);
    if (before && now - before.at < (this.rates.has(of) ? 0.5 : 0.1)) return;
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
