// State of the gateway: contact, status, message table, known devices.
import { ask, onHeard, onTokenNeeded, type Answer, type Refusal } from "../api";
import { MessageTable, type MessageRow } from "../protocol/table";
import { remember, remembered } from "../kept";
import type { Datum } from "../map/datum";
import { place } from "../route";
import { reopenAll } from "./connection";
import { CounterRates, type Counters } from "./counters";
import { jobs } from "./jobs";
import { Liveness, type Contact } from "./liveness";
import type { RecordingState } from "./recordings";
import { Store } from "./store";

export interface Channel extends Counters {
  peer: string;
  listening_since_s?: number; // set for a host that sent only one frame: the time since then
}
export interface Link extends Counters {
  name: string;
  kind: string;
  id: number | null;
  state: string;
  error: string;
  error_id: string;
  error_args: Record<string, unknown>;
  hint: string;
  hint_id: string;
  hint_args: Record<string, unknown>;
  channels: Channel[];
  /** "lx": pitch and yaw of its Euler angles have the opposite sign of its quaternions. */
  attitude?: string;
  /** The devices in the recording that the link replays. */
  replayed?: { address: string; who: string }[];
}
export interface Route {
  address: string;
  who: string;
  links: string[];
  via: string;
  age_s?: number;
}
export interface Status {
  gateway: { id: number | null; name: string; version: string; uptime_s: number; decoding_changes?: number; standstills: number; longest_standstill_s: number };
  links: Link[];
  routes: Route[];
  conflicts: { address: string; links?: string[]; home?: string[]; pinned?: boolean; claimed_by?: { link: string; peer: string } | null; [key: string]: unknown }[];
  recording?: RecordingState;
  http: { token_needed: boolean; tls: boolean };
  map: { file: string; datum: Datum } | null;
}
export interface Device {
  address: string;
  name?: string;
  link?: string;
  age?: number;
  rate?: number;
  hw?: number;
  sw?: number;
  in_loader?: boolean;
  limits?: number; // version of its alarm limits; 0: none
  red_lines?: number; // number in its log since the start of the gateway
}

/** A vehicle, or a device that sent telemetry, from which the gateway receives nothing any more. */
export interface LostVehicle {
  address: string;
  name?: string;
  age: number;
  sflag?: number; // from its last `mode`, if any
}

export const contact = new Store<Contact>("never");
export const status = new Store<Status | undefined>(undefined);
export const table = new Store<MessageTable | undefined>(undefined);
export const devices = new Store<Device[]>([]);
export const lostVehicles = new Store<LostVehicle[]>([]);
export const tokenNeeded = new Store(false);
const linkRates = new CounterRates();
/** The sum of these counters over all `links`, per second; undefined: not known yet. */
export function rateOf(links: Link[], counters: string[]): number | undefined {
  if (counters.length === 0) return 0;
  const known = links.flatMap((link) => counters.map((name) => linkRates.perSecond("link:" + link.name, name))).filter((rate) => rate !== undefined);
  return known.length === 0 ? undefined : known.reduce((sum, rate) => sum + rate, 0);
}

export const seconds = (): number => performance.now() / 1000;

const liveness = new Liveness();
export const silentFor = (): number => liveness.silentFor(performance.now()) / 1000;

function took(value: Status): void {
  const now = seconds();
  for (const link of value.links) {
    linkRates.look("link:" + link.name, link, now);
    link.channels.forEach((channel, i) => linkRates.look(`channel:${link.name}:${channel.peer}:${i}`, channel, now));
  }
  ++statuses;
  status.set(value);
}

// Identifies a run of the gateway with its flexible layouts: another run, or changed layouts, may have another message table.
interface Run {
  version: string;
  begunAt: number; // Unix seconds
  changes: number | undefined; // number of changes of the flexible layouts
}
let tableOfRun: Run | undefined, tableText = "";

/** Same version, same number of changes, and a start within 10 s of each other, because clocks may be adjusted. */
const isSameRun = (a: Run, b: Run): boolean => a.version === b.version && a.changes === b.changes && Math.abs(a.begunAt - b.begunAt) <= 10;

async function keepTable({ gateway }: Status): Promise<void> {
  const run = { version: gateway.version, begunAt: Date.now() / 1000 - gateway.uptime_s, changes: gateway.decoding_changes };
  if (table.get() && tableOfRun && isSameRun(run, tableOfRun)) return;
  tableOfRun = run;
  const answer = await ask<MessageRow[]>("/messages", { timeout: 5000 });
  if (!answer.ok || !Array.isArray(answer.value)) return void (tableOfRun = undefined);
  const text = JSON.stringify(answer.value); // the same table is kept, with everything decoded by it
  if (text !== tableText) table.set(new MessageTable(answer.value));
  tableText = text;
}

let askedForDevices = Number.NEGATIVE_INFINITY;

