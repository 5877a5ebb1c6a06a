// Decides whether the gateway is there, by the time when it was heard last. No I/O; times are milliseconds of one clock.

export const askEvery = 400; // while nothing else is heard
export const lostAfter = 940; // with the time for drawing, it is seen within a second
export const maxOutstanding = 3;

export type Contact = "never" | "live" | "lost";

export class Liveness {
  private heardAt = Number.NEGATIVE_INFINITY;
  private askedAt = Number.NEGATIVE_INFINITY;
  private readonly outstanding = new Map<number, number>();
  private asked = 0;
  private restartedAt = Number.NEGATIVE_INFINITY;

  heard(now: number): void {
    this.heardAt = now;
  }

  /** To be called after the page was hidden: it sent few requests, so silence in that time means nothing; `isLost`: but it knows that the
   * gateway did not answer. */
  restart(now: number, isLost = false): void {
    this.outstanding.clear();
    this.askedAt = Number.NEGATIVE_INFINITY;
    if (!isLost) this.restartedAt = now;
  }

  contact(now: number): Contact {
    if (this.heardAt === Number.NEGATIVE_INFINITY) return "never";
    return now >= this.lostAt() ? "lost" : "live";
  }

  /** When it is lost, if nothing is heard until then. */
  lostAt(): number {
    return Math.max(this.heardAt, this.restartedAt) + lostAfter;
  }

  silentFor(now: number): number {
    return now - this.heardAt;
  }

  /** The number of the request to be sent now; undefined: none. On a slow line, several may be outstanding. `atLeastEvery`: for what the
   * answer says, however often other messages are heard. */
  ask(now: number, atLeastEvery: number): number | undefined {
    const patience = 5000;
    for (const [question, at] of this.outstanding) if (now - at > patience) this.outstanding.delete(question);
    const silent = Math.min(now - this.askedAt, now - this.heardAt);
    if ((silent < askEvery && now - this.askedAt < atLeastEvery) || this.outstanding.size >= maxOutstanding) return undefined;
    this.askedAt = now;
    this.outstanding.set(++this.asked, now);
    return this.asked;
  }

  ended(question: number): void {
    this.outstanding.delete(question);
  }
}
