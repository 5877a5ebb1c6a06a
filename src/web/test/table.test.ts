import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { test } from "node:test";
import { MessageTable, Reading, textOf, type MessageRow, type Value } from "../src/protocol/table";

const here = import.meta.dirname;
const rows = JSON.parse(readFileSync(join(here, "messages.json"), "utf8")) as MessageRow[];
const table = new MessageTable(rows);

export function csvRows(text: string): string[][] {
  const all: string[][] = [[]];
  const cell = /("(?:[^"]|"")*"|[^,\n]*)(,|\n|$)/g;
  for (let m = cell.exec(text); m && m.index < text.length; m = cell.exec(text)) {
    const raw = m[1]!;
    all[all.length - 1]!.push(raw.startsWith('"') ? raw.slice(1, -1).replace(/""/g, '"') : raw);
    if (m[2] === "\n") all.push([]);
  }
  return all.filter((row) => row.length >= 3);
}

const bytesOf = (hex: string): Uint8Array => Uint8Array.from(hex.match(/[0-9a-f]{2}/gi) ?? [], (pair) => parseInt(pair, 16));

function assertSame(actual: Value, expected: unknown, what: string): void {
  if (typeof actual === "bigint") return assert.equal(actual.toString(), String(expected), what);
  if (typeof actual === "number" && typeof expected === "number")
    return assert.ok(Math.abs(actual - expected) <= 1e-6 * Math.max(1, Math.abs(expected)), `${what}: ${actual} is not ${expected}`);
  if (Array.isArray(actual) && Array.isArray(expected)) {
    assert.equal(actual.length, expected.length, what);
    return actual.forEach((one, i) => assertSame(one, expected[i], `${what}[${i}]`));
  }
  if (typeof actual === "object" && actual !== null && typeof expected === "object" && expected !== null)
    return Object.entries(actual).forEach(([name, one]) => assertSame(one, (expected as Record<string, unknown>)[name], `${what}.${name}`));
  assert.equal(actual, expected, what);
}

test("reads every frame of the golden table as the gateway does", () => {
  const vectors = csvRows(readFileSync(join(here, "../../../tests/vectors/frames.csv"), "utf8")).slice(1);
  let read = 0;
  for (const [name = "", hex = "", text = ""] of vectors) {
    const frame = bytesOf(hex);
    const json = JSON.parse(text) as { id: number; name?: string; fields?: Record<string, unknown>; extra?: string };
    const reading = table.read(frame[3]!, frame[1]!, frame.subarray(6, frame.length - 2));
    if (!json.fields) {
      assert.equal(typeof reading, "string", `${name}: it has no layout`);
      continue;
    }
    assert.ok(reading instanceof Reading, `${name}: ${String(reading)}`);
    assert.equal(reading.row.name, json.name, name);
    for (const { field, value } of reading.fields()) {
      const expected = json.fields[field.name];
      if (field.type === "frames" || (typeof expected === "string" && expected.includes("\ufffd"))) continue; // the page reads GBK as well
      assertSame(value, expected, `${name}, ${field.name}`);
    }
    assert.equal(Buffer.from(reading.extra()).toString("hex"), json.extra ?? "", `${name}, extra`);
    ++read;
  }
  assert.ok(read > 60, `only ${read} frames had fields`);
});

test("gives a hundredth as people write it", () => {
  const reading = table.read(3, 220, new Uint8Array([57, 0, 0, 0, 0, 0, 0])) as Reading;
  assert.equal(reading.get("rol"), 0.57);
});

test("reads no byte behind the end of what any id brings", () => {
  for (let id = 0; id < 256; ++id)
    for (let size = 0; size < 48; ++size)
      for (const fill of [0, 1, 16, 100, 255]) {
        const reading = table.read(id, 220, new Uint8Array(size).fill(fill));
        if (typeof reading !== "string") reading.fields();
      }
});

test("takes the flexible layout of a sender before the one for all", () => {
  const flexible = (source: number | undefined, name: string): MessageRow =>
    ({ ...rows.find((row) => row.id === 0xf1)!, size: 2, fields: [{ name, type: "i16", offset: 0, scale: 1 }], ...(source === undefined ? {} : { source }) });
  const own = new MessageTable([flexible(undefined, "all"), flexible(30, "own")]);
  const data = new Uint8Array([1, 0]);
  const name = (source: number): string => (own.read(0xf1, source, data) as Reading).row.fields[0]!.name;
  assert.equal(name(30), "own");
  assert.equal(name(31), "all");
  assert.equal(table.read(0xf1, 30, data), "unknown_layout");
});

test("takes the flexible layout for the value of the first field, in either byte order", () => {
  const row = (only: [number, number] | undefined, name: string, endian?: "big"): MessageRow =>
    ({ ...rows.find((one) => one.id === 0xf1)!, size: 3,
       fields: [{ name: "kind", type: "u8", offset: 0, scale: 1, ...(only && { only }) }, { name, type: "u16", offset: 1, scale: 1, ...(endian && { endian }) }] });
  const table = new MessageTable([row(undefined, "any"), row([3, 3], "three", "big")]);
  const value = (kind: number): unknown => {
    const reading = table.read(0xf1, 30, Uint8Array.of(kind, 1, 2)) as Reading;
    return [reading.row.fields[1]!.name, reading.value(reading.row.fields[1]!)];
  };
  assert.deepEqual(value(3), ["three", 0x0102]);
  assert.deepEqual(value(4), ["any", 0x0201]);
  assert.equal(new MessageTable([row([3, 3], "three")]).read(0xf1, 30, Uint8Array.of(4, 1, 2)), "unknown_layout");
});

test("reads text as GBK where it is no UTF-8, and never beyond its NUL", () => {
  assert.equal(textOf(new Uint8Array([0xc4, 0xe3, 0xba, 0xc3])), "你好");
  assert.equal(textOf(new TextEncoder().encode("你好")), "你好");
  assert.equal(textOf(new Uint8Array([65, 0, 66])), "A");
});

test("a text that is cut inside a character loses that character alone", () => {
  assert.equal(textOf(new Uint8Array([0xc4, 0xe3, 0xba, 0xc3, 0xc4])), "你好");
  assert.equal(textOf(new TextEncoder().encode("你好").subarray(0, 5)), "你");
  assert.equal(textOf(new TextEncoder().encode("A你").subarray(0, 2)), "A");
});

test("a sender that has sent a text in GBK is read as GBK from then on", () => {
  const text = (bytes: number[]): unknown => (table.read(0xa0, 77, new Uint8Array([0, ...bytes])) as Reading).get("str");
  assert.equal(text([0xc4, 0xa3]), "ģ"); // valid in both
  assert.equal(text([0xc4, 0xe3, 0xba, 0xc3]), "你好");
  assert.equal(text([0xc4, 0xa3]), "模");
});
