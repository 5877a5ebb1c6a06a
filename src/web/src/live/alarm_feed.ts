// What the gateway finds in alarm (GET /alarms), told whole at each change, so that all viewers see the same.
import { onHeard, socketAddress } from "../api";
import { alarmsIn, type Alarm } from "./limits";
import { Store } from "./store";

const retryAfter = 500; // milliseconds

class AlarmFeed {
  readonly alarms = new Store<readonly Alarm[]>([]);
  private isWanted = false;
  private socket: WebSocket | undefined;
  private retry: ReturnType<typeof setTimeout> | undefined;

  constructor() {
    document.addEventListener("visibilitychange", () => (document.hidden ? this.close() : this.open()));
  }
  /** Without limits there is nothing to hear of: then it takes no place among the streams of the gateway. */
  use(isWanted: boolean): void {
    this.isWanted = isWanted;
    if (isWanted) return this.open();
    this.close();
    if (this.alarms.get().length > 0) this.alarms.set([]);
  }
  /** The old connection may never report that it is broken. */
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
    if (!this.isWanted || document.hidden || this.socket) return;
    const socket = new WebSocket(socketAddress("/alarms"));
    this.socket = socket;
    socket.onmessage = (event: MessageEvent<unknown>) => {
      if (this.socket !== socket || typeof event.data !== "string") return;
      onHeard.call();
      this.take(event.data);
    };
    socket.onclose = () => {
      if (this.socket !== socket) return;
      this.socket = undefined;
      clearTimeout(this.retry);
      this.retry = setTimeout(() => this.open(), retryAfter);
    };
  }
  private take(text: string): void {
    try {
      this.alarms.set(alarmsIn(JSON.parse(text), performance.now() / 1000));
    } catch {
      // no JSON: the next message tells the whole again
    }
  }
}

export const alarmFeed = new AlarmFeed();
