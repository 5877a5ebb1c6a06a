// What we write follows the specification of MCAP, record by record: their order, and every offset in every index.
//   MODULES=… FLIGHT=… node --test order.mjs
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { pathToFileURL } from "node:url";
import { test } from "node:test";

const { MODULES: modules, FLIGHT: folder } = process.env;
const require = createRequire(pathToFileURL(`${modules}/x.js`));
const { McapConstants } = require("@mcap/core");
const { decompress } = require("fzstd");
const { Opcode, MCAP_MAGIC } = McapConstants;

const headSize = 9;    // opcode and length

/** Takes fields off the front. */
class Fields {
  constructor(bytes) {
    this.bytes = bytes;
    this.view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
    this.at = 0;
  }
  u16() { return this.view.getUint16((this.at += 2) - 2, true); }
  u32() { return this.view.getUint32((this.at += 4) - 4, true); }
  u64() { return Number(this.view.getBigUint64((this.at += 8) - 8, true)); }
  time() { return this.view.getBigUint64((this.at += 8) - 8, true); }
  take(size) { return this.bytes.subarray((this.at += size) - size, this.at); }
  text() { return Buffer.from(this.take(this.u32())).toString("utf8"); }
  pairs(read) {
    const end = this.u32() + this.at, all = [];
    while (this.at < end) all.push(read(this));
    assert.equal(this.at, end);
    return all;
  }
}

/** {opcode, at, size, body}, one behind the other; `at` from the begin of `bytes`. */
function recordsOf(bytes, from, to) {
  const records = [];
  for (let at = from; at < to; ) {
    const fields = new Fields(bytes.subarray(at));
    const opcode = fields.take(1)[0], size = headSize + fields.u64();
    assert.ok(at + size <= to, `a record at ${at} reaches over the end`);
    records.push({ opcode, at, size, body: bytes.subarray(at + headSize, at + size) });
    at += size;
  }
  return records;
}

function messageAt(bytes, at) {
  const [record] = recordsOf(bytes, at, at + headSize + new Fields(bytes.subarray(at + 1)).u64());
  assert.equal(record.opcode, Opcode.MESSAGE);
  const fields = new Fields(record.body);
  const channel = fields.u16();
  fields.u32();
  return { channel, logTime: fields.time() };
}

/** Schemas before their channels, channels before their messages; the same number always means the same. */
class Told {
  schemas = new Map();
  channels = new Map();
  messages = new Map();
  take({ opcode, body }) {
    const fields = new Fields(body), id = fields.u16(), text = Buffer.from(body).toString("hex");
    if (opcode === Opcode.SCHEMA) {
      assert.notEqual(id, 0);
      assert.equal(this.schemas.get(id) ?? text, text);
      this.schemas.set(id, text);
    } else if (opcode === Opcode.CHANNEL) {
      assert.ok(this.schemas.has(fields.u16()), "a channel has no schema before it");
      assert.equal(this.channels.get(id) ?? text, text);
      this.channels.set(id, text);
    } else {
      assert.equal(opcode, Opcode.MESSAGE);
      assert.ok(this.channels.has(id), "a message has no channel before it");
      const sequence = fields.u32();
      assert.equal(sequence, (this.messages.get(id) ?? 0) + 1, "sequences have no gaps");
      this.messages.set(id, sequence);
    }
  }
}

function checkChunk({ body }, told) {
  const fields = new Fields(body);
  const first = fields.time(), last = fields.time(), size = fields.u64();
  fields.u32();
  const compression = fields.text(), packed = fields.take(fields.u64());
  assert.equal(fields.at, body.length);
  const bytes = compression === "zstd" ? decompress(packed, new Uint8Array(size)) : packed;
  assert.equal(bytes.length, size);
  const records = recordsOf(bytes, 0, size);
  records.forEach((record) => told.take(record));
  const times = records.filter((r) => r.opcode === Opcode.MESSAGE).map((r) => messageAt(bytes, r.at).logTime);
  const by = (a, b) => (a < b ? -1 : a > b ? 1 : 0);
  assert.deepEqual([first, last], [times.sort(by)[0] ?? 0n, times.at(-1) ?? 0n]);
  return { bytes, records, first, last, compression, packed: packed.length, size, indexes: new Map(), indexSize: 0, indexed: new Set() };
}

