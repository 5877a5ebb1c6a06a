// Every message of our table, compared with node-mavlink in both directions.
import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { createRequire } from "node:module";
import { test } from "node:test";

const require = createRequire(process.env.MODULES + "/package.json");
const mappings = require("mavlink-mappings");
const { MavLinkProtocolV1, MavLinkProtocolV2, MavLinkPacketSplitter, MavLinkPacketParser } = require("node-mavlink");
const { MavLinkData, MavLinkPacketField } = require("mavlink-mappings");

function run(what, input = "") {
  const result = spawnSync(process.env.PACKETS, [what], { input, encoding: "utf8", maxBuffer: 1 << 26, timeout: 60_000 });
  assert.equal(result.status, 0, `${what}: ${result.stderr}`);
  return result.stdout.trimEnd().split("\n");
}

// Messages of the dialect "common" that mavlink-mappings does not have, by their published definitions.
function defined(id, name, magic, fields) {
  let offset = 0;
  const list = fields.map(([field, type, size, length = 0]) => {
    const one = new MavLinkPacketField(field, field, offset, false, size, type, "", length);
    offset += size * (length || 1);
    return one;
  });
  const Class = class extends MavLinkData {};
  return Object.assign(Class, { MSG_ID: id, MSG_NAME: name, MAGIC_NUMBER: magic, PAYLOAD_LENGTH: offset, FIELDS: list });
}
const u8 = ["uint8_t", 1], u16 = ["uint16_t", 2], u32 = ["uint32_t", 4], u64 = ["uint64_t", 8];
const own = [
  defined(8, "LINK_NODE_STATUS", 117, [["timestamp", ...u64], ["tx_rate", ...u32], ["rx_rate", ...u32], ["messages_sent", ...u32],
    ["messages_received", ...u32], ["messages_lost", ...u32], ["rx_parse_err", ...u16], ["tx_overflows", ...u16],
    ["rx_overflows", ...u16], ["tx_buf", ...u8], ["rx_buf", ...u8]]),
  defined(80, "COMMAND_CANCEL", 14, [["command", ...u16], ["target_system", ...u8], ["target_component", ...u8]]),
  defined(300, "PROTOCOL_VERSION", 217, [["version", ...u16], ["min_version", ...u16], ["max_version", ...u16],
    ["spec_version_hash", "uint8_t[]", 1, 8], ["library_version_hash", "uint8_t[]", 1, 8]]),
];

const names = run("list");
const classes = new Map();
for (const registry of [mappings.minimal.REGISTRY, mappings.standard.REGISTRY, mappings.common.REGISTRY])
  for (const Class of Object.values(registry)) classes.set(Class.MSG_NAME, Class);
for (const Class of own) {
  assert.ok(!classes.has(Class.MSG_NAME), `${Class.MSG_NAME} is in mavlink-mappings now`);
  classes.set(Class.MSG_NAME, Class);
}

let seed = 1;
const random = (n) => {
  seed = (Math.imul(seed, 1103515245) + 12345) >>> 0;
  return Math.floor((seed / 2 ** 32) * n);
};

function value(type) {
  const bits = Number(/\d+/.exec(type)?.[0] ?? 0);
  if (type.startsWith("float")) return Math.fround([0, -1.5, 3.4e38, 1e-30, random(1e6) / 7][random(5)]);
  if (type === "uint8_t_mavlink_version") return 3;
  if (bits === 64) {
    const wide = (BigInt(random(2 ** 32)) << 32n) | BigInt(random(2 ** 32));
    return type.startsWith("u") ? wide : BigInt.asIntN(64, wide);
  }
  const wide = random(3) === 0 ? 0 : random(2 ** bits);
  return type.startsWith("u") ? wide : wide - 2 ** (bits - 1);
}

function example(Class) {
  const message = new Class();
  for (const field of Class.FIELDS) {
    const base = field.type.replace("[]", "");
    const letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZ_abc0123456789";
    if (field.type === "char[]")
      message[field.name] = Array.from({ length: random(field.length + 1) }, () => letters[random(letters.length)]).join("");
    else if (field.type.endsWith("[]")) message[field.name] = Array.from({ length: field.length }, () => value(base));
    else message[field.name] = value(base);
  }
  return message;
}

