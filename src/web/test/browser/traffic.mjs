// Frames of vehicles at a rate, by UDP, and their receiver.
import dgram from "node:dgram";
import { frame } from "./hostile_device.mjs";

const senders = [220, 221, 222, 223];
const lengths = { 1: 13, 3: 7, 4: 9, 5: 13, 6: 5, 7: 6, 8: 12 }; // of DATA, by id: inertial, attitude, height, mode, velocity, position
const mostInDatagram = 40;

export class Traffic {
  constructor() {
    this.mouth = dgram.createSocket("udp4");
    this.ear = dgram.createSocket("udp4");
    this.frames = senders.flatMap((from) => Object.entries(lengths).flatMap(([id, length]) => (id <= 4 ? [1, 2, 3] : [1]).map((n) => frame(from, 255, Number(id), Array.from({ length }, (_, i) => (i % 2 ? 0 : n + i))))));
  }

  /** Sends to the port `vehicle`; frames from `ground` are discarded. `alone`: each frame in its own datagram, as evenly as timers permit. */
  begin(vehicle, ground, rate, alone = false) {
    const inDatagram = alone ? 1 : mostInDatagram;
    clearInterval(this.timer);
    const began = performance.now();
    let sent = 0, hearing = Number.NEGATIVE_INFINITY;
    this.timer = setInterval(() => {
      if (performance.now() - hearing > 500) {
        hearing = performance.now();
        this.ear.send(frame(254, 220, 0, [0, 0, 0]), ground, "127.0.0.1"); // registers the ground station
      }
      for (const due = ((performance.now() - began) * rate) / 1000; sent < due;) {
        const count = Math.min(inDatagram, Math.ceil(due - sent));
        this.mouth.send(Buffer.concat(Array.from({ length: count }, (_, i) => this.frames[(sent + i) % this.frames.length])), vehicle, "127.0.0.1");
        sent += count;
      }
    }, alone ? 1 : 4);
  }

  end() {
    clearInterval(this.timer);
    this.mouth.close();
    this.ear.close();
  }
}
