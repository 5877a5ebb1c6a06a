// The streams of frames of the page: one of the present view, which says which frames it needs, and gets only those; one that watches all devices.
import { onHeard, socketAddress } from "../api";
import { Arrivals } from "./rate";
import { takeRecords, textMessage, type FrameRecord, type Lost, type Tables } from "../protocol/records";

export interface FrameWish {
  from?: number[];
  to?: number[];
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
  if (wish.to?.length) parts.push("to=" + wish.to.join(","));
  if (wish.id?.length) parts.push("id=" + wish.id.join(","));
  parts.push("direction=" + (wish.direction ?? "in"));
  parts.push("elsewhere=no"); // a frame in the name of a device that is at home elsewhere says nothing of that device
  if (wish.samples) parts.push(`samples=${wish.samples}`);
  for (const [id, rate] of Object.entries(wish.limit ?? {})) parts.push(`limit.${id}=${rate}`);
  return parts.join("&");
}

const retryAfter = 500;

class FrameStream {
  private user: FrameUser | undefined;
  private socket: WebSocket | undefined;
  private retry: ReturnType<typeof setTimeout> | undefined;
  lostFrames = 0;

  constructor() {
    document.addEventListener("visibilitychange", () => (document.hidden ? this.close() : this.open()));
  }

  /** Registers the visible view; the last one counts. Returns a function to be called when the view is removed. */
  use(user: FrameUser): () => void {
    this.close();
    this.user = user;
    this.lostFrames = 0;
    this.open();
    return () => {
      if (this.user !== user) return;
      this.user = undefined;
      this.close();
    };
  }

  /** Opens a new connection when the gateway was not heard for a while, since the old one may never report that it is broken. */
  reopen(): void {
    this.close();
    this.open();
  }

  private close(): void {
    clearTimeout(this.retry);
    const socket = this.socket;
    this.socket = undefined;
    socket?.close();
  }

  private open(): void {
    const { user } = this;
    if (!user || document.hidden || this.socket) return;
    const socket = new WebSocket(socketAddress("/frames?" + queryOf(user.wish)));
    socket.binaryType = "arraybuffer";
    this.socket = socket;
    const arrivals = new Arrivals();
    socket.onopen = () => user.began?.();
    socket.onmessage = (event: MessageEvent<ArrayBuffer | string>) => {
      if (this.socket !== socket) return;
      onHeard.call();
      if (typeof event.data !== "string") {
        const records: FrameRecord[] = [], now = performance.now() / 1000;
        takeRecords(event.data, (record) => records.push(record));
        arrivals.begin();
        const newest = records[records.length - 1];
        if (newest) arrivals.at(newest.boot, now);
        for (const record of records) user.take(record, arrivals.at(record.boot, now));
        return;
      }
      const message = textMessage(event.data);
      if (!message) return;
      if ("causes" in message) return user.tables?.(message);
      for (const count of Object.values(message.lost)) this.lostFrames += count;
      user.lost?.(message);
    };
    socket.onclose = () => {
      if (this.socket !== socket) return;
      this.socket = undefined;
      clearTimeout(this.retry);
      this.retry = setTimeout(() => this.open(), retryAfter);
    };
  }
}

/** Of the present view. */
export const frameStream = new FrameStream();
/** Of every device, whichever page is open. */
export const watchStream = new FrameStream();
