import assert from "node:assert/strict";
import { test } from "node:test";
import { alarmsIn, bodyOf, limitsIn, type Limit } from "../src/live/limits";
import { Presence } from "../src/live/presence";
import { heardDevicesIn } from "../src/live/heard_devices";
import { faultOf } from "../src/parts/parameter_set";
import { isolated, visible } from "../src/visible";

/** Frames of `id` every `period` seconds. */
const send = (presence: Presence, id: number, period: number, from: number, to: number): void => {
  for (let now = from; now <= to + 1e-9; now += period) presence.hear(id, now);
};

test("a device is lost within 1 s and two periods, and not before a period has passed", () => {
  for (const period of [0.1, 0.5, 1, 3]) {
    const presence = new Presence();
    send(presence, 0x06, period, 0, 10 * period);
    const last = presence.heardAt;
    assert.equal(presence.isLost(last + period, 0), false, `${period}`);
    assert.equal(presence.isLost(last + 0.9 + 2 * period, 0), true, `${period}`);
    assert.equal(presence.isLost(last + 0.9 + 2 * period, last + 0.9 + 2 * period), false, "nobody listened in between");
  }
});

test("what only answers, logs at times, or sends rarely is never lost", () => {
  const presence = new Presence();
  send(presence, 0xe1, 0.01, 0, 1);
  for (const from of [0, 10, 20]) send(presence, 0xa0, 0.01, from, from + 4);
  send(presence, 0x06, 20, 0, 200);
  assert.equal(presence.isLost(1000, 0), false);
  assert.equal(new Presence().isLost(1000, 0), false);
});

test("what only logs, all the time, is lost within 1 s and two periods; so is a vehicle of which only its log is left", () => {
  for (const id of [0xa0, 0xa1])
    for (const period of [0.05, 0.2, 1, 3])
      for (const telemetry of [false, true]) {
        const presence = new Presence(), until = telemetry ? 5 + 4 * period : 15;
        if (telemetry) send(presence, 0x06, 0.1, 0, 5);
        send(presence, id, period, telemetry ? 5 + period : 0, until);
        const last = presence.heardAt, what = `${id} ${period} ${telemetry}`;
        assert.equal(presence.isLost(last + 0.7 + period, 0), false, what);
        assert.equal(presence.isLost(last + 0.9 + 2 * period, 0), true, what);
      }
});

test("lines that come together make no vehicle lost whose telemetry comes", () => {
  const presence = new Presence();
  send(presence, 0x06, 2, 0, 20);
  send(presence, 0xa0, 0.01, 20, 20.5);
  assert.equal(presence.isLost(22, 0), false);
  assert.equal(presence.isLost(25, 0), true);
});

test("a device that others know to be lost is lost until it is heard again", () => {
  const unseen = new Presence();
  unseen.wasLost(100);
  assert.equal(unseen.heardAt, 100);
  assert.equal(unseen.isLost(110, 105), true);
  unseen.wasLost(100.1); // reported again
  assert.equal(unseen.heardAt, 100);
  unseen.hear(0x06, 111);
  assert.equal(unseen.isLost(111, 105), false);
  unseen.wasLost(100.1); // dated before it was heard
  assert.equal(unseen.isLost(111, 105), false);
  const brief = new Presence(); // too few frames to determine its period
  brief.hear(0x06, 50);
  assert.equal(brief.isLost(60, 0), false);
  brief.wasLost(50.2);
  assert.equal(brief.isLost(60, 0), true);
  assert.equal(brief.heardAt, 50);
  brief.isBack(); // while this page received nothing
  assert.equal(brief.isLost(61, 61), false);
  brief.wasLost(70);
  assert.deepEqual([brief.isLost(71, 0), brief.heardAt], [true, 70]);
});

test("a device that is heard where it is not known to be the same stays lost, as the gateway tells", () => {
  const presence = new Presence();
  send(presence, 0x06, 0.1, 0, 10);
  const last = presence.heardAt;
  send(presence, 0x06, 0.1, 20, 24); // an unknown device
  assert.equal(presence.isLost(24, 0), false);
  presence.wasLost(last + 0.1, "radio");
  assert.deepEqual([presence.isLost(24, 0), presence.elsewhere], [true, "radio"]);
  const at = presence.heardAt;
  send(presence, 0x06, 0.1, 24, 30);
  presence.wasLost(last - 0.1, "radio");
  assert.deepEqual([presence.isLost(30, 0), presence.heardAt], [true, at]);
  presence.isBack();
  send(presence, 0x06, 0.1, 30, 31);
  assert.equal(presence.isLost(31, 0), false);
  assert.deepEqual(heardDevicesIn({ devices: [{ address: "0x32", lost: true, age: 1, elsewhere: "radio" }] }, 10), [{ device: 50, isLost: true, heardAt: 9, flag: undefined, elsewhere: "radio" }]);
});

