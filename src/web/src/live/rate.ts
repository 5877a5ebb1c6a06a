// The rate of events, and whether the next one is overdue.

/** All times are seconds of one clock. */
export class Rate {
  private readonly times: number[] = [];
  private last = Number.NEGATIVE_INFINITY;
  private interval = 0; // smoothed

  constructor(private readonly window = 2) {}

  add(now: number): void {
    if (this.last > Number.NEGATIVE_INFINITY) {
      const step = now - this.last;
      this.interval = this.interval === 0 ? step : this.interval + (step - this.interval) * 0.1;
    }
    this.last = now;
    this.times.push(now);
    this.forget(now);
  }

  /** Events per second in the window; for rare events, from the smoothed interval. */
  perSecond(now: number): number {
    this.forget(now);
    if (this.times.length >= 4) {
      const span = now - this.times[0]!;
      return span > 0 ? (this.times.length - 1) / Math.max(this.times[this.times.length - 1]! - this.times[0]!, span - this.interval * 2) : 0;
    }
    if (this.interval > 0 && !this.isLate(now)) return 1 / this.interval;
    return this.times.length / this.window;
  }

  age(now: number): number {
    return now - this.last;
  }

  /** Whether the next event is overdue at the present rate; after a single event, only after five seconds. */
  isLate(now: number): boolean {
    const promised = this.interval > 0 ? Math.min(Math.max(3 * this.interval, 0.5), 30) : 5;
    return now - this.last > promised;
  }

  private forget(now: number): void {
    let gone = 0;
    while (gone < this.times.length && (this.times[gone]! < now - this.window || this.times.length - gone > 4096)) ++gone;
    if (gone > 0) this.times.splice(0, gone);
  }
}

/** Converts times of the gateway's clock to the page's clock, because the frames of one message passed at different times. The message with the
 * shortest delay determines the difference of the clocks. */
export class Arrivals {
  private ahead = Number.NEGATIVE_INFINITY;

  /** To be called for each message: corrects for a gateway clock that is a little slower than the page's. */
  begin(): void {
    this.ahead -= 0.0005;
  }

  /** `seen`: seconds of the gateway's clock, never decreasing. */
  at(seen: number, now: number): number {
    this.ahead = Math.max(this.ahead, seen - now);
    return seen - this.ahead;
  }
}
