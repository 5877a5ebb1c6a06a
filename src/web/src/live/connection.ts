// A WebSocket to the gateway, with reconnection. While the page is hidden, only connections with `whileHidden` stay open.
import { onHeard, socketAddress } from "../api";

export interface ConnectionUser {
  route: string;
  whileHidden?: boolean;
  opened?(): void;
  closed?(): void;
  take(message: string | ArrayBuffer): void;
}

export const retryAfter = 500; // milliseconds
export const retryHidden = 3000;

const all: Connection[] = [];

/** For use after the gateway was silent: the browser may never report that the old connections are broken. */
export const reopenAll = (): void => all.forEach((one) => one.reopen());

export class Connection {
  private user: ConnectionUser | undefined;
  private socket: WebSocket | undefined;
  private retry: ReturnType<typeof setTimeout> | undefined;

  constructor() {
    all.push(this);
    document.addEventListener("visibilitychange", () => (document.hidden && !this.user?.whileHidden ? this.disconnect() : this.connect()));
  }

  /** Has no effect on an open connection: call close() before changing the route. */
  open(user: ConnectionUser): void {
    this.user = user;
    this.connect();
  }
  close(): void {
    this.user = undefined;
    this.disconnect();
  }
  reopen(): void {
    this.disconnect();
    this.connect();
  }

  private disconnect(): void {
    const { socket } = this;
    this.socket = undefined;
    socket?.close();
  }
  private connect(): void {
    const { user } = this;
    if (!user || this.socket || (document.hidden && !user.whileHidden)) return;
    const socket = new WebSocket(socketAddress(user.route));
    socket.binaryType = "arraybuffer";
    this.socket = socket;
    socket.onopen = () => {
      if (this.socket === socket) user.opened?.();
    };
    socket.onmessage = (event: MessageEvent<string | ArrayBuffer>) => {
      if (this.socket !== socket) return;
      onHeard.call();
      user.take(event.data);
    };
    socket.onclose = () => {
      if (this.socket !== socket) return;
      this.socket = undefined;
      clearTimeout(this.retry);
      this.retry = setTimeout(() => this.connect(), document.hidden ? retryHidden : retryAfter);
      user.closed?.();
    };
  }
}
