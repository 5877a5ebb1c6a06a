// A device of our own, by UDP, with messages chosen by the test.
import dgram from "node:dgram";

export function frame(from, to, id, data) {
  const bytes = Buffer.from([0xab, from, to, id, data.length & 255, data.length >> 8, ...data, 0, 0]);
  let sum = 0, add = 0;
  for (let i = 0; i < bytes.length - 2; ++i) add = (add + (sum = (sum + bytes[i]) & 255)) & 255;
  bytes[bytes.length - 2] = sum;
  bytes[bytes.length - 1] = add;
  return bytes;
}

const f32 = (value) => { const bytes = Buffer.alloc(4); bytes.writeFloatLE(value); return bytes; };
const f64 = (value) => { const bytes = Buffer.alloc(8); bytes.writeDoubleLE(value); return bytes; };

/** Names that every object has or that are duplicated, and numbers that are not finite or extreme: [type, name, value]. */
const odd = [
  [8, "constructor", f32(1)], [8, "__proto__", f32(2)], [8, "toString", f32(3)], [8, "NAN", f32(NaN)], [8, "FAR", f32(1e38)], [8, "ENDLESS", f32(-Infinity)],
  [9, "FARTHEST", f64(1e308)], [6, "ALL_BITS", Buffer.alloc(8, 255)], [7, "LEAST", Buffer.from([0, 0, 0, 0, 0, 0, 0, 128])], [10, "WORDS", Buffer.from("°C µ \u202e\u{1F681}")],
  [8, "TWICE", f32(10)], [8, "TWICE", f32(11)],
];

/** A UDP device with `count` parameters, some of them odd, which stores written values. */
export class LargeDevice {
  constructor(port, count) {
    this.values = Array.from({ length: count }, (_, id) => odd[id] ?? [8, "P_" + id, f32(id)]);
    this.socket = dgram.createSocket("udp4");
    const send = (id, data, to = 255) => this.socket.send(frame(32, to, id, data), port, "127.0.0.1");
    this.socket.on("message", (bytes) => {
      for (let at = 0; at + 8 <= bytes.length; at += 8 + bytes.readUInt16LE(at + 4)) this.take(bytes.subarray(at, at + 8 + bytes.readUInt16LE(at + 4)), send);
    });
    this.timer = setInterval(() => send(0x03, [1, 0, 2, 0, 3, 0, 0]), 100);
  }

  take(bytes, send) {
    const [, from, to, id, , , cmd] = bytes, data = bytes.subarray(6, -2);
    if (to !== 32 && to !== 255) return;
    const number = (n) => [n & 255, n >> 8];
    if (id === 0xe1) {
      const [type, name] = this.values[data.readUInt16LE(0)];
      this.values[data.readUInt16LE(0)] = [type, name, Buffer.from(data.subarray(2))];
      send(0, [id, ...bytes.subarray(-2)], from);
    }
    if (id !== 0xe0) return;
    const asked = data.readUInt16LE(1), one = this.values[asked];
    if (cmd === 0) send(0xe3, [32, 100, 0, 100, 0, 0, 0, 0x20, 3, ...Buffer.from("Large")], from);
    if (cmd === 1) send(0xe0, [1, ...number(this.values.length)], from);
    if (cmd === 2 && one) send(0xe1, [...number(asked), ...one[2]], from);
    if (cmd === 3 && one) send(0xe2, [...number(asked), one[0], ...Buffer.from(one[1].padEnd(20, "\0")), ...Buffer.from("m²·s⁻¹ <b>&amp;")], from);
  }

  stop() {
    clearInterval(this.timer);
    this.socket.close();
  }
}

