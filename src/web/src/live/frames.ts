// The one stream of frames that the page has: each view says what it needs, and gets no more.
import { onHeard, socketAddress } from "../api";
import { takeRecords, textMessage, type FrameRecord, type Lost, type Tables } from "../protocol/records";

export interface FrameWish {
  from?: number[];
  to?: number[];
  id?: (number | string)[]; // ids, names of messages or of classes
  direction?: string;
  limit?: Record<string, number>; // frames a second of an id, by its number
}

export interface FrameUser {
  wish: FrameWish;
  take(record: FrameRecord): void;
  tables?(tables: Tables): void;
  lost?(lost: Lost): void;
  /** Frames that passed meanwhile were not seen. */
  began?(): void;
}

export function queryOf(wish: FrameWish): string {
  const parts = ["format=binary"];
  if (wish.from?.length) parts.push("from=" + wish.from.join(","));
  if (wish.to?.length) parts.push("to=" + wish.to.join(","));
  if (wish.id?.length) parts.push("id=" + wish.id.join(","));
  parts.push("direction=" + (wish.direction ?? "in"));
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

  /** The view that is seen; the last one that came counts. Call what it answers when the view goes. */
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

  /** The gateway was not heard for a while: a new connection, for the old one may never say that it is dead. */
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
    socket.onopen = () => user.began?.();
    socket.onmessage = (event: MessageEvent<ArrayBuffer | string>) => {
      if (this.socket !== socket) return;
      onHeard.call();
      if (typeof event.data !== "string") {
        takeRecords(event.data, (record) => user.take(record));
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

export const frameStream = new FrameStream();
