// Whether a device is still heard: by the period of its telemetry. Pure; times are seconds of one clock.
import { entryOf } from "../entries";
import { isFlexible } from "../protocol/table";

/** Telemetry and flexible messages come by themselves. What a device answers or shows as a picture has no period. */
export const isTelemetry = (id: number): boolean => (id >= 0x01 && id < 0x60) || isFlexible(id);
/** Lines come by themselves too, but some devices log only at times: see Presence.period(). */
const isLog = (id: number): boolean => id === 0xa0 || id === 0xa1;

const kept = 8; // intervals
const longest = 5; // seconds: a message that is rarer is no sign of life

/** The longest of the last intervals of one message, so that neither jitter nor a lower rate counts as a loss. */
class Beat {
  last = Number.NEGATIVE_INFINITY;
  private since = 0; // without a longer silence
  private readonly intervals: number[] = [];

  add(now: number): void {
    const step = now - this.last;
    this.last = now;
    if (step > longest) return void (this.since = now);
    this.intervals.push(step);
    if (this.intervals.length > kept) this.intervals.shift();
  }
  period(): number | undefined {
    return this.intervals.length >= 2 ? Math.max(...this.intervals) : undefined;
  }
  isSteady(): boolean {
    return this.last - this.since >= longest;
  }
}

/** With the time that frames are collected and the page needs to draw, the page shows a loss within 1 s and two periods. */
export const patience = 0.75;

const sameLoss = 1; // seconds between what the gateway and the page know of when it was heard last

export class Presence {
  heardAt = Number.NEGATIVE_INFINITY;
  private lostAt: number | undefined; // as others know
  /** Where frames in its name come from that are no sign of life, as others know; it stays lost until isBack(). */
  elsewhere: string | undefined;
  private readonly beats = new Map<number, Beat>(); // of telemetry
  private readonly logs = new Map<number, Beat>();
  private readonly recent: number[] = [];

  hear(id: number, now: number): void {
    if (this.elsewhere === undefined) this.heardAt = Math.max(this.heardAt, now);
    this.recent.push(now);
    if (this.recent.length > 2000) this.recent.splice(0, 1000);
    if (isTelemetry(id) || isLog(id)) entryOf(isLog(id) ? this.logs : this.beats, id, () => new Beat()).add(now);
  }

  /** Others know that it was heard last at that time, and is lost since: here nobody listened, or not for long enough to know. */
  wasLost(at: number, elsewhere?: string): void {
    this.elsewhere = elsewhere;
    if (this.heardAt > at + sameLoss && elsewhere === undefined) return; // it is heard again
    if (Math.abs(this.heardAt - at) > sameLoss) this.heardAt = at;
    this.lostAt = this.heardAt;
  }

  /** Others know that it is heard, though here nobody listens. */
  isBack(): void {
    this.lostAt = this.elsewhere = undefined;
  }

  /** Of its most frequent telemetry. While it has none, of its log: if it had some, or logs all the time. undefined: it sends nothing by itself,
   * or not long enough to know. */
  period(): number | undefined {
    const hadSome = [...this.beats.values()].some((beat) => beat.period() !== undefined);
    return this.shortest(this.beats.values()) ?? this.shortest([...this.logs.values()].filter((beat) => hadSome || beat.isSteady()));
  }
  private shortest(beats: Iterable<Beat>): number | undefined {
    let shortest: number | undefined;
    for (const beat of beats) {
      const period = beat.period();
      if (period === undefined || beat.last < this.heardAt - 3 * period - 0.2) continue; // the device stopped sending this message
      if (shortest === undefined || period < shortest) shortest = period;
    }
    return shortest;
  }

  /** `since`: from when on the page listens. */
  isLost(now: number, since: number): boolean {
    if (this.lostAt === this.heardAt) return true;
    const period = this.period();
    return period !== undefined && now - Math.max(this.heardAt, since) > patience + period;
  }

  /** Frames in the last second. */
  rate(now: number): number {
    let first = this.recent.length;
    while (first > 0 && this.recent[first - 1]! > now - 1) --first;
    return this.recent.length - first;
  }
}
