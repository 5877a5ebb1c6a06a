// The texts of the page in two languages. {x} is a placeholder for a value.
import { duration } from "./format";
import { Store, useStore } from "./live/store";
import { remember, remembered } from "./kept";
import { words } from "./words";
import { faults } from "./faults";
import { messageInChinese } from "./words_of_device";
import { causes, errors, hints, hintsInEnglish, titles, unhandled, whos } from "./words_of_gateway";
import { simulated } from "./words_of_simulated";

export type Language = "en" | "zh";
export type Key = keyof typeof words;

export function languageOf(kept: string, wanted: readonly string[]): Language {
  if (kept === "en" || kept === "zh") return kept;
  const first = wanted.find((tag) => /^(zh|en)\b/i.test(tag));
  return first && /^zh/i.test(first) ? "zh" : "en";
}

export const language = new Store<Language>("en");

export function setLanguage(to: Language, keep = true): void {
  document.documentElement.lang = to === "zh" ? "zh-CN" : "en";
  if (keep) remember("language", to);
  language.set(to);
}

export function beginLanguage(): void {
  setLanguage(languageOf(remembered("language"), navigator.languages), false);
}

const isChinese = (): boolean => language.get() === "zh";
const said = ([english, chinese]: readonly [string, string]): string => (isChinese() ? chinese : english);

const filled = (text: string, args: Record<string, unknown> = {}): string =>
  text.replace(/\{(\w+)\}/g, (whole, name: string) => (name in args ? String(args[name]) : whole));

export function t(key: Key, args?: Record<string, unknown>): string {
  return filled(said(words[key]), args);
}

/** The parts of the text; each {x} is replaced by `make` of its value. */
export function filledWith<T>(key: Key, args: Record<string, unknown>, make: (value: string) => T): (string | T)[] {
  return said(words[key]).split(/(\{\w+\})/).map((part) => {
    const name = /^\{(\w+)\}$/.exec(part)?.[1];
    return name !== undefined && name in args ? make(String(args[name])) : part;
  });
}

export const useLanguage = (): Language => useStore(language);

export const inWords = (seconds: number): string => duration(seconds, isChinese());

/** The text of the gateway about a link, in Chinese if its id is known. */
export function hintText(id: string, text: string, args: Record<string, unknown>): string {
  if (!isChinese()) return hintsInEnglish[id] ?? text;
  const known = hints[id];
  return known === undefined ? text : filled(known, args) + (args.try_hello ? unhandled.try_hello : "");
}
export function errorText(id: string, text: string, args: Record<string, unknown>): string {
  const known = isChinese() ? errors[id] : undefined;
  return known === undefined ? text : filled(known, args);
}
/** The progress of a job, in Chinese if a translation is known. */
export const messageText = (text: string): string => (isChinese() ? messageInChinese(text) : text);

/** Why something failed: a text, and its id with arguments. An argument may be a clause with an id of its own; remarks are further clauses. */
export interface Fault {
  error?: string;
  error_id?: string;
  error_args?: Record<string, unknown>;
  error_remarks?: Fault[];
}

/** undefined: an id is not known. */
export function faultInChinese({ error_id: id = "", error_args: args = {}, error_remarks: remarks = [] }: Fault): string | undefined {
  const form = faults[id];
  const clauses = Object.entries(args).map(([name, value]) => [name, typeof value === "object" && value ? faultInChinese(value) : value] as const);
  const all = [form && filled(form, Object.fromEntries(clauses)), ...remarks.map(faultInChinese)];
  return clauses.some(([, value]) => value === undefined) || all.includes(undefined) ? undefined : all.join("；");
}
export const faultText = (fault: Fault): string => (isChinese() ? faultInChinese(fault) : undefined) ?? fault.error ?? "";
/** The meaning of a counter, or its name if not known. */
export const causeText = (name: string): string => said(causes[name] ?? [name, name]);
/** A description or log message of a device: Chinese if it is one of a simulated device. */
export const deviceText = (text = ""): string => (isChinese() ? (simulated.get(text) ?? text) : text);
export const whoText = (who: string): string => (isChinese() ? (whos[who] ?? who) : who);
export const titleText = (name: string, title: string): string => (isChinese() ? (titles[name] ?? title) : title);
