// An action on a device: one at a time, and its result is shown.
import { useEffect, useRef, useState } from "preact/hooks";
import type { Answer, Refusal } from "../api";
import { faultText, messageText, t, type Key } from "../i18n";
import { jobs, type Job } from "../live/jobs";
import { hashOf } from "../route";
import { visible } from "../visible";
import { Confirm } from "./confirm";
import { DeviceText } from "./device_text";

interface Outcome {
  words: string;
  good: boolean;
  job?: number | undefined; // id of the job that uses the device
}

/** Details of a failure from the gateway. */
function evidenceText(evidence: Record<string, unknown> | undefined): string {
  const parts: string[] = [];
  const { sent, rtt_ms: trip, ...rest } = evidence ?? {};
  if (typeof sent === "number" && sent > 0) parts.push(t("evidence_sent", { n: sent }));
  if (typeof trip === "number" && trip >= 1) parts.push(t("evidence_trip", { ms: Math.round(trip) }));
  for (const [name, value] of Object.entries(rest)) if (typeof value !== "object") parts.push(`${name} ${String(value)}`);
  return parts.length > 0 ? ` (${parts.join(", ")})` : "";
}

export function refusalText(refusal: Refusal): string {
  if (refusal.status === 0) return t("no_contact") + (refusal.writes ? t("may_have_been_done") : "");
  const why = faultText(refusal) + evidenceText(refusal.evidence);
  if (refusal.what === "unknown" && refusal.status === 504) return t("unknown_end", { why });
  return refusal.status === 504 ? t("no_answer_of_device", { why }) : refusal.what === "busy" ? t("busy", { why }) : t("refused", { why });
}

/** The id of the job named in a refusal. */
function jobIn(refusal: Refusal): number | undefined {
  const job = (refusal.body as { job?: unknown } | undefined)?.job;
  return typeof job === "number" ? job : undefined;
}

const pageOfKind: Record<string, string> = {
  parameters: "parameters", write: "parameters", apply: "parameters", action: "parameters", commands: "commands", command: "commands",
  waypoints: "waypoints", put_waypoints: "waypoints", firmware: "firmware", calibration: "calibration",
};

/** A link to the page where the job that uses the device can be watched, continued and cancelled. */
function OpenJob({ id }: { id: number }) {
  const [job, setJob] = useState<Job>();
  useEffect(() => {
    void jobs().then((answer) => setJob(answer.ok ? answer.value.jobs.find((one) => one.id === id) : undefined));
  }, [id]);
  const page = job && pageOfKind[job.kind];
  if (!job || !page || !job.device) return null;
  return <a class="open-job" href={hashOf({ page, device: Number(job.device) })}>{t(job.state === "waiting" ? "open_waiting_job" : "open_job", { page: t(page as Key) })}</a>;
}

/** The reason why a job failed, with a link to the job that prevented it. */
export function JobFault({ refusal }: { refusal: Refusal }) {
  const job = jobIn(refusal);
  return <p class="bad" role="alert">✕ <DeviceText text={refusalText(refusal)} /> {job !== undefined && <OpenJob id={job} />}</p>;
}

export interface Action {
  busy: boolean;
  outcome: Outcome | undefined;
  /** Has no effect while an action runs, so that a double click does not repeat it. */
  run<T>(work: () => Promise<Answer<T>>, words: (value: T) => string): void;
  say(outcome: Outcome | undefined): void;
}

/** `after`: called when an action has ended, with or without success. */
export function useAction(after?: () => void): Action {
  const running = useRef(false);
  const gone = useRef(false);
  const [busy, setBusy] = useState(false);
  const [outcome, setOutcome] = useState<Outcome>();
  useEffect(() => () => void (gone.current = true), []);
  const run = <T,>(work: () => Promise<Answer<T>>, words: (value: T) => string): void => {
    if (running.current) return;
    running.current = true;
    setBusy(true);
    setOutcome(undefined);
    void work().then((answer) => {
      after?.();
      running.current = false;
      if (gone.current) return;
      setBusy(false);
      setOutcome(answer.ok ? { words: words(answer.value), good: true } : { words: refusalText(answer.refusal), good: false, job: jobIn(answer.refusal) });
    });
  };
  return { busy, outcome, run, say: setOutcome };
}

/** The progress of a job, with a button to cancel it. */
export function JobLine({ job, onCancel, question }: { job: Job | undefined; onCancel?: () => void; question?: string }) {
  if (!job) return null;
  const { progress, done, total, unit } = job;
  return (
    <div class="job">
      <progress max={1} value={progress} aria-label={messageText(job.message) || job.kind} />
      <span class="number">{total ? `${done ?? 0} / ${total} ${unit ?? ""}` : ""}</span>
      <bdi>{visible(messageText(job.message))}</bdi>
      {onCancel && (question
        ? <Confirm label={t("cancel")} question={question} yes={t("yes_cancel")} no={t("no_go_on")} onYes={onCancel} />
        : <button type="button" onClick={onCancel}>{t("cancel")}</button>)}
    </div>
  );
}

export function OutcomeLine({ action }: { action: Action }) {
  const { busy, outcome } = action;
  return (
    <span role="status" class={`outcome ${busy ? "muted" : outcome?.good ? "good" : "bad"}`}>
      {busy ? t("at_work") : outcome ? <>{outcome.good ? "✓" : "✕"} <bdi>{visible(outcome.words)}</bdi></> : ""}
      {!busy && outcome?.job !== undefined && <> <OpenJob id={outcome.job} /></>}
    </span>
  );
}