/** A UDP device whose texts are all HTML. */
export class HostileDevice {
  constructor(port, words) {
    this.address = 30;
    this.words = words;
    this.socket = dgram.createSocket("udp4");
    this.send = (id, data, to = 255) => this.socket.send(frame(this.address, to, id, data), port, "127.0.0.1");
    this.socket.on("message", (bytes) => {
      for (let at = 0; at + 8 <= bytes.length; at += 8 + bytes.readUInt16LE(at + 4)) if (bytes[at + 3] === 0xe0) this.answer(bytes[at + 6], bytes.readUInt16LE(at + 7), bytes[at + 1]);
    });
    this.timer = setInterval(() => {
      this.send(0xa0, [1, ...Buffer.from(words)]);
      this.send(0xa1, [0, 0, 192, 127, ...Buffer.from(words)]); // a value that is not a number
      this.send(0x03, [1, 0, 2, 0, 3, 0, 0]);
    }, 200);
  }

  answer(cmd, val, to) {
    const name = Buffer.alloc(20, 0), one = this.words.slice(0, 20);
    name.write(one);
    if (cmd === 0) this.send(0xe3, [this.address, 100, 0, 100, 0, 0, 0, 0x20, 3, ...Buffer.from(this.words.slice(0, 60))], to);
    if (cmd === 1) this.send(0xe0, [1, 1, 0], to);
    if (cmd === 2) this.send(0xe1, [val, 0, ...Buffer.from(this.words.slice(0, 100))], to);
    if (cmd === 3) this.send(0xe2, [val, 0, 10, ...name, ...Buffer.from(this.words.slice(0, 150))], to);
  }

  stop() {
    clearInterval(this.timer);
    this.socket.close();
  }
}

const i16 = (value) => [value & 255, (value >> 8) & 255];
const i32 = (value) => [value & 255, (value >> 8) & 255, (value >> 16) & 255, (value >> 24) & 255];

/** A flying vehicle that sends by UDP ten times a second; kill() simulates a crash, stop() ends it after landing. `voltage` is that of the battery. */
export class FlyingDevice {
  constructor(port, { address = 50, name = "Falcon", voltage = 15.2, satellites = 14 } = {}) {
    Object.assign(this, { port, address, name, voltage, satellites });
    this.socket = dgram.createSocket("udp4");
    this.send = (id, data, to = 255) => this.socket.send(frame(this.address, to, id, data), port, "127.0.0.1");
    this.socket.on("message", (bytes) => {
      for (let at = 0; at + 8 <= bytes.length; at += 8 + bytes.readUInt16LE(at + 4))
        if (bytes[at + 3] === 0xe0 && bytes[at + 6] === 0) this.send(0xe3, [this.address, 100, 0, 100, 0, 0, 0, 0x20, 3, ...Buffer.from(this.name)], bytes[at + 1]);
    });
    this.fly();
  }

  /** The longest of the last intervals, in milliseconds: on a busy computer, timers are late. */
  period() {
    return Math.max(...this.sentAt.slice(-9).map((at, i, all) => (i > 0 ? at - all[i - 1] : 0)));
  }
  fly() {
    this.sentAt = [];
    this.timer = setInterval(() => {
      this.sentAt.push(performance.now());
      this.send(0x03, [...i16(500), ...i16(-300), ...i16(9000), 0]);
      this.send(0x06, [3, 2, 0, 0, 0]); // airborne
      this.send(0x05, [...i32(1500), ...i32(0), ...i32(1480), 1]);
      this.send(0x07, [...i16(120), ...i16(-50), ...i16(10)]);
      this.send(0x0d, [...i16(Math.round(this.voltage * 100)), ...i16(1850)]);
      this.send(0x0e, [3, 3, 3, 3]);
      this.send(0x20, [...i16(4100), ...i16(4200), ...i16(4000), ...i16(4300)]);
      this.send(0x30, [3, this.satellites, ...i32(1164000000), ...i32(399000000), ...i32(5000), ...i16(0), ...i16(0), ...i16(0), 10, 10, 10]);
      this.send(0x0c, [...i16(900), ...i16(120)]);
    }, 100);
  }
  log(text, colour = 1) {
    this.send(0xa0, [colour, ...Buffer.from(text)]);
  }
  kill() {
    clearInterval(this.timer);
  }
  stop() {
    this.kill();
    this.socket.send(frame(this.address, 255, 0x06, [3, 0, 0, 0, 0]), this.port, "127.0.0.1", () => this.socket.close());
  }
}
