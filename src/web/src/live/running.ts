// Follows a job of one kind at one device, also one that another client began.
import { useEffect, useRef, useState } from "preact/hooks";
import type { Answer } from "../api";
import { hexByte } from "../protocol/table";
import { begin, follow, jobs, type Job } from "./jobs";
import type { Options } from "../api";

export interface Running<T> {
  job: Job<T> | undefined; // undefined: it has ended, or there is none
  ended: Answer<T> | undefined;
  /** Does nothing while a job runs, so that a double click does not begin two. */
  start(route: string, options: Options): void;
}

const isOver = (job: Job): boolean => job.state !== "running" && job.state !== "waiting";

export function useRunning<T>(device: number, kind: string): Running<T> {
  const [job, setJob] = useState<Job<T>>();
  const [ended, setEnded] = useState<Answer<T>>();
  const end = (answer: Answer<T>): void => {
    setJob(undefined);
    setEnded(answer);
  };
  const take = (next: Job<T>): void => setJob(isOver(next) ? undefined : next);
  useEffect(() => {
    void jobs().then((answer) => {
      const mine = answer.ok ? answer.value.jobs.find((one) => one.kind === kind && one.device === hexByte(device) && !isOver(one)) : undefined;
      if (mine) void follow<T>(`/jobs/${mine.id}`, {}, take, mine as Job<T>).then((answer) => end(answer.ok || answer.refusal.status !== 0 ? answer : { ok: false, refusal: { ...answer.refusal, writes: true } }));
    });
  }, [device, kind]);
  const begun = useRef(false);
  const start = (route: string, options: Options): void => {
    if (begun.current) return;
    begun.current = true;
    setEnded(undefined);
    setJob(undefined);
    void begin<T>(route, options, take).then((answer) => {
      begun.current = false;
      end(answer);
    });
  };
  return { job, ended, start };
}
