// Rates from counters that are read periodically.

import { entryOf } from "../entries";

export interface Counters {
  [name: string]: unknown;
}

/** The counters of dropped frames. The other numbers of a link are traffic, a position, a port or a rate. */
const losses: ReadonlySet<string> = new Set([
  "bad_check", "bad_length", "expired", "denied_in", "inhibited", "looped", "duplicate", "no_route", "over_share", "suspended",
  "superseded", "queue_full", "stale", "limited", "denied_out", "link_down", "too_big", "send_failed", "held_back",
  "kernel_drops", "refused", "transfer_errors", "bad_reports", "failed_reports", // of some kinds of links; wrong_source is already counted in denied_in
  "v7_up_no_counterpart", "v7_up_no_address", "v7_up_malformed", "v7_up_unrepresentable", "v7_up_unmatched",
  "v7_up_echo", "v7_up_loop", "v7_up_command", "v7_up_own_sensor", "v7_up_erase", "v7_up_queue_full", "v7_down_other_device",
  "v7_down_no_counterpart", "v7_down_own_sensor", "v7_down_erase", "v7_down_not_allowed", "v7_down_malformed", "v7_down_too_big",
  "v7_down_unrepresentable", "v7_down_unmatched", "v7_down_queue_full", // of links with protocol V7
  "faults_lost", "faults_unheard", // simulated; faults_corrupted is counted as bad_check at the receiver
]);

/** Names and values of the counters of dropped frames, highest first. denied_out without the frames that V7 could not carry, which have causes of their own. */
export function drops(counters: Counters): [string, number][] {
  const all = Object.entries(counters).filter((entry): entry is [string, number] => losses.has(entry[0]) && typeof entry[1] === "number");
  const notInV7 = all.reduce((sum, [name, value]) => (name.startsWith("v7_down_") ? sum + value : sum), 0);
  return all
    .map(([name, value]): [string, number] => [name, name === "denied_out" ? value - notInV7 : value])
    .filter(([, value]) => value > 0)
    .sort((a, b) => b[1] - a[1]);
}

/** Without a host, or for a replay, frames without a destination are no loss: the page receives them in any case. */
const isAlone = (link: Counters): boolean => link.hint_id === "no_host_takes" || link.replayed !== undefined;

/** The same without drops that are no loss (isAlone), highest first. */
export const lost = (link: Counters): [string, number][] => drops(link).filter(([cause]) => cause !== "no_route" || !isAlone(link));

/** Lost frames by cause: their total, and the links. */
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

/** Rates by object name. A counter that has decreased was reset. */
export class CounterRates {
  private readonly looks = new Map<string, Look>();
  private readonly rates = new Map<string, Map<string, number>>();

  /** `now` in seconds. Readings within 0.5 s of the last one are ignored, except the second one, so that the first rates are available early. */
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
