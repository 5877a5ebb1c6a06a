import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { test } from "node:test";
import { CounterRates, drops, lossesByCause, lost } from "../src/live/counters";
import { askEvery, Liveness, lostAfter } from "../src/live/liveness";
import { Arrivals, Rate } from "../src/live/rate";
import { FrameRows } from "../src/live/rows";
import { takeRecords, textMessage, type FrameRecord } from "../src/protocol/records";
import { causes } from "../src/words_of_gateway";

function recordBytes(id: number, data: number[]): number[] {
  const bytes = new Uint8Array(20 + 6 + data.length + 2);
  const view = new DataView(bytes.buffer);
  view.setBigUint64(0, 1_700_000_000_500_000_000n, true);
  view.setBigUint64(8, 2_000_000_000n, true);
  bytes.set([3, 2, 5, 1, 0xab, 220, 254, id, data.length & 255, data.length >> 8, ...data], 16);
  return [...bytes];
}

test("takes many records out of one message", () => {
  const seen: FrameRecord[] = [];
  const bytes = new Uint8Array([...recordBytes(3, [1, 2]), ...recordBytes(4, [])]);
  assert.ok(takeRecords(bytes.buffer, (record) => seen.push(record)));
  assert.deepEqual(seen.map((r) => [r.id, r.from, r.to, r.link, r.direction, r.cause, r.channel, [...r.data]]), [
    [3, 220, 254, 3, "dropped", 5, 1, [1, 2]],
    [4, 220, 254, 3, "dropped", 5, 1, []],
  ]);
  assert.equal(seen[0]!.time, 1_700_000_000.5);
  assert.equal(seen[0]!.boot, 2);
});

test("stops at a record that is cut off, wherever", () => {
  const whole = recordBytes(3, [1, 2]);
  for (let size = 1; size < whole.length; ++size) assert.equal(takeRecords(new Uint8Array(whole.slice(0, size)).buffer, () => assert.fail()), false);
});

test("tells tables and losses from what is neither", () => {
  assert.deepEqual(textMessage('{"lost": {"euler": 3}, "since_ms": 5}'), { lost: { euler: 3 }, since_ms: 5 });
  assert.ok("causes" in textMessage('{"links": [], "channels": [], "causes": []}')!);
  for (const text of ["", "null", "7", "{}", "{"]) assert.equal(textMessage(text), undefined);
});

test("counts how often something comes, and sees that it is late", () => {
  const rate = new Rate();
  for (let i = 0; i <= 300; ++i) rate.add(i / 50);
  assert.ok(Math.abs(rate.perSecond(6) - 50) < 0.5, String(rate.perSecond(6)));
  assert.equal(rate.isLate(6.4), false);
  assert.equal(rate.isLate(6.6), true);
  const slow = new Rate();
  for (let i = 0; i < 5; ++i) slow.add(i * 5);
  assert.ok(Math.abs(slow.perSecond(21) - 0.2) < 0.01, String(slow.perSecond(21)));
  assert.equal(slow.isLate(30), false);
  assert.equal(slow.isLate(40), true);
});

test("a gateway is lost when it was silent for so long that people see it within a second, on a slow line as well", () => {
  const alive = new Liveness();
  assert.equal(alive.contact(0), "never");
  assert.equal(alive.ask(0, 1000), 1);
  assert.equal(alive.ask(399, 1000), undefined);
  assert.equal(alive.ask(400, 1000), 2);
  assert.equal(alive.ask(800, 1000), 3);
  assert.equal(alive.ask(1200, 1000), undefined, "three are on their way");
  alive.heard(1250);
  alive.ended(1);
  assert.equal(alive.contact(1250), "live");
  assert.equal(alive.ask(1649, 1000), undefined, "it was just heard");
  assert.equal(alive.ask(1650, 1000), 4);
  assert.equal(alive.lostAt(), 1250 + lostAfter);
  assert.equal(alive.contact(1250 + lostAfter - 1), "live");
  assert.equal(alive.contact(1250 + lostAfter), "lost");
  const drawing = 3 * (1000 / 60); // a timer that is late by one frame, and two frames until it is shown
  assert.ok(lostAfter + drawing < 1000);
  alive.restart(9000);
  assert.equal(alive.contact(9500), "live", "what was hidden asked nothing");
  assert.equal(alive.contact(9000 + lostAfter), "lost");
  alive.restart(20000, true);
  assert.equal(alive.contact(20001), "lost", "a hidden page knew it");
  alive.heard(20002);
  assert.equal(alive.contact(20002), "live");
});

test("who is heard anyway is asked for no more than what the answer says; who is silent, soon", () => {
  for (const [atLeastEvery, expected] of [[1000, [0, 1000, 2000, 3000, 4000]], [3000, [0, 3000]]] as const) {
    const alive = new Liveness();
    const asked: number[] = [];
    for (let now = 0; now < 4500; now += 40) {
      const question = alive.ask(now, atLeastEvery);
      if (question !== undefined) (asked.push(now), alive.ended(question));
      alive.heard(now);
    }
    assert.deepEqual(asked, expected);
    assert.equal(alive.ask(4480 + askEvery - 1, atLeastEvery), undefined);
    assert.notEqual(alive.ask(4480 + askEvery, atLeastEvery), undefined, "half a second is left for the answer");
  }
  assert.ok(askEvery < lostAfter / 2);
});

