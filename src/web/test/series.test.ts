import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { test } from "node:test";
import { ChartData } from "../src/live/chart_data";
import { columnTimes, csvOf, envelope, Series } from "../src/live/series";
import { drawColumns } from "../src/parts/plot";
import { MessageTable, type MessageRow } from "../src/protocol/table";

test("keeps ten minutes at a thousand a second in bounded memory, with every peak of what is new and old", () => {
  const series = new Series();
  for (let i = 0; i < 600_000; ++i) series.push(i / 1000, i === 100_000 ? 99 : i === 599_000 ? -99 : Math.sin(i));
  assert.ok(series.length <= 1 << 17, String(series.length));
  const drawn: (number | null)[] = [];
  envelope(series, 0, 600, 1000, drawn);
  assert.equal(Math.max(...drawn.map((v) => v ?? 0)), 99);
  assert.equal(Math.min(...drawn.map((v) => v ?? 0)), -99);
});

test("forgets what is older than ten minutes, and takes no time that runs backwards", () => {
  const series = new Series();
  for (let i = 0; i < 2000; ++i) series.push(i, i);
  assert.equal(series.time(0), 1399);
  series.push(5, 5);
  assert.equal(series.lastTime(), 1999);
});

test("draws the smallest and the largest of each column, in their order", () => {
  const series = new Series();
  for (const [time, value] of [[0.1, 5], [0.2, 1], [0.3, 3], [2.5, 7]] as const) series.push(time, value);
  const drawn: (number | null)[] = [], times: number[] = [];
  envelope(series, 0, 4, 4, drawn);
  columnTimes(0, 4, 4, times);
  assert.deepEqual(drawn, [5, 1, null, null, 7, 7, null, null]);
  assert.deepEqual(times.slice(0, 2), [0.25, 0.75]);
});

test("a curve begins with the first value that is in the range, and ends where values were missed", () => {
  const series = new Series(), drawn: (number | null)[] = [];
  for (const [time, value] of [[-3, 50], [1, 1], [2, 2], [2, Number.NaN], [6, 6]] as const) series.push(time, value);
  envelope(series, 0, 8, 8, drawn);
  assert.deepEqual(drawn.slice(0, 8), [null, null, 1, 1, 2, 2, Number.NaN, null]);
  assert.deepEqual(drawn.slice(12), [6, 6, null, null]);
});

test("knows the value at a time, where one is near", () => {
  const series = new Series();
  series.push(10, 1);
  series.push(11, 2);
  assert.equal(series.before(10.5), 1);
  assert.equal(series.before(11), 2);
  assert.equal(series.before(9), undefined);
  assert.equal(series.before(17), undefined);
});

test("writes a table with a row for each moment", () => {
  const a = new Series(), b = new Series();
  a.push(1, 0.5); a.push(2, Number.NaN);
  b.push(1, 7); b.push(3, 8);
  assert.equal(csvOf([{ label: 'a, "x"', series: a }, { label: "b", series: b }], 0, 3), 'time,"a, ""x""",b\n1.000000,0.5,7\n2.000000,,\n3.000000,,8\n');
});

test("takes the chosen fields out of the frames, by the gateway's steady clock", () => {
  const rows = JSON.parse(readFileSync(join(import.meta.dirname, "messages.json"), "utf8")) as MessageRow[];
  const data = new ChartData(new MessageTable(rows), String);
  data.add({ from: 220, id: 3, field: "pit" });
  data.add({ from: 220, id: 3, field: "pit" });
  const frame = new Uint8Array([0, 0, 0x29, 0xee, 0, 0, 1]);
  const record = { link: 0, channel: 0, direction: "in" as const, cause: 0, from: 220, to: 255, id: 3, data: frame };
  data.take({ ...record, time: 1000, boot: 50 });
  data.take({ ...record, time: 5000, boot: 51 });
  assert.equal(data.lines.length, 1);
  const { series } = data.lines[0]!;
  assert.deepEqual([series.time(0), series.time(1), series.value(0)], [1000, 1001, -45.67]);
  assert.ok(data.heard.has(220 * 256 + 3));
});

/** The height of the highest bar, and the number of lines drawn across gaps, in a drawing of 360 pixels from -180 to 180. */
function drawn(unit: string, values: (number | null)[]): { highest: number; lines: number } {
  const found = { highest: 0, lines: 0 };
  Object.assign(globalThis, { devicePixelRatio: 1 });
  const nothing = (): void => undefined;
  const ctx = { save: nothing, beginPath: nothing, rect: nothing, clip: nothing, moveTo: nothing, stroke: nothing, restore: nothing,
    fillRect: (_: number, __: number, ___: number, height: number) => (found.highest = Math.max(found.highest, height)), lineTo: () => ++found.lines };
  const plot = { ctx, bbox: { left: 0, top: 0, width: values.length, height: 360 }, scales: { x: { min: 0, max: values.length }, ["y" + unit]: { min: -180, max: 180 } }, data: [values.map((_, i) => i)] };
  drawColumns(plot as never, values, unit, "");
  return found;
}

test("joins nothing where an angle goes over its end", () => {
  const apart = [178, 179, -179, -178], inOne = [177, 178, 179, -179, -178, -177], overGap = [178, 179, null, null, -179, -178];
  for (const values of [apart, inOne, overGap]) assert.ok(drawn("°", values).highest < 4, String(values));
  assert.equal(drawn("°", overGap).lines, 0);
  assert.equal(drawn("cm", apart).highest, 358, "what is no angle jumps");
  assert.equal(drawn("cm", overGap).lines, 1);
  assert.equal(drawn("°", [0, 170]).highest, 170);
});