const number = (x) => (typeof x === "bigint" || Number.isInteger(x) ? BigInt(x) : x);
const same = (a, b) => number(a) === number(b);

function written(message) {
  return message.constructor.FIELDS.map((field) => `${field.source}=${[message[field.name]].flat().join(",")}`).join(" ");
}

function assertSame(message, text, what) {
  const fields = new Map(text.map((word) => [word.slice(0, word.indexOf("=")), word.slice(word.indexOf("=") + 1)]));
  for (const field of message.constructor.FIELDS) {
    const ours = fields.get(field.source);
    const theirs = message[field.name];
    if (field.type === "char[]") assert.equal(ours, theirs, `${what}.${field.source}`);
    else
      ours.split(",").forEach((one, i) => {
        const wanted = [theirs].flat()[i];
        const got = typeof wanted === "bigint" ? BigInt(one) : field.type.startsWith("float") ? Math.fround(Number(one)) : Number(one);
        assert.ok(same(wanted, got), `${what}.${field.source}[${i}]: ${one} is not ${wanted}`);
      });
  }
}

// node-mavlink writes extensions in version 1, too, which the definition forbids: only messages without extensions are compared there.
const cases = [];
for (const name of names) {
  const Class = classes.get(name);
  assert.ok(Class, `${name} is a message of "common"`);
  // Of a payload of zeros, node-mavlink sends no byte, and the definition requires one.
  for (let i = 0; i < 6; ++i) {
    const message = example(Class);
    if (Class.FIELDS.some((field) => [message[field.name]].flat().some((one) => one !== "" && Number(one) !== 0)))
      cases.push({ version: 2, message });
  }
  if (Class.MSG_ID < 256 && !Class.FIELDS.some((field) => field.extension)) cases.push({ version: 1, message: example(Class) });
}

test("packets that we write are those of node-mavlink, byte for byte", () => {
  const ours = run("encode", cases.map(({ version, message }) => `${version} ${message.constructor.MSG_NAME} ${written(message)}\n`).join(""));
  cases.forEach(({ version, message }, i) => {
    const protocol = new (version === 1 ? MavLinkProtocolV1 : MavLinkProtocolV2)(42, 7);
    assert.equal(ours[i], protocol.serialize(message, 5).toString("hex"), message.constructor.MSG_NAME);
  });
});

test("node-mavlink reads what we write", async () => {
  const ours = run("encode", cases.map(({ version, message }) => `${version} ${message.constructor.MSG_NAME} ${written(message)}\n`).join(""));
  const magic = Object.fromEntries([...classes.values()].map((Class) => [Class.MSG_ID, Class.MAGIC_NUMBER]));
  const splitter = new MavLinkPacketSplitter({}, { magicNumbers: magic });
  const parser = new MavLinkPacketParser();
  splitter.pipe(parser);
  const found = [];
  parser.on("data", (packet) => found.push(packet));
  for (const line of ours) splitter.write(Buffer.from(line, "hex"));
  splitter.end();
  await new Promise((resolve) => parser.on("end", resolve));
  assert.equal(found.length, cases.length);
  found.forEach((packet, i) => {
    const { message } = cases[i];
    const Class = message.constructor;
    assert.equal(packet.header.msgid, Class.MSG_ID);
    const data = packet.protocol.data(packet.payload, Class);
    for (const field of Class.FIELDS)
      [message[field.name]].flat().forEach((wanted, k) =>
        assert.ok(field.type === "char[]" ? data[field.name] === wanted : same(wanted, [data[field.name]].flat()[k]),
          `${Class.MSG_NAME}.${field.source}`));
  });
});

test("we read what node-mavlink writes", () => {
  const packets = cases.map(({ version, message }, i) =>
    new (version === 1 ? MavLinkProtocolV1 : MavLinkProtocolV2)(99, 8).serialize(message, i % 256).toString("hex"));
  const lines = run("decode", packets.join("\n") + "\n");
  assert.equal(lines.length, cases.length);
  lines.forEach((line, i) => {
    const [version, system, component, sequence, name, ...fields] = line.split(" ");
    const { message } = cases[i];
    assert.deepEqual([version, system, component, sequence, name],
      [String(cases[i].version), "99", "8", String(i % 256), message.constructor.MSG_NAME]);
    assertSame(message, fields, name);
  });
});
