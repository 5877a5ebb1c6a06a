// Parses GET /frames?format=binary: one WebSocket message contains several records.
import { jsonIn } from "../json";

export const directions = ["in", "out", "dropped"] as const;
export type Direction = (typeof directions)[number];

export interface FrameRecord {
  time: number; // Unix seconds
  boot: number; // seconds since boot of the gateway's computer, including sleep
  link: number;
  channel: number; // 255: no channel
  direction: Direction;
  cause: number; // 0: not dropped
  from: number;
  to: number;
  id: number;
  data: Uint8Array; // refers to the memory of the message; copy it to keep it
}

const elsewhere = 0x80; // flag in the byte of the direction: received on a link other than the route of its source; the page does not request these
const headSize = 20;
const frameHead = 6; // HEAD S_ADDR D_ADDR ID LEN
const frameChecks = 2;

/** Calls `take` for each record. False: the message ends within a record, or contains no records. */
export function takeRecords(message: ArrayBuffer, take: (record: FrameRecord) => void): boolean {
  const view = new DataView(message);
  let at = 0;
  while (at < message.byteLength) {
    const frame = at + headSize;
    if (frame + frameHead + frameChecks > message.byteLength || view.getUint8(frame) !== 0xab) return false;
    const size = view.getUint16(frame + 4, true);
    const direction = directions[view.getUint8(at + 17) & ~elsewhere];
    const end = frame + frameHead + size + frameChecks;
    if (end > message.byteLength || direction === undefined) return false;
    take({
      time: Number(view.getBigUint64(at, true)) / 1e9,
      boot: Number(view.getBigUint64(at + 8, true)) / 1e9,
      link: view.getUint8(at + 16),
      direction,
      cause: view.getUint8(at + 18),
      channel: view.getUint8(at + 19),
      from: view.getUint8(frame + 1),
      to: view.getUint8(frame + 2),
      id: view.getUint8(frame + 3),
      data: new Uint8Array(message, frame + frameHead, size),
    });
    at = end;
  }
  return true;
}

/** Text messages between the binary ones. */
export interface Tables {
  links: (string | null)[];
  channels: (string | null)[];
  causes: (string | null)[];
}
export interface Lost {
  lost: Record<string, number>;
}

export function textMessage(text: string): Tables | Lost | undefined {
  const json = jsonIn(text);
  if (typeof json !== "object" || json === null) return undefined;
  if ("links" in json && "causes" in json) return json as Tables;
  return "lost" in json ? (json as Lost) : undefined;
}
