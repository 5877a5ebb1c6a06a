// The streams of frames of the page: one of the present view, which says which frames it needs, and gets only those; one that watches all devices.
import { Connection } from "./connection";
import { Arrivals } from "./rate";
import { takeRecords, textMessage, type FrameRecord, type Lost, type Tables } from "../protocol/records";

export interface FrameWish {
  from?: number[];
  id?: (number | string)[]; // ids, names of messages or of classes
  direction?: string;
  limit?: Record<string, number>; // frames a second of an id, by its number
  samples?: number; // a second of each link, sender and message, at most
  batch?: number; // milliseconds, in the place of the usual ones
}

export interface FrameUser {
  wish: FrameWish;
  /** `at`: when it passed the gateway, in seconds of the page's clock. */
  take(record: FrameRecord, at: number): void;
  tables?(tables: Tables): void;
  lost?(lost: Lost): void;
  /** The stream was begun anew: frames in between were not seen. */
  began?(): void;
}

/** Milliseconds in which the gateway collects frames for one message, at most: while frames arrive, a message leaves with one of them after
 * four fifths of that, 20 times a second. Too short to be seen, while each message costs the gateway a system call. */
const usualBatch = 60;

export function queryOf(wish: FrameWish): string {
  const parts = ["format=binary", `batch=${wish.batch ?? usualBatch}ms`];
  if (wish.from?.length) parts.push("from=" + wish.from.join(","));
  if (wish.id?.length) parts.push("id=" + wish.id.join(","));
  parts.push("direction=" + (wish.direction ?? "in"));
  parts.push("elsewhere=no"); // a frame in the name of a device that is at home elsewhere says nothing of that device
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

  /** Registers the visible view; the last one counts. Returns a function to be called when the view is removed. */
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

/** Of the present view. */
export const frameStream = new FrameStream();
/** Of every device, whichever page is open. */
export const watchStream = new FrameStream();