function checkMessageIndex({ at, size, body }, chunk) {
  const fields = new Fields(body), channel = fields.u16();
  assert.ok(!chunk.indexes.has(channel), "a channel has one index of a chunk");
  chunk.indexes.set(channel, at);
  chunk.indexSize += size;
  for (const [time, place] of fields.pairs((f) => [f.time(), f.u64()])) {
    assert.deepEqual(messageAt(chunk.bytes, place), { channel, logTime: time });
    assert.ok(!chunk.indexed.has(place));
    chunk.indexed.add(place);
  }
}

function checkData(records) {
  const told = new Told(), chunks = [];
  let chunk;
  for (const record of records) {
    if (record.opcode === Opcode.MESSAGE_INDEX) {
      assert.ok(chunk, "an index stands behind its chunk");
      checkMessageIndex(record, chunk);
      continue;
    }
    chunk = undefined;
    if (record.opcode === Opcode.CHUNK) chunks.push((chunk = { ...checkChunk(record, told), at: record.at, whole: record.size }));
    else assert.equal(record.opcode, Opcode.METADATA, `opcode ${record.opcode} in the data section`);
  }
  for (const one of chunks)
    assert.deepEqual([...one.indexed].sort((a, b) => a - b), one.records.filter((r) => r.opcode === Opcode.MESSAGE).map((r) => r.at));
  return { told, chunks };
}

function checkSummary(summary, { told, chunks }, metadata) {
  const of = (opcode) => summary.filter((r) => r.opcode === opcode);
  const opcodes = summary.map((r) => r.opcode);
  const groups = [...new Set(opcodes)];
  assert.deepEqual(opcodes, groups.flatMap((opcode) => of(opcode).map(() => opcode)), "records of a kind stand together");
  if (groups.length > 0) assert.equal(groups.at(-1), Opcode.SUMMARY_OFFSET);
  assert.deepEqual(of(Opcode.SUMMARY_OFFSET).map(({ body }) => {
    const fields = new Fields(body);
    return [fields.take(1)[0], fields.u64(), fields.u64()];
  }), groups.slice(0, -1).map((opcode) => [opcode, of(opcode)[0].at, of(opcode).reduce((size, r) => size + r.size, 0)]));
  assert.deepEqual(of(Opcode.SCHEMA).map((r) => Buffer.from(r.body).toString("hex")).sort(), [...told.schemas.values()].sort());
  assert.deepEqual(of(Opcode.CHANNEL).map((r) => Buffer.from(r.body).toString("hex")).sort(), [...told.channels.values()].sort());
  assert.equal(of(Opcode.STATISTICS).length, 1);
  assert.deepEqual(of(Opcode.CHUNK_INDEX).map(({ body }) => {
    const f = new Fields(body);
    return [f.time(), f.time(), f.u64(), f.u64(), f.pairs((p) => [p.u16(), p.u64()]), f.u64(), f.text(), f.u64(), f.u64()];
  }), chunks.map((c) => [c.first, c.last, c.at, c.whole, [...c.indexes], c.indexSize, c.compression, c.packed, c.size]));
  assert.deepEqual(of(Opcode.METADATA_INDEX).map(({ body }) => {
    const f = new Fields(body);
    return [f.u64(), f.u64(), f.text()];
  }), metadata.map((r) => [r.at, r.size, new Fields(r.body).text()]));
}

for (const name of ["flight", "flight-json", "plain", "empty", "cut"])
  test(`${name}.mcap is as the specification says`, () => {
    const bytes = new Uint8Array(readFileSync(`${folder}/${name}.mcap`)), magic = Buffer.from(MCAP_MAGIC);
    assert.ok(Buffer.from(bytes.subarray(0, 8)).equals(magic) && Buffer.from(bytes.subarray(-8)).equals(magic));
    const records = recordsOf(bytes, 8, bytes.length - 8);
    assert.equal(records[0].opcode, Opcode.HEADER);
    const end = records.findIndex((r) => r.opcode === Opcode.DATA_END), footer = records.at(-1);
    assert.equal(footer.opcode, Opcode.FOOTER);
    assert.equal(footer.size, headSize + 20);
    const data = records.slice(1, end), summary = records.slice(end + 1, -1), fields = new Fields(footer.body);
    assert.equal(fields.u64(), summary[0].at);
    assert.equal(fields.u64(), summary.find((r) => r.opcode === Opcode.SUMMARY_OFFSET).at);
    checkSummary(summary, checkData(data), data.filter((r) => r.opcode === Opcode.METADATA));
  });
