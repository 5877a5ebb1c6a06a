// Recordings on the gateway: start, end, download, delete; state of the disk.
import { useEffect, useState } from "preact/hooks";
import { path, type Refusal } from "../api";
import { bytesText, clockText, dayText, shortNumber } from "../format";
import { inWords, faultText, t, useLanguage } from "../i18n";
import { mayAct } from "../live/gateway";
import { beginRecording, deleteRecording, endRecording, fileOf, questionOf, readRecordings, saveLast, type KeptLast, type Recording, type Recordings as All, type RunningRecording, type Wishes } from "../live/recordings";
import { OutcomeLine, refusalText, useAction, type Action } from "../parts/action";
import { Confirm } from "../parts/confirm";

const between = 1000; // milliseconds from a response to the next request

const lasts = (seconds: number): string => inWords(Math.round(seconds));
const clock = (time: number): string => `${dayText(time)} ${clockText(time)}`;

/** Requested periodically while the page is visible. */
function useRecordings(): { all: All | undefined; fault: Refusal | undefined; look: () => void } {
  const [all, setAll] = useState<All>();
  const [fault, setFault] = useState<Refusal>();
  const [asked, again] = useState(0);
  useEffect(() => {
    let timer: ReturnType<typeof setTimeout> | undefined, gone = false;
    const look = async (): Promise<void> => {
      const answer = document.hidden ? undefined : await readRecordings();
      if (gone) return;
      if (answer?.ok) setAll(answer.value);
      if (answer) setFault(answer.ok ? undefined : answer.refusal);
      timer = setTimeout(() => void look(), between);
    };
    void look();
    return () => {
      gone = true;
      clearTimeout(timer);
    };
  }, [asked]);
  return { all, fault, look: () => again((n) => n + 1) };
}

function Disk({ all }: { all: All }) {
  const isFull = all.free_bytes !== null && all.free_bytes < all.free_needed;
  return (
    <>
      <p class="facts">
        <span>{all.folder}</span>
        {all.free_bytes !== null && <span class={isFull ? "bad" : "muted"}>{t("disk_free", { size: bytesText(all.free_bytes) })}</span>}
        {all.others > 0 && <span class="muted">{t("other_files", { n: all.others })}</span>}
      </p>
      {isFull && <p class="note warn" role="alert">{t("disk_full", { needed: bytesText(all.free_needed) })}</p>}
      {all.error && <p class="bad" role="alert">{faultText(all)}</p>}
    </>
  );
}

const nothing: Wishes = { name: "", format: "pcapng", direction: ["in"], id: "", from: "", to: "", link: "", limit: "", seconds: "" };
const directions = ["in", "out", "dropped"] as const;
const filters = ["id", "from", "to", "link", "limit"] as const;

function Begin({ action }: { action: Action }) {
  const [wishes, setWishes] = useState(nothing);
  const set = (change: Partial<Wishes>): void => setWishes((before) => ({ ...before, ...change }));
  const question = questionOf(wishes);
  const turn = (one: string): void => {
    const direction = directions.filter((way) => (way === one) !== wishes.direction.includes(way));
    if (direction.length > 0) set({ direction });
  };
  const begin = (event: Event): void => {
    event.preventDefault();
    if ("fault" in question) return;
    action.run(() => beginRecording(question.body), (one) => {
      set({ name: "" });
      return t("recording_begun", { name: one.name });
    });
  };
  const field = (name: Exclude<keyof Wishes, "direction" | "format">, label: string, hint: string) => (
    <label class="field">{label}<input value={wishes[name]} placeholder={hint} aria-invalid={"fault" in question && question.fault === name} onInput={(event) => set({ [name]: event.currentTarget.value })} /></label>
  );
  return (
    <form class="card begin" onSubmit={begin}>
      <div class="fields">
        {field("name", t("recording_name"), t("by_the_time"))}
        <label class="field">{t("recording_format")}<select value={wishes.format} onChange={(event) => set({ format: event.currentTarget.value })}><option>pcapng</option><option>mcap</option></select></label>
        {field("seconds", t("recording_seconds"), t("until_ended"))}
        <button class="main" disabled={action.busy || "fault" in question}>{t("record")}</button>
      </div>
      <details>
        <summary>{t("recording_filters")}</summary>
        <div class="checks" role="group" aria-label={t("direction")}>
          {directions.map((one) => <label key={one} class="check"><input type="checkbox" checked={wishes.direction.includes(one)} onChange={() => turn(one)} />{t(`direction_${one}`)}</label>)}
        </div>
        <div class="fields">{filters.map((name) => field(name, t(`filter_${name}`), name === "limit" ? "euler=10" : t("any")))}</div>
      </details>
      {"fault" in question && <p class="bad" role="alert">{t(`recording_bad_${question.fault}`)}</p>}
    </form>
  );
}