test("only what did not arrive is a loss: every cause of the gateway's, and nothing else that a link tells in numbers", () => {
  const header = readFileSync(join(import.meta.dirname, "../../../include/gateway/counters.hpp"), "utf8");
  const counted = [...header.matchAll(/^ {4}\{"(\w+)", &(?:Receive|Send)Counters::/gm)].map((row) => row[1]!);
  assert.ok(counted.length > 15);
  const carried = new Set(["frames_in", "bytes_in", "skipped_bytes", "frames_out", "bytes_out", "empty_out", "flush_bytes"]);
  const link = Object.fromEntries([...counted, "waiting", "id", "since_s", "position_s", "kept_back_commands", "kept_back_of_hosts", "paced", "baud", "port", "kernel_drops"].map((name) => [name, 7]));
  assert.deepEqual(drops(link).map(([name]) => name).sort(), [...counted.filter((name) => !carried.has(name)), "kernel_drops"].sort());
  for (const [name] of drops(link)) assert.ok(name in causes, `${name} has words`);
  assert.deepEqual(drops({ stale: 0, limited: 3, queue_full: 9, denied_in: "5" }), [["queue_full", 9], ["limited", 3]]);
});

test("frames without a counterpart in V7 are losses by cause, each counted once", () => {
  const header = readFileSync(join(import.meta.dirname, "../../../include/gateway/v7_translation.hpp"), "utf8");
  const rows = [...header.matchAll(/^ {4}\{"(v7_\w+)", &V7Counters::\w+, "[^"]*"(, false)?\},/gm)];
  assert.ok(rows.length > 15);
  const dropped = rows.filter((row) => row[2] === undefined).map((row) => row[1]!);
  const link = Object.fromEntries(rows.map((row) => [row[1]!, 7]));
  assert.deepEqual(drops(link).map(([name]) => name).sort(), dropped.sort());
  for (const name of dropped) assert.ok(name in causes, `${name} has words`);
  assert.deepEqual(drops({ denied_out: 9, v7_down_erase: 2, v7_down_own_sensor: 3, v7_up_unmatched: 1 }),
    [["denied_out", 4], ["v7_down_own_sensor", 3], ["v7_down_erase", 2], ["v7_up_unmatched", 1]]);
});

test("frames without a receiver are counted of the links that should have one", () => {
  const fc = { name: "fc", no_route: 7, hint_id: "" }, replay = { name: "flight", no_route: 100, replayed: [] }, alone = { name: "imu", no_route: 50, stale: 1, hint_id: "no_host_takes" };
  const losses = lossesByCause([fc, replay, alone]);
  assert.deepEqual(losses.get("no_route"), { total: 7, of: [fc] });
  assert.deepEqual(losses.get("stale"), { total: 1, of: [alone] });
});

test("a frame to nobody is no loss where no host is, or where a recording speaks", () => {
  const counted = { no_route: 7, stale: 2 };
  assert.deepEqual(lost({ ...counted, hint_id: "" }), [["no_route", 7], ["stale", 2]]);
  assert.deepEqual(lost({ ...counted, hint_id: "hosts_link_down" }), [["no_route", 7], ["stale", 2]]);
  assert.deepEqual(lost({ ...counted, hint_id: "no_host_takes" }), [["stale", 2]]);
  assert.deepEqual(lost({ ...counted, hint_id: "recording_ended", replayed: [] }), [["stale", 2]]);
});

test("rates of counters outlive a gateway that begins anew", () => {
  const rates = new CounterRates();
  rates.look("fc", { frames_in: 100 }, 10);
  assert.equal(rates.perSecond("fc", "frames_in"), undefined);
  rates.look("fc", { frames_in: 150 }, 10.1);
  rates.look("fc", { frames_in: 200 }, 11);
  assert.equal(rates.perSecond("fc", "frames_in"), 100);
  rates.look("fc", { frames_in: 5 }, 12);
  assert.equal(rates.perSecond("fc", "frames_in"), 0);
});

test("what was dropped is told apart from what was counted", () => {
  assert.deepEqual(drops({ frames_in: 5, link_down: 2, stale: 7, waiting: 1, looped: 0, name: "x" }), [["stale", 7], ["link_down", 2]]);
});

test("keeps a row for each link, sender and message, and no more than a page can show", () => {
  const rows = new FrameRows();
  const record = (from: number, id: number, link = 0): FrameRecord =>
    ({ time: 1, boot: 1, link, channel: 0, direction: "in", cause: 0, from, to: 255, id, data: new Uint8Array([1]) });
  rows.add(record(1, 3), 0);
  rows.add(record(1, 3), 0.1);
  rows.add(record(1, 3, 1), 0.1);
  assert.deepEqual(rows.sorted().map((row) => [row.link, row.count]), [[0, 2], [1, 1]]);
  for (let from = 0; from < 254; ++from) for (let id = 0; id < 256; ++id) rows.add(record(from, id), 1);
  assert.equal(rows.sorted().length, 2000);
  assert.ok(rows.left_out > 0);
});

test("what comes in one message was seen one after the other, and a message may be late", () => {
  const arrivals = new Arrivals(), rate = new Rate();
  let message = 0;
  for (let k = 0; k < 100; ++k) { // 100 a second, in messages every 50 ms
    const now = 500 + k * 0.05 + (k % 7 === 3 ? 0.03 : 0.002);
    arrivals.begin();
    const seen = Array.from({ length: 5 }, () => 7000 + message++ * 0.01);
    arrivals.at(seen[4]!, now);
    for (const one of seen) {
      const at = arrivals.at(one, now);
      assert.ok(at <= now + 1e-9 && at > now - 0.1, `${k}: ${now - at} s ago`);
      rate.add(at);
    }
    if (k > 2) assert.ok(Math.abs(rate.perSecond(now) - 100) < 8, `${k}: ${rate.perSecond(now)}`);
  }
  assert.ok(Math.abs(rate.perSecond(504.952) - 100) < 1, String(rate.perSecond(504.952)));
});
