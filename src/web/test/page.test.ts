import assert from "node:assert/strict";
import { test } from "node:test";
import { bytesText, digitsOf, duration, fixed, shortNumber, valueText } from "../src/format";
import { frameOf } from "../src/parts/frame_of";
import { gridStep, type Point } from "../src/parts/ground";
import { addPlace, addPoint, clearTracks, earthTrackOf } from "../src/parts/tracks";
import { changesOf, fileOf, isSame, keyed, strangerIn, valuesIn } from "../src/parts/parameter_set";
import { pinnedOf, type Command } from "../src/live/device";
import type { Link, Route } from "../src/live/gateway";
import { faultsOf, questionOf, type KeptLast, type RunningRecording } from "../src/live/recordings";
import { replayedDevices } from "../src/live/replayed";
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
  assert.deepEqual([fixed(-0.04, 1), fixed(-0.06, 1), fixed(-0.4, 0)], ["0.0", "-0.1", "0"]);
  assert.equal(duration(3725), "1 h 2 min");
  assert.deepEqual([0, 999, 1000, 12_345, 9_950_000, 2e9, 3e15].map(bytesText), ["0 B", "999 B", "1.0 kB", "12 kB", "9.9 MB", "2.0 GB", "3000 TB"]);
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

test("draws a grid that can be read at every scale", () => {
  for (const scale of [0.002, 0.013, 0.05, 0.3, 7, 100]) {
    const pixels = gridStep(scale) / scale;
    assert.ok(pixels >= 45 && pixels < 120, `${scale}: ${pixels}`);
  }
});

test("keeps the way of a long flight in a bounded track", () => {
  const track: Point[] = [];
  for (let i = 0; i < 20000; ++i) addPoint(track, { x: i, y: 0 });
  assert.ok(track.length <= 6000);
  assert.equal(track[track.length - 1]!.x, 19999);
  addPoint(track, { x: 19999.01, y: 0 });
  assert.equal(track[track.length - 1]!.x, 19999, "too near to be another");
});

test("lays what satellites tell on flat ground, and begins anew on another continent", () => {
  addPlace(220, { lng: 116.3, lat: 39.9 });
  addPlace(220, { lng: 116.3, lat: 39.901 });
  const track = earthTrackOf(220)!;
  assert.equal(track.points.length, 2);
  assert.ok(Math.abs(track.points[1]!.x - 111.3) < 0.1 && Math.abs(track.points[1]!.y) < 1e-9);
  addPlace(220, { lng: 2.3, lat: 48.8 });
  assert.deepEqual(earthTrackOf(220)!.points.map((point) => Math.hypot(point.x, point.y)), [0]);
  clearTracks(220);
  assert.equal(earthTrackOf(220)!.points.length, 0);
});

test("asks for a recording as it was typed, or says which field can not be meant", () => {
  const wishes = { name: "", format: "pcapng", direction: ["in"], id: "", from: "", to: "", link: "", limit: "", seconds: "" };
  assert.deepEqual(questionOf(wishes), { body: { format: "pcapng", direction: "in" } });
  assert.deepEqual(questionOf({ ...wishes, name: " flight ", direction: ["in", "out"], id: "euler, 0x30", from: "220", limit: "euler=10 0x01=2.5", seconds: "60" }), {
    body: { name: "flight", format: "pcapng", direction: "in,out", id: "euler,0x30", from: "220", limit: { euler: 10, "0x01": 2.5 }, seconds: 60 },
  });
  for (const name of [".hidden", "a/b", "..", "a b", "飞行", "x".repeat(101)]) assert.deepEqual(questionOf({ ...wishes, name }), { fault: "name" }, name);
  for (const limit of ["euler", "euler=", "=5", "euler=-1"]) assert.deepEqual(questionOf({ ...wishes, limit }), { fault: "limit" }, limit);
  for (const seconds of ["soon", "0", "-5"]) assert.deepEqual(questionOf({ ...wishes, seconds }), { fault: "seconds" }, seconds);
});

test("who is in a recording alone is told from who is there, and hosts are no devices", () => {
  const link = (name: string, ...addresses: string[]): Link => ({ name, replayed: addresses.map((address) => ({ address, who: "" })) }) as Link;
  const route = (address: string): Route => ({ address, who: "", links: ["fc"], via: "learned" });
  const of = (links: Link[], routes: Route[]): [number, string][] => [...replayedDevices({ links, routes })];
  assert.deepEqual([...replayedDevices(undefined)], []);
  assert.deepEqual(of([{ name: "old" } as Link], [route("0xDC")]), []);
  assert.deepEqual(of([link("flight", "0xDC", "0x1E", "0xFE", "0xD2"), link("other", "0xDC", "0x30")], [route("0x1E")]), [[0xdc, "flight"], [0x30, "other"]]);
});

