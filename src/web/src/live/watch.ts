// Watches all devices on every page: lost devices, their state, red log lines, and the alarms of the gateway.
import { ask } from "../api";
import { entryOf } from "../entries";
import { alarmsOfGateway, followAlarms } from "./alarm_feed";
import { remember, remembered } from "../kept";
import { contact, devices, seconds, status, table } from "./gateway";
import type { Alarm } from "./limits";
import { watchStream } from "./frames";
import { Presence } from "./presence";
import { replayedDevices } from "./replayed";
import { Store } from "./store";
import type { HeardDevice } from "./heard_devices";
import { isHost, Reading } from "../protocol/table";
import type { FrameRecord } from "../protocol/records";
import { alarmSound } from "../parts/sound";

const samples = 20; // maximum per second for each message
const lookEvery = 50; // milliseconds
const askRedAfter = 200; // milliseconds
const soundEvery = 4; // seconds, until the user silences it

interface RedLine {
  device: number;
  text: string;
  count: number; // of this device, since the last dismissal in this browser
}

class Watched {
  readonly presence = new Presence();
  flag: number | undefined; // sflag of `mode`: 0 locked, 1 unlocked, 2 airborne
  dismissedAt: number | undefined; // time of the last frame when the loss was dismissed
}

const all = new Map<number, Watched>();
let since = Number.POSITIVE_INFINITY; // when the page began to receive frames; a hidden page receives none

/** Devices that sent telemetry and are lost. */
export const lostDevices = new Store<ReadonlySet<number>>(new Set());
/** Lost devices whose loss was not dismissed. */
export const lostNews = new Store<ReadonlySet<number>>(new Set());
const keep = (store: Store<ReadonlySet<number>>, now: number[]): void => {
  if (now.length !== store.get().size || now.some((device) => !store.get().has(device))) store.set(new Set(now));
};
export const alarms = new Store<readonly Alarm[]>([]);
export const redLines = new Store<readonly RedLine[]>([]);
/** Reasons for sound that the user has silenced: "lost 220", "red 220 …". */
const silenced = new Set<string>();
export const sounding = new Store<readonly string[]>([]);

const watched = (device: number): Watched => entryOf(all, device, () => new Watched());

/** Seconds since the last frame of the device; undefined: none while this page was open. */
export function ageOf(device: number, now = seconds()): number | undefined {
  const at = all.get(device)?.presence.heardAt ?? Number.NEGATIVE_INFINITY;
  return at === Number.NEGATIVE_INFINITY ? undefined : Math.max(0, now - at);
}
/** Rate of the frames that the page receives: at most `samples` per second of each message. */
export const seenRateOf = (device: number): number | undefined => all.get(device)?.presence.rate(seconds());
/** The last state of a vehicle, and the time of its last frame. */
export function lastStateOf(device: number): { flag: number; at: number } | undefined {
  const one = all.get(device);
  return one?.flag === undefined ? undefined : { flag: one.flag, at: one.presence.heardAt };
}
export const elsewhereOf = (device: number): string | undefined => all.get(device)?.presence.elsewhere;
export const flagOf = (device: number): number | undefined => all.get(device)?.flag;

function take(record: FrameRecord, at: number): void {
  if (isHost(record.from)) return;
  const one = watched(record.from);
  one.presence.hear(record.id, at);
  const name = table.get()?.name(record.id);
  const isMode = name === "mode", isLog = name === "log";
  if (!isMode && !isLog) return;
  const reading = table.get()?.read(record.id, record.from, record.data);
  if (!(reading instanceof Reading)) return;
  if (isMode) one.flag = reading.number("sflag") ?? one.flag;
  if (isLog && reading.get("color") === 1) void askForRed(record.from);
}

/** By device: the number of red lines in the gateway. */
const counted = new Map<number, number>();
const dismissedOf = (device: number): number => Number(remembered(`red.${device}`)) || 0;
const asking = new Set<number>();

/** Requests the log of the gateway, which has every line and their number, while the page receives only samples. */
async function askForRed(device: number): Promise<void> {
  if (asking.has(device)) return;
  asking.add(device);
  await new Promise((done) => setTimeout(done, askRedAfter)); // lines often arrive in groups
  asking.delete(device);
  const answer = await ask<{ red?: number; lines?: { color?: number; counts?: boolean; text: string }[] }>(`/devices/${device}/log`, { timeout: 5000 });
  if (!answer.ok || typeof answer.value.red !== "number") return;
  const { red, lines = [] } = answer.value;
  counted.set(device, red);
  if (red < dismissedOf(device)) remember(`red.${device}`, "0"); // the gateway was restarted
  const count = red - dismissedOf(device), last = lines.filter((line) => line.color === 1 && line.counts !== false).pop();
  const others = redLines.get().filter((line) => line.device !== device);
  redLines.set(count > 0 ? [{ device, text: (last?.text ?? "").slice(0, 200), count }, ...others].slice(0, 8) : others);
}

