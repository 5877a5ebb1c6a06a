// Reads what make_flight made, by the reader of those who made MCAP: MODULES=… FLIGHT=… node --test read.mjs
// Every message, streamed and by the indexes; every checksum; every frame, and every field of what it says, as it went in.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { pathToFileURL } from "node:url";
import { test } from "node:test";

const [modules, folder] = [process.env.MODULES, process.env.FLIGHT];
const require = createRequire(pathToFileURL(`${modules}/x.js`));
const load = async (name) => import(pathToFileURL(require.resolve(name)).href).then((m) => (m.default && !m.McapStreamReader ? { ...m.default, ...m } : m));
const { McapStreamReader, McapIndexedReader } = await load("@mcap/core");
const { parse } = await load("@foxglove/rosmsg");
const { MessageReader } = await load("@foxglove/rosmsg2-serialization");
const { decompress } = await load("fzstd");
const { crc32 } = createRequire(require.resolve("@mcap/core"))("@foxglove/crc");

const decompressHandlers = { zstd: (bytes, size) => decompress(bytes, new Uint8Array(Number(size))) };
const utf8 = new TextDecoder("utf-8", { fatal: true });

function streamed(bytes, piece) {
  const reader = new McapStreamReader({ decompressHandlers, validateCrcs: true });
  const records = [];
  for (let at = 0; at < bytes.length; at += piece) {
    reader.append(bytes.subarray(at, at + piece));
    for (let record; (record = reader.nextRecord()); ) records.push(record.type === "Message" ? { ...record, data: record.data.slice() } : record);
  }
  assert.ok(reader.done());
  assert.equal(reader.bytesRemaining(), 0);
  return records;
}

async function indexed(bytes) {
  const readable = {
    size: async () => BigInt(bytes.length),
    read: async (at, size) => bytes.subarray(Number(at), Number(at + size)),
  };
  const reader = await McapIndexedReader.Initialize({ readable, decompressHandlers });    // throws at a wrong summary CRC
  const messages = [];
  for await (const message of reader.readMessages({ validateCrcs: true })) messages.push({ ...message, data: message.data.slice() });
  return { reader, messages };
}

const key = (m) => `${m.channelId} ${m.sequence}`;
const bytesOf = (name) => new Uint8Array(readFileSync(`${folder}/${name}`));
const truth = readFileSync(`${folder}/flight.ndjson`, "utf8").trim().split("\n").map((line) => JSON.parse(line));

// Decodes messages by the schemas in the file.
function decoder(channels, schemas) {
  const readers = new Map();
  return (message) => {
    const channel = channels.get(message.channelId);
    const schema = schemas.get(channel.schemaId);
    if (channel.messageEncoding === "json") return JSON.parse(utf8.decode(message.data));
    assert.equal(channel.messageEncoding, "cdr");
    assert.equal(schema.encoding, "ros2msg");
    if (!readers.has(schema.id)) readers.set(schema.id, new MessageReader(parse(utf8.decode(schema.data), { ros2: true })));
    return readers.get(schema.id).readMessage(message.data);
  };
}

function contentOf(records) {
  const pick = (type) => new Map(records.filter((r) => r.type === type).map((r) => [r.id, r]));
  const channels = pick("Channel");
  return { channels, schemas: pick("Schema"), messages: records.filter((r) => r.type === "Message") };
}

function isAsItWentIn(item, m, decoded, topic) {
  if (item.lost !== undefined) {
    assert.equal(topic, "/anogate/losses");
    assert.deepEqual(decoded, { count: BigInt(item.lost), names: item.names });
    return;
  }
  assert.equal(topic, "/anogate/frames");
  assert.equal(m.logTime, BigInt(item.time));
  assert.equal(m.publishTime, m.logTime);
  const { frame, ...rest } = decoded;
  assert.equal(Buffer.from(frame).toString("hex").toUpperCase(), item.hex);
  assert.deepEqual(rest, {
    boottime_ns: BigInt(item.boottime), link: item.link, link_description: item.description, direction: item.direction,
    cause: item.cause, channel: item.channel, peer: item.peer,
  });
}

