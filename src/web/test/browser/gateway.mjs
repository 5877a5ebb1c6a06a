// A gateway with the page beside it, in a folder of its own.
import { spawn, spawnSync } from "node:child_process";
import dgram from "node:dgram";
import { once } from "node:events";
import { copyFileSync, mkdirSync, mkdtempSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";

const web = join(dirname(fileURLToPath(import.meta.url)), "../..");

export class Gateway {
  constructor(program) {
    this.folder = mkdtempSync(join(tmpdir(), "anogate-page-"));
    mkdirSync(join(this.folder, "src"));
    // Where it looks for the page: BUILD/web beside BUILD/src/anogated.
    copyFileSync(program, join(this.folder, "src/anogated"));
    const built = spawnSync(process.execPath, [join(web, "build.mjs"), "--out", join(this.folder, "web")], { encoding: "utf8" });
    if (built.status !== 0) throw new Error("the page could not be built: " + built.stderr);
    this.port = 0;
    this.said = "";
  }

  /** Until it serves; a second time at the same port. */
  async start(...links) {
    this.links = links.length > 0 ? links : this.links;
    const folder = this.folder;
    this.child = spawn(join(folder, "src/anogated"), ["--control", join(folder, "control.sock"), "--http", `127.0.0.1:${this.port}`, ...this.links], {
      env: { ...process.env, HOME: folder, XDG_STATE_HOME: join(folder, "state"), STATE_DIRECTORY: "" },
      stdio: ["ignore", "pipe", "pipe"],
    });
    let said = "";
    await new Promise((serves, fails) => {
      const hear = (bytes) => {
        said += bytes;
        const at = /http:\/\/127\.0\.0\.1:(\d+): up/.exec(said);
        if (!at) return;
        this.port = Number(at[1]);
        serves();
      };
      this.child.stdout.on("data", hear);
      this.child.stderr.on("data", hear);
      this.child.once("exit", (code) => fails(new Error(`anogated ended with ${code}: ${said}`)));
    });
    this.origin = `http://127.0.0.1:${this.port}`;
  }

  async stop(signal = "SIGTERM") {
    if (!this.child || this.child.exitCode !== null) return;
    const ended = once(this.child, "exit");
    this.child.kill(signal);
    await ended;
  }

  token(access) {
    const line = readFileSync(join(this.folder, "state/anogate/token"), "utf8").split("\n").find((one) => one.startsWith(access + " "));
    return line.split(" ")[1];
  }

  async ask(path, method = "GET", body) {
    const headers = { Authorization: "Bearer " + this.token("control"), ...(body === undefined ? {} : { "Content-Type": "application/json" }) };
    return (await fetch(this.origin + path, { method, headers, ...(body === undefined ? {} : { body: JSON.stringify(body) }) })).json();
  }

  remove() {
    rmSync(this.folder, { recursive: true, force: true });
  }
}

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

/** A UDP port that nobody has. */
export async function freePort() {
  const socket = dgram.createSocket("udp4");
  socket.bind(0, "127.0.0.1");
  await once(socket, "listening");
  const { port } = socket.address();
  socket.close();
  await once(socket, "close");
  return port;
}