test("tells which recordings fail, and nothing where none does or nothing records", () => {
  const running = (name: string, error: string): RunningRecording => ({ name, error, by: "configuration", file: "", files: 0, format: "pcapng", frames: 0, bytes: 0, not_written: 0, since: 0, seconds: 0, ends_in_s: null });
  const last = (error: string): KeptLast => ({ seconds: 60, held_s: 1, frames: 1, bytes: 1, saved: 0, skipped: 0, last: "", error });
  assert.deepEqual(faultsOf(undefined), []);
  assert.deepEqual(faultsOf(null), []);
  assert.deepEqual(faultsOf({ running: [running("a", "")], keep_last: last("") }).map(({ name, error }) => ({ name, error })), []);
  assert.deepEqual(faultsOf({ running: [running("a", ""), running("b", "/rec: Read-only file system")], keep_last: null }).map(({ name, error }) => ({ name, error })), [{ name: "b", error: "/rec: Read-only file system" }]);
  assert.deepEqual(faultsOf({ running: [], keep_last: last("no room") }).map(({ name, error }) => ({ name, error })), [{ name: "", error: "no room" }]);
});

test("pins what ends a flight, where it wants no values", () => {
  const command = (name: string, values: string[] = []): Command => ({ id: 0, name, values });
  assert.deepEqual(pinnedOf([command("LAND"), command("Lock"), command("UNLOCK")]), { land: command("LAND"), lock: command("Lock") });
  assert.equal(pinnedOf([command("一键降落")]).land?.name, "一键降落");
  assert.deepEqual(pinnedOf([command("LAND", ["u8"]), command("ISLAND"), command("BLOCK")]), { land: undefined, lock: undefined });
});

const parameters = keyed([
  { id: 0, name: "GAIN", type: "f32", value: 0.1 },
  { id: 1, name: "BIG", type: "u64", value: "18446744073709551615" },
  { id: 2, name: "NAME", type: "string", value: "a" },
  { id: 3, name: "N", type: "u8", value: 5 },
]);

test("writes only what differs, however the same value is written", () => {
  assert.deepEqual(changesOf(parameters, { GAIN: "0.10", BIG: "18446744073709551615", NAME: "a", N: "0x05" }), {});
  assert.deepEqual(changesOf(parameters, { GAIN: "0.2", BIG: "18446744073709551614", NAME: "a ", N: "6", GONE: "1" }), { GAIN: "0.2", BIG: "18446744073709551614", NAME: "a ", N: "6" });
  assert.equal(isSame(5, "", "u8"), false);
  assert.equal(isSame("nan", "nan", "f32"), true);
});

test("a file of parameters comes back with every digit", () => {
  const text = fileOf({ address: "0xDC", name: "SimFC", sw: 100 }, parameters);
  assert.deepEqual(changesOf(parameters, valuesIn(text)!), {});
  assert.deepEqual(valuesIn('{"parameters": {"BIG": 18446744073709551615}}'), { BIG: "18446744073709551615" });
  const device = { address: "0xDC", name: "SimFC" };
  assert.equal(strangerIn(text, device), undefined);
  assert.equal(strangerIn('{"name": "SimIMU", "device": "0xDC"}', device), "SimIMU");
  assert.equal(strangerIn('{"name": "SimFC", "device": "0x1E"}', device), undefined, "the same kind, moved to another address");
  assert.equal(strangerIn('{"device": "0x1E"}', device), "0x1E");
  for (const silent of ["", "null", "[]", '{"device": "0xdc"}', '{"parameters": {}}']) assert.equal(strangerIn(silent, device), undefined, silent);
  for (const bad of ["", "[]", "7", "null", '{"parameters": [1]}']) assert.equal(valuesIn(bad), undefined, bad);
});

test("the names of parameters are the device's own choice", () => {
  const parameters = keyed(["constructor", "toString", "__proto__", "hasOwnProperty"].map((name, id) => ({ id, name, type: "f32", value: 1 })));
  assert.deepEqual(changesOf(parameters, {}), {});
  const typed = Object.fromEntries(parameters.map((one) => [one.name!, "2"]));
  assert.deepEqual(Object.entries(changesOf(parameters, typed)), parameters.map((one) => [one.name!, "2"]));
  assert.deepEqual(valuesIn(fileOf({ address: "0x1E" }, parameters)), Object.fromEntries(parameters.map((one) => [one.name!, "1"])));
});

test("several parameters of one name, or of none, are told apart by their numbers, as in files of anoctl", () => {
  const parameters = keyed([{ id: 0, name: "GAIN", value: 1 }, { id: 1, name: "ONCE", value: 2 }, { id: 2, name: "GAIN", value: 3 }, { id: 3, name: "", value: 4 }, { id: 4, value: 5 }]);
  assert.deepEqual(valuesIn(fileOf({ address: "0x1E" }, parameters)), { "GAIN#0": "1", ONCE: "2", "GAIN#2": "3", "#3": "4", "#4": "5" });
  assert.deepEqual(changesOf(parameters, { "GAIN#2": "7" }), { "GAIN#2": "7" });
  assert.equal(keyed([{ id: 7, name: "" }])[0]!.key, "#7");
});

test("a value that is no number is not the same as any that is typed", () => {
  const parameters = keyed([{ id: 0, name: "GAIN", type: "f32", value: "nan" }, { id: 1, name: "FAR", type: "f32", value: 1e38 }, { id: 2, name: "END", type: "f32", value: "-inf" }]);
  assert.deepEqual(changesOf(parameters, { GAIN: "0", FAR: "1e38", END: "-inf" }), { GAIN: "0" });
});