// A field of the JSON of a frame, and of the message in CDR. Where the one has no number the other has NaN.
function isTheSame(json, ros, where) {
  if (typeof json === "number" && typeof ros === "bigint") return assert.equal(ros, BigInt(json), where);
  if (typeof json === "string" && typeof ros === "bigint") return assert.equal(ros, BigInt(json), where);
  if (typeof json === "number") return assert.ok(Object.is(json, ros) || Math.fround(json) === ros || json === ros, `${where}: ${json} is ${ros}`);
  if (typeof json === "string" && ArrayBuffer.isView(ros))
    return assert.equal(Buffer.from(ros).toString("hex"), json.replaceAll(" ", "").toLowerCase(), where);
  if (Array.isArray(json) && typeof json[0] === "object" && ros instanceof Uint8Array)    // frames in a tunnel: JSON takes them apart
    return assert.ok(where.toLowerCase().includes(Buffer.from(ros).toString("hex")), where);
  if (Array.isArray(json)) {
    assert.equal(ros.length, json.length, where);
    return json.forEach((one, i) => isTheSame(one, ros[i], `${where}[${i}]`));
  }
  if (json !== null && typeof json === "object") return haveTheSameFields(json, ros, where);
  return assert.deepEqual(ros, json, where);
}

function haveTheSameFields(json, ros, where) {
  for (const [name, value] of Object.entries(json)) {
    if (name === "data" && ros.data === undefined && ros.frames) {    // what is no whole frame in a tunnel
      assert.ok(Buffer.from(ros.frames).toString("hex").includes(value.replaceAll(" ", "").toLowerCase()), `${where}.data`);
      continue;
    }
    const found = Object.keys(ros).filter((n) => n === name || n.startsWith(`${name}_`) || n === name.toLowerCase());
    assert.ok(found.length > 0, `${where}: no ${name} in ${Object.keys(ros)}`);
    if (value === null) {
      const isNothing = (one) => (typeof one === "number" ? !Number.isFinite(one) : one.length === 0);    // JSON has no infinity
      for (const n of found) assert.ok(isNothing(ros[n]), `${where}.${name} is ${ros[n]} where there is nothing`);
    } else {
      const n = found.find((one) => one === name && !Number.isNaN(ros[one])) ?? found.find((one) => !Number.isNaN(ros[one])) ?? found[0];
      isTheSame(value, ros[n], `${where}.${name}`);
    }
  }
}

async function checkFile(name) {
  const bytes = bytesOf(name);
  const records = streamed(bytes, 1000);
  const byIndex = await indexed(bytes);
  const { channels, schemas, messages } = contentOf(records);
  const { statistics, chunkIndexes, channelsById, metadataIndexes } = byIndex.reader;

  // what the indexes find is what there is, each once, in the order of time
  assert.deepEqual(byIndex.messages.map(key).sort(), messages.map(key).sort());
  const streamedBy = new Map(messages.map((m) => [key(m), m]));
  let last = 0n;
  for (const m of byIndex.messages) {
    assert.deepEqual(Buffer.from(m.data), Buffer.from(streamedBy.get(key(m)).data));
    assert.equal(m.logTime, streamedBy.get(key(m)).logTime);
    assert.ok(m.logTime >= last, "the index is not in the order of time");
    last = m.logTime;
  }

  // the statistics are those of what there is
  assert.equal(statistics.messageCount, BigInt(messages.length));
  assert.equal(statistics.chunkCount, chunkIndexes.length);
  assert.equal(statistics.channelCount, channels.size);
  assert.equal(statistics.schemaCount, schemas.size);
  assert.equal(statistics.metadataCount, metadataIndexes.length);
  assert.deepEqual([...channelsById.keys()].sort(), [...channels.keys()].sort());
  for (const [id, count] of statistics.channelMessageCounts) assert.equal(count, BigInt(messages.filter((m) => m.channelId === id).length));
  const times = messages.map((m) => m.logTime).sort((a, b) => (a < b ? -1 : a > b ? 1 : 0));
  assert.equal(statistics.messageStartTime, times[0] ?? 0n);
  assert.equal(statistics.messageEndTime, times.at(-1) ?? 0n);

  // the checksum of the data section, which the reader does not look at
  const end = records.find((r) => r.type === "DataEnd");
  assert.equal(crc32(bytes.subarray(0, Number(byIndex.reader.dataEndOffset))), end.dataSectionCrc);

  // the rules of the profile
  const { profile } = byIndex.reader.header;
  if (profile === "ros2") {
    for (const c of channels.values()) {
      assert.equal(c.messageEncoding, "cdr");
      assert.ok(c.metadata.has("offered_qos_profiles"));
      assert.match(schemas.get(c.schemaId).name, /^[a-z][a-z0-9_]*\/msg\/[A-Z][A-Za-z0-9]*$/);
    }
  }
  for (const m of messages) assert.ok(channels.has(m.channelId));

  const decode = decoder(channels, schemas);
  const raw = messages.filter((m) => channels.get(m.channelId).topic.startsWith("/anogate/"));
  return { profile, channels, schemas, messages, raw, decode, compression: new Set(chunkIndexes.map((c) => c.compression)) };
}

