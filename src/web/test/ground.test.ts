import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { test } from "node:test";
import { Pictures, pixelsOf } from "../src/live/pictures";
import { firmwareFile } from "../src/parts/firmware_file";
import { boxFaces, dot, faceNames, sphereCells, turnedUp, viewFrom } from "../src/parts/solid";
import { foreignForm, onEarth, onGround, waypointsIn, type Waypoint } from "../src/parts/waypoint_set";
import { MessageTable, Reading, type MessageRow } from "../src/protocol/table";

const table = new MessageTable(JSON.parse(readFileSync(join(import.meta.dirname, "messages.json"), "utf8")) as MessageRow[]);
const home: Waypoint = { num: 0, lng: 116.3, lat: 39.9, alt: 0, spd: 0, yaw: 0, fun: 0, cmd: [0, 0, 0, 0] };

test("lays waypoints on the ground and back", () => {
  const point = onGround(home, { lng: 116.301, lat: 39.901 });
  assert.ok(Math.abs(point.x - 111.3) < 0.1 && Math.abs(point.y + 85.4) < 0.1, JSON.stringify(point));
  const back = onEarth(home, point);
  assert.ok(Math.abs(back.lng - 116.301) < 1e-6 && Math.abs(back.lat - 39.901) < 1e-6);
});

test("knows files of waypoints from those that are none", () => {
  assert.deepEqual(waypointsIn({ waypoints: [{ num: 1, lng: 2, lat: 3 }] }), [{ ...home, num: 1, lng: 2, lat: 3 }]);
  for (const bad of [undefined, null, 5, {}, { waypoints: 5 }, { waypoints: [5] }, { waypoints: [{ num: "1" }] }]) assert.equal(waypointsIn(bad), undefined);
  assert.equal(foreignForm({ type: "FeatureCollection" }), "geojson");
  assert.equal(foreignForm({ fileType: "Plan" }), "qgc");
  assert.equal(foreignForm(null), undefined);
});

function rows(flag: number, colour: number, width: number, height: number, pixels: number[]): Reading {
  const data = new Uint8Array(17 + pixels.length);
  data.set([flag, 0, colour, width, 0, height, 0]);
  data.set(pixels, 17);
  const reading = table.read(0xb0, 220, data);
  assert.ok(reading instanceof Reading);
  return reading;
}

test("joins the rows of a picture, and ends one with a lost part when the next begins", () => {
  const pictures = new Pictures();
  assert.deepEqual(pictures.take(rows(1, 0, 2, 2, [1, 2]), 220, 0), []);
  const [whole] = pictures.take(rows(1, 0, 2, 2, [3, 4]), 220, 0.1);
  assert.deepEqual([...whole!.pixels], [1, 2, 3, 4]);
  pictures.take(rows(2, 0, 2, 2, [5, 6]), 220, 0.2);
  const [broken] = pictures.take(rows(3, 0, 2, 2, [7, 8]), 220, 0.3);
  assert.deepEqual([broken!.flag, broken!.filled], [2, 2]);
  assert.equal(pixelsOf(broken!)[4 * 2 + 3], 0, "what did not come is clear");
});

test("more rows than are missing begin another picture", () => {
  const pictures = new Pictures();
  pictures.take(rows(1, 0, 1, 3, [1, 2]), 220, 0);
  const [broken] = pictures.take(rows(1, 0, 1, 3, [3, 4]), 220, 0.1);
  assert.equal(broken!.filled, 2);
  assert.deepEqual([...pictures.take(rows(1, 0, 1, 3, [5]), 220, 0.2)[0]!.pixels], [3, 4, 5]);
});

test("refuses what is no picture, and takes no more memory than one has", () => {
  const pictures = new Pictures();
  for (const bad of [rows(1, 7, 2, 2, [1, 2]), rows(1, 0, 0, 2, [1]), rows(1, 0, 2, 2, [1]), rows(1, 0, 2, 2, [1, 2, 3, 4, 5, 6]), rows(1, 0, 2, 2, [])])
    assert.deepEqual(pictures.take(bad, 220, 0), []);
  assert.equal(pictures.refused, 5);
});

test("draws a bit a pixel from the highest on", () => {
  const [picture] = new Pictures().take(rows(1, 2, 8, 1, [0b10000001]), 220, 0);
  const pixels = pixelsOf(picture!);
  assert.deepEqual([pixels[0], pixels[4], pixels[28]], [255, 0, 255]);
});

test("turns a box so that the face that is up is up, and mirrors nothing", () => {
  for (const face of faceNames) {
    const axis = "xyz".indexOf(face[1]!), normal = [0, 0, 0];
    normal[axis] = face.startsWith("-") ? -1 : 1;
    assert.deepEqual(turnedUp(face, normal as [number, number, number]).map((n) => n + 0), [0, 0, 1], face);
    const [x, y, z] = [turnedUp(face, [1, 0, 0]), turnedUp(face, [0, 1, 0]), turnedUp(face, [0, 0, 1])];
    const cross = [x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0]] as const;
    assert.equal(dot(cross, z), 1, face);
    const seen = boxFaces(face, viewFrom(25, 30)).map((one) => one.name);
    assert.equal(seen.length, 3);
    assert.ok(seen.includes(face), face);
  }
});

test("shows each cell of the sphere from the front or from the back", () => {
  const seen = new Set([0, 180].flatMap((azimuth) => sphereCells(6, 12, viewFrom(azimuth, 0)).map((cell) => cell.index)));
  assert.ok(seen.size >= 70, String(seen.size));
});

test("reads the header of a .bia, and takes nothing else for one", () => {
  const start = new Uint8Array(100);
  start.set([0x62, 0x69, 0x61]);
  new DataView(start.buffer).setUint16(10, 205, true);
  start[20] = 7;
  assert.deepEqual(firmwareFile(start.buffer, 1100), { bytes: 1000, header: { version: 205, crc: 0, hwType: 7, hwMin: 0, hwMax: 0 } });
  assert.deepEqual(firmwareFile(start.slice(0, 50).buffer, 50), { bytes: 50 });
  assert.deepEqual(firmwareFile(new ArrayBuffer(0), 0), { bytes: 0 });
});
