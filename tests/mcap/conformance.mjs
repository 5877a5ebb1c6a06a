// The files of MCAP's conformance tests, made anew by their rules: every input with every set of features that has a meaning for it. And
// a recording of ours, saved by another writer in every form that it has. Our reader reads all of them.
//   MODULES=… FLIGHT=… CONTENT=… node --test conformance.mjs
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdirSync, readFileSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { pathToFileURL } from "node:url";
import { test } from "node:test";

const { MODULES: modules, FLIGHT: folder, CONTENT: program } = process.env;
const require = createRequire(pathToFileURL(`${modules}/x.js`));
const { McapChunkBuilder, McapConstants, McapRecordBuilder, McapStreamReader, McapWriter } = require("@mcap/core");
const { decompress } = require("fzstd");
const { Opcode } = McapConstants;

const schema = { type: "Schema", id: 1, name: "Example", encoding: "c", data: new Uint8Array([4, 5, 6]) };
const channel = { type: "Channel", id: 1, topic: "example", schemaId: 1, messageEncoding: "a", metadata: new Map([["foo", "bar"]]) };
const message = { type: "Message", channelId: 1, publishTime: 1n, logTime: 2n, data: new Uint8Array([1, 2, 3]), sequence: 10 };
const inputs = {
  NoData: [],
  OneAttachment: [{ type: "Attachment", name: "myFile", mediaType: "application/octet-stream", createTime: 1n, logTime: 2n, data: new Uint8Array([1, 2, 3]) }],
  OneMetadata: [{ type: "Metadata", name: "myMetadata", metadata: new Map([["foo", "bar"]]) }],
  OneMessage: [schema, channel, message],
  OneSchemalessMessage: [{ ...channel, schemaId: 0 }, message],
  TenMessages: [schema, channel, ...Array.from({ length: 10 }, (_, i) => ({ ...message, publishTime: BigInt(i + 1), logTime: BigInt(i + 2), sequence: 10 + i }))],
};
const features = ["ch", "mx", "st", "rsh", "rch", "ax", "mdx", "chx", "sum", "pad"];

function hasMeaning(has, records) {
  const any = (...types) => records.some((r) => types.includes(r.type));
  if (has("ax") && !any("Attachment")) return false;
  if (has("mdx") && !any("Metadata")) return false;
  if (has("rsh") && !any("Schema")) return false;
  if (has("rch") && !any("Channel")) return false;
  if ((has("ch") || has("mx") || has("chx")) && !any("Schema", "Channel", "Message")) return false;
  if ((has("mx") || has("chx")) && !has("ch")) return false;
  return !has("sum") || ["chx", "rsh", "rch", "mdx", "ax", "st"].some(has);
}

