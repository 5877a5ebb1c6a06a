// The recordings of the gateway, stored and running, and requests for new ones.
import { ask, type Answer } from "../api";
import type { Fault } from "../i18n";

export interface RunningRecording extends Fault {
  name: string;
  by: string; // "configuration" or "request"
  file: string;
  files: number;
  format: string;
  frames: number;
  bytes: number;
  not_written: number;
  since: number; // Unix seconds
  seconds: number;
  ends_in_s: number | null;
}
export interface Recording {
  name: string;
  format: string;
  bytes: number;
  frames: number | null;
  begun: number | null; // Unix seconds
  seconds: number | null; // length according to the file
  time: number;
  state: string; // "recording", "ended" or "unfinished"
}
export interface KeptLast extends Fault {
  seconds: number;
  held_s: number;
  frames: number;
  bytes: number;
  saved: number;
  skipped: number;
  last: string;
}
export interface Recordings extends Fault {
  folder: string;
  free_bytes: number | null;
  free_needed: number;
  others: number;
  keep_last: KeptLast | null;
  running: RunningRecording[];
  recordings: Recording[];
}

/** The section `recording` of the status; null: recording is not available. */
export type RecordingState = Pick<Recordings, "keep_last" | "running"> | null;

export interface RecordingFault extends Fault {
  name: string; // name of the recording; empty: the frames of keep_last could not be saved
}

export function faultsOf(state: RecordingState | undefined): RecordingFault[] {
  return [...(state?.running ?? []), { ...state?.keep_last, name: "" }].filter((one) => one.error);
}

/** The form for a new recording; empty: not given. */
export interface Wishes {
  name: string;
  format: string;
  direction: string[];
  id: string;
  from: string;
  to: string;
  link: string;
  limit: string; // "euler=10 0x01=50": maximum rates of messages, per second
  seconds: string;
}

export const fileOf = (name: string): string => "/recordings/" + encodeURIComponent(name);

const partsOf = (text: string): string[] => text.split(/[\s,]+/).filter(Boolean);
const listed = (text: string): string => partsOf(text).join(",");

/** The rates by message; undefined: invalid text. */
export function limitsIn(text: string): Record<string, number> | undefined {
  const pairs = partsOf(text).map((one) => /^([^=]+)=(\d+(?:\.\d+)?)$/.exec(one));
  if (pairs.some((pair) => !pair)) return undefined;
  return Object.fromEntries(pairs.map((pair) => [pair![1]!, Number(pair![2])]));
}

/** The body of the request for a new recording, or the name of the invalid field. */
export function questionOf(wishes: Wishes): { body: Record<string, unknown> } | { fault: "name" | "limit" | "seconds" } {
  const name = wishes.name.trim(), seconds = wishes.seconds.trim(), limit = limitsIn(wishes.limit);
  if (name !== "" && !/^[A-Za-z0-9_-][A-Za-z0-9._-]{0,99}$/.test(name)) return { fault: "name" };
  if (!limit) return { fault: "limit" };
  if (seconds !== "" && !(Number(seconds) > 0)) return { fault: "seconds" };
  const all = { name, format: wishes.format, direction: wishes.direction.join(","), id: listed(wishes.id), from: listed(wishes.from), to: listed(wishes.to), link: listed(wishes.link) };
  const body: Record<string, unknown> = Object.fromEntries(Object.entries(all).filter(([, value]) => value !== ""));
  if (Object.keys(limit).length > 0) body.limit = limit;
  if (seconds !== "") body.seconds = Number(seconds);
  return { body };
}

export const readRecordings = (): Promise<Answer<Recordings>> => ask("/recordings", { timeout: 5000 });
export const beginRecording = (body: unknown): Promise<Answer<RunningRecording>> => ask("/recordings", { method: "POST", body, timeout: 30000 });
export const saveLast = (format: string): Promise<Answer<{ name: string; bytes: number; frames: number }>> =>
  ask("/recordings", { method: "POST", body: { last: true, format }, timeout: 60000 });
export const endRecording = (name: string): Promise<Answer<RunningRecording>> => ask(fileOf(name) + "/end", { method: "POST", body: {}, timeout: 30000 });
export const deleteRecording = (name: string): Promise<Answer<unknown>> => ask(fileOf(name), { method: "DELETE", timeout: 30000 });
