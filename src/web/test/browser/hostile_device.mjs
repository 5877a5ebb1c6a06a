// A device of our own, by UDP: what it says is up to us.
import dgram from "node:dgram";

export function frame(from, to, id, data) {
  const bytes = Buffer.from([0xab, from, to, id, data.length & 255, data.length >> 8, ...data, 0, 0]);
  let sum = 0, add = 0;
  for (let i = 0; i < bytes.length - 2; ++i) add = (add + (sum = (sum + bytes[i]) & 255)) & 255;
  bytes[bytes.length - 2] = sum;
  bytes[bytes.length - 1] = add;
  return bytes;
}

/** A device behind UDP whose every word is HTML. */
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
      this.send(0xa1, [0, 0, 192, 127, ...Buffer.from(words)]); // a value that is no number
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