function fileOf(has, records) {
  const builder = new McapRecordBuilder({ padRecords: has("pad") });
  const at = () => BigInt(builder.length);
  const chunk = has("ch") ? new McapChunkBuilder({ useMessageIndex: has("mx") }) : undefined;
  const of = (type) => records.filter((r) => r.type === type);
  const attachments = [], metadata = [], chunks = [];
  builder.writeMagic();
  builder.writeHeader({ profile: "", library: "" });
  for (const r of records) {
    const offset = at();
    if (r.type === "Schema") chunk ? chunk.addSchema(r) : builder.writeSchema(r);
    if (r.type === "Channel") chunk ? chunk.addChannel(r) : builder.writeChannel(r);
    if (r.type === "Message") chunk ? chunk.addMessage(r) : builder.writeMessage(r);
    if (r.type === "Attachment") attachments.push({ ...r, offset, length: builder.writeAttachment(r), dataSize: BigInt(r.data.byteLength) });
    if (r.type === "Metadata") metadata.push({ name: r.name, offset, length: builder.writeMetadata(r) });
  }
  if (chunk) {
    const records = chunk.buffer, size = BigInt(records.byteLength), offsets = new Map();
    const one = { compression: "", messageStartTime: chunk.messageStartTime, messageEndTime: chunk.messageEndTime, uncompressedSize: size };
    const chunkStartOffset = at();
    const chunkLength = builder.writeChunk({ ...one, uncompressedCrc: 0, records });
    const indexes = at();
    for (const index of chunk.indices) {
      offsets.set(index.channelId, at());
      builder.writeMessageIndex(index);
    }
    chunks.push({ ...one, compressedSize: size, chunkStartOffset, chunkLength, messageIndexLength: at() - indexes, messageIndexOffsets: offsets });
  }
  builder.writeDataEnd({ dataSectionCrc: 0 });
  const summaryStart = at(), groups = [];
  const group = (feature, groupOpcode, all, write) => {
    const groupStart = at();
    if (has(feature)) all.forEach((one) => write.call(builder, one));
    if (at() > groupStart) groups.push({ groupOpcode, groupStart, groupLength: at() - groupStart });
  };
  const messages = of("Message");
  group("rsh", Opcode.SCHEMA, of("Schema"), builder.writeSchema);
  group("rch", Opcode.CHANNEL, of("Channel"), builder.writeChannel);
  group("st", Opcode.STATISTICS, [{
    messageCount: BigInt(messages.length), schemaCount: of("Schema").length, channelCount: of("Channel").length, attachmentCount: attachments.length,
    metadataCount: metadata.length, chunkCount: chunks.length, messageStartTime: messages[0]?.logTime ?? 0n, messageEndTime: messages.at(-1)?.logTime ?? 0n,
    channelMessageCounts: new Map(messages.length > 0 ? [[1, BigInt(messages.length)]] : []),
  }], builder.writeStatistics);
  group("mdx", Opcode.METADATA_INDEX, metadata, builder.writeMetadataIndex);
  group("ax", Opcode.ATTACHMENT_INDEX, attachments, builder.writeAttachmentIndex);
  group("chx", Opcode.CHUNK_INDEX, chunks, builder.writeChunkIndex);
  const offsetsStart = at();
  if (has("sum")) groups.forEach((one) => builder.writeSummaryOffset(one));
  builder.writeFooter({ summaryStart: groups.length > 0 ? summaryStart : 0n, summaryOffsetStart: at() > offsetsStart ? offsetsStart : 0n, summaryCrc: 0 });
  builder.writeMagic();
  return builder.buffer.slice();
}

const hex = (bytes) => Buffer.from(bytes).toString("hex");

/** The content of `files`, {name: bytes}, as our reader has it, by their names. */
function contentOf(files, where) {
  mkdirSync(`${folder}/${where}`, { recursive: true });
  const names = Object.keys(files);
  for (const name of names) writeFileSync(`${folder}/${where}/${name}.mcap`, files[name]);
  const input = names.map((name) => `${folder}/${where}/${name}.mcap\n`).join("");
  const lines = execFileSync(program, { input, maxBuffer: 2 ** 30, encoding: "utf8" }).trim().split("\n");
  return new Map(lines.map((line, i) => [names[i], JSON.parse(line)]));
}

function isReadToItsEnd(content, name) {
  assert.equal(content.fault, "", name);
  assert.equal(content.ended, true, name);
  assert.equal(content.unread, 0, name);
}

test("every file of the conformance tests is read", () => {
  const files = {}, wanted = {};
  for (const [name, records] of Object.entries(inputs))
    for (let set = 0; set < 2 ** features.length; ++set) {
      const chosen = features.filter((_, i) => set & (1 << i));
      const has = (feature) => chosen.includes(feature);
      if (!hasMeaning(has, records)) continue;
      const file = [name, ...[...chosen].sort()].join("-");
      files[file] = fileOf(has, records);
      wanted[file] = records;
    }
  const all = contentOf(files, "conformance");
  assert.ok(all.size > 300, `${all.size} files`);
  for (const [name, content] of all) {
    const of = (type) => wanted[name].filter((r) => r.type === type);
    isReadToItsEnd(content, name);
    assert.deepEqual(content.schemas, of("Schema").map((s) => ({ id: s.id, name: s.name, encoding: s.encoding, text: hex(s.data) })), name);
    assert.deepEqual(content.channels, of("Channel").map((c) => ({ id: c.id, schema: c.schemaId, topic: c.topic, encoding: c.messageEncoding })), name);
    assert.deepEqual(content.messages, of("Message").map((m) => ({ channel: m.channelId, sequence: m.sequence, log_time: `${m.logTime}`, publish_time: `${m.publishTime}`, data: hex(m.data) })), name);
    assert.equal(content.attachments, of("Attachment").length, name);
    assert.equal(content.metadata, of("Metadata").length, name);
    assert.deepEqual(content.items, [], name);
    assert.equal(content.foreign, 0, name);
  }
});

