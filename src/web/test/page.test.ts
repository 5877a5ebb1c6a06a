import assert from "node:assert/strict";
import { test } from "node:test";
import { digitsOf, duration, shortNumber, valueText } from "../src/format";
import { frameOf } from "../src/parts/frame_of";
import type { MessageRow } from "../src/protocol/table";
import { hashOf, placeOf } from "../src/route";
import { words } from "../src/words";
import { causes } from "../src/words_of_gateway";

test("says everything in both languages, with the same things filled in", () => {
  const filled = (text: string): string[] => [...text.matchAll(/\{(\w+)\}/g)].map((m) => m[1]!).sort();
  for (const [key, [english, chinese]] of [...Object.entries(words), ...Object.entries(causes)]) {
    assert.ok(english && chinese, key);
    assert.deepEqual(filled(chinese), filled(english), key);
  }
});

test("knows its places by their addresses", () => {
  assert.deepEqual(placeOf("#/220/vehicle"), { page: "vehicle", device: 220 });
  assert.deepEqual(placeOf("#/frames"), { page: "frames", device: undefined });
  for (const hash of ["", "#", "#/", "#/0/x", "#/255/x", "#/1.5/x"]) assert.equal(placeOf(hash).device, undefined, hash);
  assert.equal(hashOf({ page: "vehicle", device: 220 }), "#/220/vehicle");
});

test("writes numbers with the digits that their scale has", () => {
  assert.equal(digitsOf(0.01), 2);
  assert.equal(digitsOf(1e-7), 7);
  assert.equal(digitsOf(1), 0);
  assert.equal(valueText(45.6, { name: "rol", type: "i16", offset: 0, scale: 0.01 }), "45.60");
  assert.equal(valueText(null, { name: "rol", type: "i16", offset: 0 }), "–");
  assert.equal(shortNumber(544123), "544 k");
  assert.equal(duration(3725), "1 h 2 min");
});

const row: MessageRow = {
  id: 0xe0, name: "parameter_command", title: "", layout: "action", size: 3, class: "urgent", replaces: "nothing", acknowledged: "yes",
  fields: [{ name: "cmd", type: "u8", offset: 0, only: [16, 16] }, { name: "val", type: "u16", offset: 1 }],
};

test("makes a frame of what was typed, or says which field is none", () => {
  assert.deepEqual(frameOf(row, "0xFE", "220", { val: "0xAB" }), { frame: { from: 254, to: 220, name: "parameter_command", fields: { cmd: 16, val: 171 } } });
  assert.deepEqual(frameOf(row, "254", "x", {}), { fault: "to" });
  assert.deepEqual(frameOf(row, "254", "1", { val: "five" }), { fault: "val" });
});
