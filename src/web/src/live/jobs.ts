// Jobs: operations that take long. The gateway reports their progress as lines, and the result at the end.
import { ask, isWrite, onHeard, path, refusalOf, requestOf, type Answer, type Options } from "../api";
import type { Fault } from "../i18n";

export interface Job<T = unknown> extends Fault {
  id: number;
  device?: string;
  kind: string;
  state: "running" | "waiting" | "done" | "failed" | "cancelled";
  progress?: number;
  done?: number;
  total?: number;
  unit?: string;
  message: string;
  step?: unknown;
  what?: string;
  status?: number;
  evidence?: Record<string, unknown>;
  result?: T;
}

/** Splits received text into complete lines, and keeps the rest. */
export class Lines {
  private rest = "";

  put(text: string): string[] {
    const parts = (this.rest + text).split("\n");
    this.rest = parts.pop() ?? "";
    return parts.filter((line) => line.trim() !== "");
  }
  end(): string[] {
    return this.put("\n");
  }
}

export function endOf<T>(job: Job<T>): Answer<T> {
  if (job.state === "done") return { ok: true, value: job.result as T, status: 200 };
  return { ok: false, refusal: { ...refusalOf(job.status ?? 0, { ...job, error: job.error || job.message || job.state }), body: job.result } };
}

export const isOver = (job: Job): boolean => job.state !== "running" && job.state !== "waiting";

const lost = (writes: boolean): Answer<never> => ({ ok: false, refusal: { status: 0, error: "", what: "no_contact", writes } });
const againAfter = 500; // milliseconds

/** After a restart, the gateway numbers its jobs from 1 again, so the number may belong to another job. */
export const isSameJob = (before: Job, now: Job): boolean => before.id === now.id && before.kind === now.kind && before.device === now.device;

/** Follows a job to its end, and calls `onJob` for each change. A job continues without a connection. After a lost connection, this retries until the
 * gateway is available again. If the end was missed, the result is not known. */
export async function follow<T>(route: string, options: Options, onJob: (job: Job<T>) => void, known?: Job<T>): Promise<Answer<T>> {
  let isAnother = false;
  const take = (job: Job<T>): void => {
    if ((isAnother ||= known !== undefined && !isSameJob(known, job))) return;
    known = job;
    onJob(job);
  };
  let answer = await listen<T>(route, options, take);
  while (!isAnother && !answer.ok && answer.refusal.status === 0 && known) {
    await new Promise((done) => setTimeout(done, againAfter));
    answer = await listen<T>(`/jobs/${known.id}`, {}, take);
  }
  return isAnother || !answer.ok && (answer.refusal.status === 0 || (known && answer.refusal.status === 404)) ? lost(isWrite(options)) : answer;
}

/** Follows a job on a single connection. */
async function listen<T>(route: string, options: Options, onJob: (job: Job<T>) => void): Promise<Answer<T>> {
  try {
    const response = await fetch(path(route), requestOf({ ...options, accept: "application/x-ndjson" }));
    onHeard.call();
    const reader = response.body?.getReader();
    if (!reader) return lost(false);
    const lines = new Lines(), text = new TextDecoder();
    let last: Job<T> | undefined;
    const take = (all: string[]): void => {
      for (const line of all) {
        last = JSON.parse(line) as Job<T>;
        if (response.ok) onJob(last);
      }
    };
    for (let part = await reader.read(); !part.done; part = await reader.read()) {
      onHeard.call();
      take(lines.put(text.decode(part.value, { stream: true })));
    }
    take(lines.end());
    if (!response.ok) return { ok: false, refusal: refusalOf(response.status, last) };
    return last && isOver(last) ? endOf(last) : lost(false);
  } catch {
    return lost(false);
  }
}

/** The request only reads, but the job may have changed something. */
export const followOn = async <T>(job: Job<T>, onJob: (job: Job<T>) => void): Promise<Answer<T>> => {
  const answer = await follow<T>(`/jobs/${job.id}`, {}, onJob, job);
  return answer.ok || answer.refusal.status !== 0 ? answer : lost(true);
};

/** For a route that responds at once with the job: then follows the job to its result. */
export async function begin<T>(route: string, options: Options, onJob: (job: Job<T>) => void): Promise<Answer<T>> {
  const answer = await ask<Job<T>>(route, { ...options, method: "POST" });
  if (!answer.ok) return answer;
  onJob(answer.value);
  return isOver(answer.value) ? endOf(answer.value) : followOn(answer.value, onJob);
}

export const cancel = (job: Job): Promise<Answer<Job>> => ask(`/jobs/${job.id}`, { method: "DELETE" });
export const goOn = (job: Job): Promise<Answer<Job>> => ask(`/jobs/${job.id}/next`, { method: "POST", body: {} });
export const jobs = (): Promise<Answer<{ jobs: Job[] }>> => ask("/jobs", { timeout: 5000 });