/** The records of a recording of ours, as another program reads them. */
function recordsOf(bytes) {
  const reader = new McapStreamReader({ decompressHandlers: { zstd: (packed, size) => decompress(packed, new Uint8Array(Number(size))) } });
  reader.append(bytes);
  const records = [];
  for (let record; (record = reader.nextRecord()) && record.type !== "DataEnd"; ) records.push(record.type === "Message" ? { ...record, data: record.data.slice() } : record);
  return records;
}

async function savedAnew(records, options) {
  const parts = [];
  let size = 0;
  const writable = {
    write: async (part) => {
      parts.push(part.slice());
      size += part.length;
    },
    position: () => BigInt(size),
  };
  const writer = new McapWriter({ writable, chunkSize: 20000, ...options });
  await writer.start({ profile: "ros2", library: "another" });
  const schemas = new Map(), channels = new Map();
  for (const r of records) {
    if (r.type === "Schema" && !schemas.has(r.id)) schemas.set(r.id, await writer.registerSchema(r));
    if (r.type === "Channel" && !channels.has(r.id)) channels.set(r.id, await writer.registerChannel({ ...r, schemaId: schemas.get(r.schemaId) }));
    if (r.type === "Message") await writer.addMessage({ ...r, channelId: channels.get(r.channelId) });
    if (r.type === "Metadata") await writer.addMetadata(r);
  }
  await writer.end();
  return new Uint8Array(Buffer.concat(parts));
}

test("a recording that another program saved anew, in any form, is read as it was", async () => {
  const options = ["useChunks", "useMessageIndex", "useStatistics", "repeatSchemas", "repeatChannels", "useMetadataIndex", "useChunkIndex", "useSummaryOffsets"];
  const records = recordsOf(new Uint8Array(readFileSync(`${folder}/flight.mcap`)));
  const messages = records.filter((r) => r.type === "Message").slice(0, 150);
  const channels = records.filter((r) => r.type === "Channel" && messages.some((m) => m.channelId === r.id));
  const schemas = records.filter((r) => r.type === "Schema" && channels.some((c) => c.schemaId === r.id));
  const some = [...schemas, ...channels, ...records.filter((r) => r.type === "Metadata"), ...messages];
  const files = {};
  for (let set = 0; set < 2 ** options.length; ++set) {
    const chosen = Object.fromEntries(options.map((option, i) => [option, (set & (1 << i)) !== 0]));
    files[options.filter((option) => chosen[option]).join("-") || "nothing"] = await savedAnew(some, chosen);
  }
  const truth = readFileSync(`${folder}/flight.ndjson`, "utf8").trim().split("\n").map((line) => JSON.parse(line));
  const topics = new Map(records.filter((r) => r.type === "Channel").map((c) => [c.id, c.topic]));
  const count = some.filter((r) => r.type === "Message" && topics.get(r.channelId).startsWith("/anogate/")).length;
  const items = truth.slice(0, count).map((item) => (item.lost === undefined ? { time: item.time, link: item.link, hex: item.hex.toLowerCase() } : { lost: item.lost, names: item.names }));
  assert.ok(count > 50);
  for (const [name, content] of contentOf(files, "anew")) {
    isReadToItsEnd(content, name);
    assert.deepEqual(content.items, items, name);
    assert.notEqual(content.index_agrees, true, `${name}: a part of the recording has the sum of all of it`);
  }
});

test("our own index tells what all of the file tells", () => {
  const all = contentOf(Object.fromEntries(["flight", "flight-json", "plain", "empty", "cut"].map((name) => [name, readFileSync(`${folder}/${name}.mcap`)])), "ours");
  for (const [name, content] of all) {
    isReadToItsEnd(content, name);
    assert.equal(content.index_agrees, true, name);
  }
});
