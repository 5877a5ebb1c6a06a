// The streams of frames: one with only the frames that the current view needs, one that watches all devices.
import { Connection } from "./connection";
import { Arrivals } from "./rate";
import { takeRecords, textMessage, type FrameRecord, type Lost, type Tables } from "../protocol/records";

export interface FrameWish {
  from?: number[];
  id?: (number | string)[]; // ids, or names of messages or classes
  direction?: string;
  limit?: Record<string, number>; // frames per second of an id, by its number
  samples?: number; // maximum per second for each link, sender and message
  batch?: number; // milliseconds, instead of the default
}

export interface FrameUser {
  wish: FrameWish;
  /** `at`: when the frame passed the gateway, in seconds of the page's clock. */
  take(record: FrameRecord, at: number): void;
  tables?(tables: Tables): void;
  lost?(lost: Lost): void;
  /** The stream was reopened: frames in between were missed. */
  began?(): void;
}

/** Maximum time in milliseconds for which the gateway collects frames for one message. While frames arrive, it sends a message with one of them after
 * four fifths of this, 20 times per second. This delay is not visible, and each message costs the gateway a system call. */
const usualBatch = 60;

export function queryOf(wish: FrameWish): string {
  const parts = ["format=binary", `batch=${wish.batch ?? usualBatch}ms`];
  if (wish.from?.length) parts.push("from=" + wish.from.join(","));
  if (wish.id?.length) parts.push("id=" + wish.id.join(","));
  parts.push("direction=" + (wish.direction ?? "in"));
  parts.push("elsewhere=no"); // frames from an address whose route is another link may come from another device
  if (wish.samples) parts.push(`samples=${wish.samples}`);
  for (const [id, rate] of Object.entries(wish.limit ?? {})) parts.push(`limit.${id}=${rate}`);
  return parts.join("&");
}

function takeFrames(user: FrameUser, message: ArrayBuffer, arrivals: Arrivals): void {
  const records: FrameRecord[] = [], now = performance.now() / 1000;
  takeRecords(message, (record) => records.push(record));
  arrivals.begin();
  const newest = records[records.length - 1];
  if (newest) arrivals.at(newest.boot, now);
  for (const record of records) user.take(record, arrivals.at(record.boot, now));
}

class FrameStream {
  private readonly connection = new Connection();
  private user: FrameUser | undefined;
  lostFrames = 0;

  /** Registers the visible view; the last one registered receives the frames. Returns a function to be called when the view is removed. */
  use(user: FrameUser): () => void {
    this.connection.close();
    this.user = user;
    this.lostFrames = 0;
    let arrivals = new Arrivals();
    const opened = (): void => {
      arrivals = new Arrivals();
      user.began?.();
    };
    const take = (message: string | ArrayBuffer): void => (typeof message === "string" ? this.told(user, message) : takeFrames(user, message, arrivals));
    this.connection.open({ route: "/frames?" + queryOf(user.wish), opened, take });
    return () => {
      if (this.user === user) this.connection.close();
    };
  }

  private told(user: FrameUser, text: string): void {
    const message = textMessage(text);
    if (!message) return;
    if ("causes" in message) return user.tables?.(message);
    for (const count of Object.values(message.lost)) this.lostFrames += count;
    user.lost?.(message);
  }
}

/** For the current view. */
export const frameStream = new FrameStream();
/** For all devices, on every page. */
export const watchStream = new FrameStream();
