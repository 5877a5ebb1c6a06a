// Decides whether the gateway is available, from the time of its last message. No I/O; times are milliseconds of one clock.

export const askEvery = 400; // if nothing else is received
export const lostAfter = 940; // including the time for drawing, a loss is visible within a second
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

  /** To be called after the page was hidden: it sent few requests then, so silence has no meaning, unless `isLost`: the gateway did not respond to
   * them. */
  restart(now: number, isLost = false): void {
    this.outstanding.clear();
    this.askedAt = Number.NEGATIVE_INFINITY;
    if (!isLost) this.restartedAt = now;
  }

  contact(now: number): Contact {
    if (this.heardAt === Number.NEGATIVE_INFINITY) return "never";
    return now >= this.lostAt() ? "lost" : "live";
  }

  /** The time at which the gateway counts as lost if nothing is received before. */
  lostAt(): number {
    return Math.max(this.heardAt, this.restartedAt) + lostAfter;
  }

  silentFor(now: number): number {
    return now - this.heardAt;
  }

  /** The number of the request to send now; undefined: none. On a slow connection, several may be outstanding. `atLeastEvery`: maximum interval of
   * requests, even if other messages are received. */
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
