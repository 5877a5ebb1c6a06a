// Decides whether a device is lost, from the period of its telemetry. Pure; times are seconds of one clock.
import { entryOf } from "../entries";
import { isFlexible } from "../protocol/table";

/** Telemetry and flexible messages are sent periodically. Responses and pictures have no period. */
export const isTelemetry = (id: number): boolean => (id >= 0x01 && id < 0x60) || isFlexible(id);
/** Log lines are sent without a request as well, but some devices log only occasionally: see Presence.period(). */
const isLog = (id: number): boolean => id === 0xa0 || id === 0xa1;

const kept = 8; // intervals
const longest = 5; // seconds: rarer messages don't show whether a device is lost

/** The longest of the last intervals of one message, so that neither jitter nor a lower rate counts as a loss. */
class Beat {
  last = Number.NEGATIVE_INFINITY;
  private since = 0; // start of the time without an interval above `longest`
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

/** Added to the period. Together with the time for collecting frames and drawing, a loss is shown within 1 s plus two periods. */
export const patience = 0.75;

const sameLoss = 1; // seconds: tolerance between the times of the last frame in the gateway and in the page

export class Presence {
  heardAt = Number.NEGATIVE_INFINITY;
  private lostAt: number | undefined; // time of the last frame, as reported by the gateway
  /** Where frames with its address are received that may come from another device, as reported by the gateway. The device stays lost until isBack(). */
  elsewhere: string | undefined;
  private readonly beats = new Map<number, Beat>(); // of telemetry messages
  private readonly logs = new Map<number, Beat>();
  private readonly recent: number[] = [];

  hear(id: number, now: number): void {
    if (this.elsewhere === undefined) this.heardAt = Math.max(this.heardAt, now);
    this.recent.push(now);
    if (this.recent.length > 2000) this.recent.splice(0, 1000);
    if (isTelemetry(id) || isLog(id)) entryOf(isLog(id) ? this.logs : this.beats, id, () => new Beat()).add(now);
  }

  /** The gateway reports that the device is lost since `at`. Needed if the page received no frames, or not for long enough to detect the loss. */
  wasLost(at: number, elsewhere?: string): void {
    this.elsewhere = elsewhere;
    if (this.heardAt > at + sameLoss && elsewhere === undefined) return; // received again since then
    if (Math.abs(this.heardAt - at) > sameLoss) this.heardAt = at;
    this.lostAt = this.heardAt;
  }

  /** The gateway reports that the device is received, even if the page receives no frames. */
  isBack(): void {
    this.lostAt = this.elsewhere = undefined;
  }

  /** The period of its most frequent telemetry. Without current telemetry, that of its log, if the device had telemetry or logs continuously.
   * undefined: no periodic messages, or not for long enough. */
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

  /** `since`: when the page began to receive frames. */
  isLost(now: number, since: number): boolean {
    if (this.lostAt === this.heardAt) return true;
    const period = this.period();
    return period !== undefined && now - Math.max(this.heardAt, since) > patience + period;
  }

  /** Number of frames in the last second. */
  rate(now: number): number {
    let first = this.recent.length;
    while (first > 0 && this.recent[first - 1]! > now - 1) --first;
    return this.recent.length - first;
  }
}