function Last({ last, action }: { last: KeptLast; action: Action }) {
  const save = (): void => action.run(() => saveLast("pcapng"), (saved) => t("last_saved", { name: saved.name, n: saved.frames }));
  return (
    <p class="tools">
      <span>{t("last_held", { time: lasts(last.held_s), of: lasts(last.seconds), n: shortNumber(last.frames), size: bytesText(last.bytes) })}</span>
      {mayAct() && <button disabled={action.busy || last.frames === 0} onClick={save}>{t("save_last")}</button>}
      <a href={path("/recordings/last")} download>{t("take_last")}</a>
      {last.saved > 0 && <span class="muted">{t("last_was_saved", { n: last.saved, name: last.last })}</span>}
      {last.skipped > 0 && <span class="warn">{t("last_skipped", { n: last.skipped })}</span>}
      {last.error && <span class="bad" role="alert">{faultText(last)}</span>}
    </p>
  );
}

function Running({ one, action }: { one: RunningRecording; action: Action }) {
  const end = (): void => action.run(() => endRecording(one.name), (ended) => t("recording_ended", { name: ended.name, n: ended.frames, size: bytesText(ended.bytes) }));
  return (
    <li class="card">
      <h3><i class="lamp recording" aria-hidden="true" />{one.name} <small class="muted">{t(one.by === "configuration" ? "by_configuration" : "by_request")}</small></h3>
      <p class="facts number">
        <span>{lasts(one.seconds)}</span><span>{t("frames_n", { n: shortNumber(one.frames) })}</span><span>{bytesText(one.bytes)}</span>
        <span class="muted">{one.file}{one.files > 1 ? ` (${t("files_n", { n: one.files })})` : ""}</span>
        {one.ends_in_s !== null && <span class="muted">{t("ends_in", { time: lasts(one.ends_in_s) })}</span>}
      </p>
      {one.not_written > 0 && <p class="note warn" role="status">{t("not_written", { n: one.not_written })}</p>}
      {one.error && <p class="bad" role="alert">{faultText(one)}</p>}
      {mayAct() && <Confirm label={t("end_recording")} question={t("end_question", { name: one.name })} yes={t("yes_end")} no={t("no_go_on")} disabled={action.busy} onYes={end} />}
    </li>
  );
}

const known: Record<string, "state_recording" | "state_ended" | "state_unfinished"> = { recording: "state_recording", ended: "state_ended", unfinished: "state_unfinished" };

function Row({ one, seconds, action }: { one: Recording; seconds: number | null; action: Action }) {
  const state = known[one.state];
  const remove = (): void => action.run(() => deleteRecording(one.name), () => t("recording_deleted", { name: one.name }));
  return (
    <li>
      <a href={path(fileOf(one.name))} download={one.name}>{one.name}</a>
      <span class="number muted">{clock(one.begun ?? one.time)}</span>
      <span class="number">{seconds === null ? "–" : lasts(seconds)}</span>
      <span class="number">{bytesText(one.bytes)}</span>
      <span class="number muted">{one.frames === null ? "" : t("frames_n", { n: shortNumber(one.frames) })}</span>
      <span class={one.state === "ended" ? "muted" : one.state === "recording" ? "bad" : "warn"}>{state ? t(state) : one.state}</span>
      {mayAct() && <span><Confirm label={t("delete")} question={t("delete_question", { name: one.name, size: bytesText(one.bytes) })} yes={t("yes_delete")} disabled={action.busy || one.state === "recording"} onYes={remove} /></span>}
    </li>
  );
}

/** The list has no length of a file that is being written; the running recording has it, unless it has several files. */
const runsFor = (file: Recording, running: RunningRecording[]): number | null =>
  running.find((one) => one.files === 1 && one.file.split("/").at(-1) === file.name)?.seconds ?? null;

export function Recordings() {
  useLanguage();
  const { all, fault, look } = useRecordings();
  const action = useAction(look);
  if (!all) return (
    <div>
      <h1>{t("recordings")}</h1>
      {!fault ? <p class="muted" role="status">{t("waiting_first")}</p> : <p class="bad" role="alert">{fault.status === 404 ? t("no_recordings_here") : refusalText(fault)}</p>}
    </div>
  );
  return (
    <div>
      <h1>{t("recordings")}</h1>
      <Disk all={all} />
      {mayAct() && <Begin action={action} />}
      {all.keep_last && <Last last={all.keep_last} action={action} />}
      <p><OutcomeLine action={action} /></p>
      <ul class="running">{all.running.map((one) => <Running key={one.name} one={one} action={action} />)}</ul>
      {all.recordings.length === 0 ? <p class="muted">{t("no_recordings")}</p> : (
        <ul class="recordings card">{all.recordings.map((one) => <Row key={one.name} one={one} seconds={one.seconds ?? runsFor(one, all.running)} action={action} />)}</ul>
      )}
    </div>
  );
}