export function dismissRed(device: number): void {
  remember(`red.${device}`, String(counted.get(device) ?? 0));
  redLines.update((lines) => lines.filter((line) => line.device !== device));
}

function lookForRed(): void {
  for (const device of devices.get())
    if ((device.red_lines ?? 0) !== (counted.get(Number(device.address)) ?? 0)) void askForRed(Number(device.address));
}

/** For a device that was switched off: its loss is not reported any more, also on the next visit, until it is received again. */
export function dismissLost(device: number): void {
  const one = all.get(device);
  if (one) {
    one.dismissedAt = one.presence.heardAt;
    remember(`lost.${device}`, String(Date.now() / 1000 - (seconds() - one.presence.heardAt)));
  }
  look();
}

const sameVisit = 5; // seconds: tolerance between two visits for the time of the last frame of a device

/** The gateway reports devices that were lost while this page was hidden or before it was opened. If a vehicle was locked then, it was switched off:
 * its loss counts as dismissed. */
function takeHeard(heard: HeardDevice[]): void {
  for (const { device, isLost, heardAt, flag, elsewhere } of heard) {
    if (!isLost) {
      all.get(device)?.presence.isBack();
      continue;
    }
    const one = watched(device), isNew = one.presence.heardAt === Number.NEGATIVE_INFINITY;
    one.presence.wasLost(heardAt, elsewhere);
    one.flag = document.hidden || elsewhere !== undefined ? (flag ?? one.flag) : (one.flag ?? flag);
    const dismissed = Number(remembered(`lost.${device}`)) || 0, age = seconds() - heardAt;
    if (isNew && (flag === 0 || Date.now() / 1000 - age - dismissed < sameVisit)) one.dismissedAt = one.presence.heardAt;
  }
  look();
}

/** Lost devices stay lost until they are received, or the gateway reports that they are. */
function seeNoFrames(): void {
  for (const device of lostDevices.get()) {
    const presence = all.get(device)?.presence;
    presence?.wasLost(presence.heardAt, presence.elsewhere);
  }
  since = Number.POSITIVE_INFINITY;
}

/** An older value is shown with its age and can be dismissed: its device may be switched off. */
export const oldAfter = 10; // seconds
const alarmKey = ({ device, limit }: Alarm): string => `alarm.${device} ${limit.key}`;
/** Unix time, because it is stored for the next visit. */
const heardTime = (alarm: Alarm): number => Date.now() / 1000 - (seconds() - alarm.heardAt);
const isDismissed = (alarm: Alarm): boolean => heardTime(alarm) <= (Number(remembered(alarmKey(alarm))) || 0);

/** Dismisses the alarm until the value is received again. The 2 s allow for ages that differ a little between messages. */
export function dismissAlarm(alarm: Alarm): void {
  remember(alarmKey(alarm), String(heardTime(alarm) + 2));
  look();
}

export function silence(): void {
  for (const key of sounding.get()) silenced.add(key);
  look();
}

let soundedAt = Number.NEGATIVE_INFINITY;

function look(): void {
  const now = seconds();
  if (contact.get() !== "live") return;
  const replayed = replayedDevices(status.get());
  const silent = [...all].filter(([device, one]) => !replayed.has(device) && one.presence.isLost(now, since)).map(([device]) => device);
  const lost = silent.filter((device) => all.get(device)!.presence.heardAt !== all.get(device)!.dismissedAt);
  keep(lostDevices, silent);
  keep(lostNews, lost);
  const found = alarmsOfGateway.get().filter((one) => !isDismissed(one));
  const words = (list: readonly Alarm[]): string => list.map((one) => `${one.device} ${one.limit.key} ${one.level} ${one.value} ${one.heardAt}`).join();
  if (words(found) !== words(alarms.get())) alarms.set(found);
  sound(now, [...lost.map((device) => `lost ${device}`), ...found.map((one) => `${one.level} ${one.device} ${one.limit.key}`)]);
}

function sound(now: number, keys: string[]): void {
  for (const key of [...silenced]) if (!keys.includes(key)) silenced.delete(key);
  const loud = keys.filter((key) => !silenced.has(key));
  const news = loud.some((key) => !sounding.get().includes(key));
  if (loud.join() !== sounding.get().join()) sounding.set(loud);
  if (loud.length === 0 || (!news && now - soundedAt < soundEvery)) return;
  soundedAt = now;
  alarmSound(loud.every((key) => key.startsWith("amber")) ? "amber" : "red");
}

/** Starts at the first status: before, it is not known whether the gateway requires a token. */
export function beginWatch(): void {
  const stop = status.subscribe(() => {
    stop();
    followAlarms(takeHeard);
    watchStream.use({ wish: { samples, batch: 60 }, take, began: () => { since = seconds(); } });
    document.addEventListener("visibilitychange", () => {
      if (document.hidden) seeNoFrames();
    });
    setInterval(look, lookEvery);
    devices.subscribe(lookForRed);
  });
}