function checkItems({ channels, raw, decode }) {
  assert.equal(raw.length, truth.length);
  raw.forEach((m, i) => isAsItWentIn(truth[i], m, decode(m), channels.get(m.channelId).topic));
}

// Behind each frame that came in stands what it says: its own message first.
function checkDecoded({ channels, schemas, messages, decode }, sameFields) {
  let next = 0, count = 0;
  for (let i = 0; i < messages.length; ++i) {
    if (!channels.get(messages[i].channelId).topic.startsWith("/anogate/")) continue;
    const item = truth[next++];
    const behind = messages[i + 1];
    const hasOwn = behind && !channels.get(behind.channelId).topic.startsWith("/anogate/");
    if (item.lost !== undefined || item.direction !== 0 || !item.decoded.fields) continue;
    assert.ok(hasOwn, `nothing of ${item.decoded.name}`);
    const { topic, schemaId } = channels.get(behind.channelId);
    assert.ok(topic.endsWith(`/device_${item.decoded.from}/${item.decoded.name}`), topic);
    assert.equal(behind.logTime, BigInt(item.time));
    sameFields(item.decoded.fields, decode(behind), `${topic} of ${item.hex}`, schemas.get(schemaId));
    ++count;
  }
  assert.ok(count > 100, `only ${count} messages were compared`);
}

for (const name of ["flight.mcap", "plain.mcap"]) {
  test(`${name} is read by others as it was written`, async () => {
    const file = await checkFile(name);
    assert.equal(file.profile, "ros2");
    assert.deepEqual([...file.compression], [name === "plain.mcap" ? "" : "zstd"]);
    checkItems(file);
    checkDecoded(file, haveTheSameFields);
    for (const m of file.messages) file.decode(m);    // the messages of ROS as well
  });
}

// Each part of a schema is what ROS 2 calls so: fields in their order, with their types, and the constants.
test("standard messages have the definitions of ROS 2", async () => {
  const { ros2jazzy } = await load("@foxglove/rosmsg-msgs-common");
  const { schemas } = contentOf(streamed(bytesOf("flight.mcap"), 1 << 20));
  const fieldsOf = (all) => all.filter((f) => !f.isConstant).map((f) => [f.type, f.name, f.isArray ?? false, f.arrayLength ?? null, f.isComplex ?? false]);
  const constantsOf = (all) => all.filter((f) => f.isConstant).map((f) => [f.type, f.name, Number(f.value)]);
  const checked = new Set();
  for (const schema of schemas.values()) {
    if (schema.name.startsWith("ano_msgs/")) continue;
    for (const [i, part] of parse(utf8.decode(schema.data), { ros2: true }).entries()) {
      const name = i === 0 ? schema.name.replace("/msg/", "/") : part.name.replace("/msg/", "/");
      const wanted = ros2jazzy[name] ?? ros2jazzy[name.replace("/", "/msg/")];
      assert.ok(wanted, `ROS 2 has no ${name}`);
      assert.deepEqual(fieldsOf(part.definitions), fieldsOf(wanted.definitions), name);
      assert.deepEqual(constantsOf(part.definitions), constantsOf(wanted.definitions), name);
      checked.add(name);
    }
  }
  for (const name of ["Imu", "MagneticField", "Temperature", "NavSatFix", "NavSatStatus", "BatteryState", "Range", "PointCloud2", "PointField", "Image"]) assert.ok(checked.has(`sensor_msgs/${name}`), name);
  for (const name of ["geometry_msgs/QuaternionStamped", "geometry_msgs/Vector3Stamped", "geometry_msgs/PointStamped", "nav_msgs/Odometry", "std_msgs/Header", "builtin_interfaces/Time"]) assert.ok(checked.has(name), name);
});

test("messages in JSON are those of anoctl decode", async () => {
  const file = await checkFile("flight-json.mcap");
  assert.equal(file.profile, "");
  checkItems(file);
  checkDecoded(file, (fields, decoded, where, schema) => {
    assert.equal(schema.encoding, "jsonschema");
    assert.equal(JSON.parse(utf8.decode(schema.data)).type, "object");
    assert.deepEqual(decoded, Object.fromEntries(Object.entries(fields).filter(([, value]) => value !== null)), where);
  });
});

test("a file that was cut and repaired is whole for others", async () => checkItems(await checkFile("cut.mcap")));
test("a recording without frames is a file without messages", async () => assert.equal((await checkFile("empty.mcap")).messages.length, 0));
