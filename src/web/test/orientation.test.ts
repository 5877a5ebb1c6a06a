// One orientation of a device, for any frame.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { test } from "node:test";
import { Latest } from "../src/live/latest";
import { orientationOf } from "../src/live/orientation";
import { MessageTable, type MessageRow } from "../src/protocol/table";

const table = new MessageTable(JSON.parse(readFileSync(join(import.meta.dirname, "messages.json"), "utf8")) as MessageRow[]);

const bytes = (numbers: number[]): Uint8Array => {
  const view = new DataView(new ArrayBuffer(2 * numbers.length + 1));
  numbers.forEach((number, i) => view.setInt16(2 * i, Math.round(number), true));
  return new Uint8Array(view.buffer);
};
const euler = (roll: number, pitch: number, yaw: number): Uint8Array => bytes([100 * roll, 100 * pitch, 100 * yaw]);
const half = (degrees: number): number => (degrees * Math.PI) / 360;
const yawed = (yaw: number): Uint8Array => bytes([10000 * Math.cos(half(yaw)), 0, 0, 10000 * Math.sin(half(yaw))]);

function heard(frames: [number, Uint8Array][]): Latest {
  const latest = new Latest(table);
  for (const [id, data] of frames) latest.take({ time: 0, boot: 0, link: 0, direction: 0, cause: 0, channel: 0, from: 0xdd, to: 0xfe, id, data } as never, 100);
  return latest;
}
const anglesOf = (latest: Latest, lx: boolean): number[] => {
  const is = orientationOf(latest, 100.01, lx);
  return [is.roll, is.pitch, is.yaw].map((seen) => Math.round(seen?.value ?? Number.NaN));
};

test("Euler angles and quaternion of an LX unit are one orientation", () => {
  assert.deepEqual(anglesOf(heard([[3, euler(10, -20, 40)]]), false), [10, -20, 40]);
  assert.deepEqual(anglesOf(heard([[3, euler(10, -20, 40)]]), true), [10, 20, -40]);
  assert.deepEqual(anglesOf(heard([[4, yawed(-40)]]), true), [0, 0, -40]);
  assert.deepEqual(anglesOf(heard([[3, euler(0, 0, 40)], [4, yawed(-40)]]), true), [0, 0, -40]);
});

test("a quaternion that is none leaves the Euler angles", () => {
  assert.deepEqual(anglesOf(heard([[3, euler(1, 2, 3)], [4, bytes([0, 0, 0, 0])]]), false), [1, 2, 3]);
});

test("a frame with an unknown layout shows nothing", () => {
  assert.deepEqual(anglesOf(heard([[3, new Uint8Array(9)]]), false), [Number.NaN, Number.NaN, Number.NaN]);
  assert.deepEqual(anglesOf(heard([[3, Uint8Array.of(1, ...euler(1, 2, 3))]]), false), [1, 2, 3]);
});