test("the devices of the gateway are read with the time when they were heard; what is none is left out", () => {
  const lost = { address: "0x32", lost: true, name: "Falcon", age: 2.5, sflag: 2 }, heard = { address: "0xDC", lost: false };
  assert.deepEqual(heardDevicesIn({ devices: [lost, heard] }, 100), [{ device: 50, isLost: true, heardAt: 97.5, flag: 2 }, { device: 220, isLost: false, heardAt: 100, flag: undefined }]);
  for (const wrong of [{ address: "x" }, { address: undefined }, { lost: 1 }, { age: "2" }]) assert.deepEqual(heardDevicesIn({ devices: [{ ...lost, ...wrong }] }, 0), []);
  for (const other of [undefined, null, {}, { devices: 1 }, { devices: [null, 1] }]) assert.deepEqual(heardDevicesIn(other, 0), []);
});

test("a message that a device stops sending, or sends at another rate, makes it no lost one", () => {
  const presence = new Presence();
  send(presence, 0x03, 0.1, 0, 5);
  send(presence, 0x06, 1, 0, 5);
  let lost = 0;
  for (let now = 6; now < 30; ++now) {
    for (let at = now - 0.95; at < now; at += 0.05) lost += Number(at > 8 && presence.isLost(at, 0));
    presence.hear(0x06, now);
  }
  assert.equal(lost, 0);
});

const cell: Limit = { key: "power.voltage below", field: "power.voltage", side: "below", amber: 3.6, red: 3.4, cells: 4, for_s: 2 };

test("what the gateway finds in alarm is read with the time of its values; what is none is left out", () => {
  const one = { device: "0x34", name: "Owl", field: "power.voltage", side: "below", level: "red", value: 3.3, limit: 3.4, unit: "V", cells: 4, beyond_s: 2, age_s: 1.5 };
  assert.deepEqual(alarmsIn({ alarms: [one] }, 100), [{ device: 0x34, limit: { key: "power.voltage below", field: "power.voltage", side: "below", cells: 4 }, level: "red", value: 3.3, edge: 3.4, heardAt: 98.5 }]);
  for (const wrong of [{ level: "none" }, { side: "left" }, { value: "3" }, { device: "x" }, { field: 1 }]) assert.deepEqual(alarmsIn({ alarms: [{ ...one, ...wrong }] }, 100), []);
  for (const other of [undefined, null, {}, { alarms: 1 }, { alarms: [null, 1] }]) assert.deepEqual(alarmsIn(other, 0), []);
});

test("limits are read as the gateway has them, and written so", () => {
  const body = { limits: [{ field: "power.voltage", side: "below", amber: 3.6, red: 3.4, cells: 4, for_s: 2 }] };
  assert.deepEqual(limitsIn(body), [cell]);
  assert.deepEqual(bodyOf([cell]), body);
  for (const other of [undefined, null, {}, { limits: 1 }, { limits: [null, 1, { field: 1, side: "below" }, { field: "a.b", side: "left" }] }]) assert.deepEqual(limitsIn(other), []);
});

test("a value is judged by the type that the device declares", () => {
  const fault = (type: string, text: string, more = {}): string | undefined => faultOf({ id: 1, type, ...more }, text)?.key;
  assert.deepEqual(["0", "255", "0xff", "256", "-1", "1.5", "x", ""].map((text) => fault("u8", text)), [undefined, undefined, undefined, "out_of_range", "out_of_range", "not_whole", "not_a_number", "not_a_number"]);
  assert.deepEqual(["-32768", "32767", "32768"].map((text) => fault("i16", text)), [undefined, undefined, "out_of_range"]);
  assert.deepEqual(["18446744073709551615", "18446744073709551616"].map((text) => fault("u64", text)), [undefined, "out_of_range"]);
  assert.deepEqual(["1e3", "nan", "-inf", "1,5"].map((text) => fault("f32", text)), [undefined, undefined, undefined, "not_a_number"]);
  assert.equal(fault("i16", "1.5", { mul: 10 }), undefined);
  assert.equal(fault("i16", "50", { min: 0, max: 45 }), "out_of_range");
  assert.equal(fault("string", "x"), undefined);
});

test("no character of a device is invisible or reorders others", () => {
  assert.equal(visible("a\u202eb\u200bc\u0085d\u2069e"), "a\ufffdb\ufffdc\ufffdd\ufffde");
  for (const code of [0x34f, 0x115f, 0x1160, 0x3164, 0xffa0, 0x2800]) assert.equal(visible(`a${String.fromCodePoint(code)}b`), "a\ufffdb", code.toString(16));
  assert.equal(visible("°C µ\t电池\n🚁"), "°C µ\t电池\n🚁");
  assert.equal(isolated("x\u2069y"), "\u2068x\ufffdy\u2069");
  assert.equal(isolated(""), "");
});
