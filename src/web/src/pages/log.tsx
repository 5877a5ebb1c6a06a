// Log messages of devices: 0xA0 and 0xA1.
import { useEffect, useState } from "preact/hooks";
import { nameOf } from "../addresses";
import { ask } from "../api";
import { finder } from "../finder";
import { clockText, significant } from "../format";
import { deviceText, t, useLanguage } from "../i18n";
import { frameStream } from "../live/frames";
import { seconds, table } from "../live/gateway";
import { useStore, useTick } from "../live/store";
import { DeviceName } from "../parts/device_text";
import { visible } from "../visible";
import { download, stamp } from "../parts/download";
import { LostFrames } from "../parts/lost_frames";
import { hexByte, Reading } from "../protocol/table";

export interface Entry {
  missed?: string; // the reason why messages may be missing here
  number: number;
  time: number;
  from: number;
  colour: number;
  value: number | undefined;
  text: string;
}

const maxEntries = 2000;
const maxText = 2000; // characters of an entry, because a device can send very long ones

/** Kept while the web page is open. */
const entries: Entry[] = [];
let count = 0;

function add(entry: Omit<Entry, "number">): void {
  entries.push({ ...entry, number: ++count });
  while (entries.length > maxEntries) entries.splice(oldestOfMost(), 1);
}

/** The index of the oldest entry of the device with the most entries, so that a device can't displace the lines of others. */
function oldestOfMost(): number {
  const of = new Map<number, number>();
  for (const one of entries) of.set(one.from, (of.get(one.from) ?? 0) + 1);
  const [most] = [...of].reduce((a, b) => (b[1] > a[1] ? b : a));
  return entries.findIndex((one) => one.from === most);
}

interface KeptLine {
  time: number;
  device: string;
  color?: number;
  value?: number | string;
  text: string;
}

const everybody = 255;

/** Adds the lines that the gateway stored before, or while another page was open. Both sides use the gateway's clock, but read it at slightly
 * different moments, so equal lines may differ by up to 0.1 s. */
async function fill(): Promise<void> {
  const answer = await ask<{ lines?: KeptLine[] }>(`/devices/${everybody}/log`, { timeout: 5000 });
  if (!answer.ok || !Array.isArray(answer.value.lines)) return;
  const isHere = (line: KeptLine, text: string): boolean => entries.some((one) => one.from === Number(line.device) && Math.abs(one.time - line.time) < 0.1 && one.text.startsWith(text));
  const found = answer.value.lines.filter((line) => line.time > clearedAt && !isHere(line, line.text)).map((line): Entry => (
    { number: ++count, time: line.time, from: Number(line.device), colour: line.color ?? 0, value: typeof line.value === "number" ? line.value : undefined, text: line.text }));
  if (found.length === 0) return;
  const all = [...entries, ...found].sort((a, b) => a.time - b.time).filter((one) => one.missed === undefined || !found.some((line) => line.time > one.time - 1)).slice(-maxEntries);
  entries.splice(0, entries.length, ...all.map((one) => ({ ...one, number: ++count })));
}

let clearedAt = 0; // Unix seconds
let leftAt: number | undefined; // when the view was left
const miss = (why: string): void => add({ time: Date.now() / 1000, from: 0, colour: 0, value: undefined, text: "", missed: why });

const lineOf = (entry: Entry): string =>
  entry.missed !== undefined ? `${new Date(entry.time * 1000).toISOString()} # ${entry.missed}` :
  `${new Date(entry.time * 1000).toISOString()} ${hexByte(entry.from)} ${entry.value === undefined ? "" : entry.value + " "}${entry.text.replace(/[\r\n]+/g, " ")}`;

const inBrief = 240; // characters: a long line must not displace all others

function Words({ text }: { text: string }) {
  const [open, setOpen] = useState(false);
  if (text.length <= inBrief) return <>{text}</>;
  return <>{open ? text : text.slice(0, inBrief) + "… "}<button class="plain" aria-expanded={open} onClick={() => setOpen(!open)}>{open ? t("less") : t("more_characters", { n: text.length })}</button></>;
}

export function Log() {
  useLanguage();
  const of = useStore(table);
  const [search, setSearch] = useState("");
  const [paused, setPaused] = useState<Entry[]>();
  useTick(300);
  useEffect(() => {
    if (!of) return undefined;
    const ids = of.rows.filter((row) => row.name === "log" || row.name === "log_value").map((row) => row.id);
    const stop = frameStream.use({
      wish: { id: ids },
      began: () => {
        const silent = leftAt === undefined ? 0 : seconds() - leftAt;
        leftAt = undefined;
        if (silent > 1 && entries.length > 0) miss(t("log_not_heard", { s: Math.round(silent) }));
        void fill();
      },
      lost: (told) => miss(t("lost_on_the_way", { n: Object.values(told.lost).reduce((sum, n) => sum + n, 0) })),
      take: (record) => {
        const reading = of.read(record.id, record.from, record.data);
        if (!(reading instanceof Reading)) return;
        const text = reading.get("str");
        add({ time: record.time, from: record.from, colour: reading.number("color") ?? 0, value: reading.number("val"), text: typeof text === "string" ? text.slice(0, maxText) : "" });
      },
    });
    return () => {
      leftAt = seconds();
      stop();
    };
  }, [of]);
  const isFound = finder(search);
  const all = paused ?? entries;
  const unseen = paused ? count - (paused[paused.length - 1]?.number ?? count) : 0;
  const found = all.filter((entry) => isFound(entry.missed !== undefined ? "" : `${hexByte(entry.from)} ${nameOf(entry.from)} ${entry.text} ${deviceText(entry.text)}`));
  return (
    <div>
      <h1>{t("log")}</h1>
      <div class="tools">
        <input type="search" aria-label={t("search")} placeholder={t("search_log")} value={search} onInput={(event) => setSearch(event.currentTarget.value)} />
        <button disabled={found.length === 0} onClick={() => download(`anogate_${stamp()}.log`, new Blob([found.map(lineOf).join("\n") + "\n"], { type: "text/plain" }))}>{t("save_file")}</button>
        <button aria-pressed={paused !== undefined} onClick={() => setPaused(paused ? undefined : [...entries])}>{paused ? t("go_on") : t("pause")}{unseen > 0 ? ` (+${unseen})` : ""}</button>
        <button onClick={() => { entries.length = 0; clearedAt = Date.now() / 1000; setPaused(undefined); }}>{t("clear")}</button>
      </div>
      <LostFrames />
      {found.length === 0 ? <p class="muted">{t("log_empty")}</p> : (
        <ol class="log card" aria-live="off">
          {found.slice(-500).reverse().map((entry) => entry.missed !== undefined ? <li key={entry.number}><time class="muted number">{clockText(entry.time, true)}</time><span class="warn">{entry.missed}</span></li> : (
            <li key={entry.number}>
              <time class="muted number">{clockText(entry.time, true)}</time>
              <span class="muted"><DeviceName device={entry.from} /></span>
              <span class={["", "bad", "good", "blue"][entry.colour] ?? ""}>{entry.value !== undefined && <b>{significant(entry.value, 7)} </b>}<bdi><Words text={visible(deviceText(entry.text))} /></bdi></span>
            </li>
          ))}
        </ol>
      )}
    </div>
  );
}