async function keepDevices(now: number): Promise<void> {
  if (now - askedForDevices < 2000) return;
  askedForDevices = now;
  const answer = await ask<{ devices: Device[]; lost?: LostVehicle[] }>("/devices", { timeout: 4000 });
  if (!answer.ok || !Array.isArray(answer.value.devices)) return;
  devices.set(answer.value.devices);
  lostVehicles.set(answer.value.lost ?? []);
}

/** Requests the names of all devices. */
export async function scan(): Promise<Answer<{ devices: Device[] }>> {
  const answer = await ask<{ devices: Device[] }>("/devices/scan", { method: "POST", body: {} });
  if (answer.ok) devices.set(answer.value.devices);
  return answer;
}

const beatEvery = 100; // milliseconds

/** Milliseconds between two requests for the status. The overview shows its figures; the other pages use only its devices and links. Each request
 * costs the gateway up to half a millisecond of processor time. */
const statusEvery = (): number => (statuses < 2 ? firstRatesAfter : ["", "overview"].includes(place.get().page) ? 1000 : 3000);
/** The second request follows early, because a rate needs two. */
const firstRatesAfter = 300;
let statuses = 0;
let askedForStatus = Number.NEGATIVE_INFINITY;

/** Between two requests for the status, a small request checks the contact. */
async function askGateway(question: number): Promise<void> {
  const now = performance.now();
  if (now - askedForStatus <= statusEvery() - beatEvery) {
    await jobs();
    return liveness.ended(question);
  }
  await readStatus();
  liveness.ended(question);
}

/** Returns whether the gateway responded, with any status. */
async function readStatus(): Promise<boolean> {
  askedForStatus = performance.now();
  const answer = await ask<Status>("/status", { timeout: 5000 });
  if (!answer.ok) askedForStatus = Number.NEGATIVE_INFINITY;
  if (!answer.ok || tokenNeeded.get()) return answer.ok || answer.refusal.status !== 0;
  took(answer.value);
  void keepTable(answer.value);
  void keepDevices(performance.now());
  return true;
}

function beat(): void {
  if (document.hidden || tokenNeeded.get()) return;
  const now = performance.now();
  const question = liveness.ask(now, statusEvery());
  if (question !== undefined) void askGateway(question);
  const left = liveness.lostAt() - now;
  if (left > 0 && left < beatEvery) setTimeout(look, left + 1); // the next beat would be late
  look();
}

/** Updates the contact state. */
function look(): void {
  if (document.hidden || tokenNeeded.get()) return;
  const now = performance.now();
  nowIs(liveness.contact(now));
}

function nowIs(after: Contact): void {
  const before = contact.get();
  contact.set(after);
  if (before === "lost" && after === "live") reopenAll();
}

const hiddenEvery = 5000; // milliseconds
let isAskingHidden = false;
let endPause = (): void => undefined;

/** Ends the waiting time of a hidden page: a connection was opened or closed. */
export const hurry = (): void => endPause();

/** For a hidden page: browsers limit its intervals to one per minute, but not the code that follows a response. */
async function askWhileHidden(): Promise<void> {
  if (isAskingHidden) return;
  isAskingHidden = true;
  while (document.hidden) {
    const isThere = tokenNeeded.get() || (await readStatus());
    if (document.hidden && !tokenNeeded.get() && contact.get() !== "never") nowIs(isThere ? "live" : "lost");
    if (!document.hidden) break;
    await new Promise<void>((done) => {
      endPause = done;
      setTimeout(done, hiddenEvery);
    });
  }
  isAskingHidden = false;
}

export function begin(): void {
  onHeard.call = () => {
    liveness.heard(performance.now());
    if (contact.get() === "never") contact.set("live");
  };
  onTokenNeeded.call = () => tokenNeeded.set(true);
  document.addEventListener("visibilitychange", () => {
    if (document.hidden) return void askWhileHidden();
    hurry();
    liveness.restart(performance.now(), contact.get() === "lost");
  });
  if (document.hidden) void askWhileHidden();
  beat();
  setInterval(beat, beatEvery);
}

/** A six-digit code of “anoctl web --pair”, instead of a token. */
export const isDigits = (typed: string): boolean => /^\d{6}$/.test(typed);

/** Returns undefined after success. */
export async function logIn(secret: string, kind: "token" | "code"): Promise<Refusal | undefined> {
  const answer = await ask<{ access: string }>("/login", { method: "POST", body: { [kind]: secret }, timeout: 5000 });
  if (!answer.ok) return answer.refusal;
  access.set(answer.value.access);
  remember("access", answer.value.access);
  tokenNeeded.set(false);
  liveness.restart(performance.now());
  reopenAll();
  return undefined;
}

/** The browser deletes the cookie, and the page asks for a token. Without contact to the gateway, the session remains signed in. */
export async function logOut(): Promise<void> {
  const answer = await ask("/logout", { method: "POST", timeout: 5000 });
  if (!answer.ok) return;
  access.set("");
  remember("access", "");
  tokenNeeded.set(true);
}

/** "view": read-only. The page hides actions that are not allowed; the gateway checks the rights. */
export const access = new Store(remembered("access"));
export const mayAct = (): boolean => access.get() !== "view" || status.get()?.http.token_needed === false;
