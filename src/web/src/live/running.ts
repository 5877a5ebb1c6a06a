// A job of one kind at one device, followed wherever it was begun.
import { useEffect, useRef, useState } from "preact/hooks";
import type { Answer } from "../api";
import { hexByte } from "../protocol/table";
import { begin, follow, jobs, type Job } from "./jobs";
import type { Options } from "../api";

export interface Running<T> {
  job: Job<T> | undefined; // while it has not ended
  ended: Answer<T> | undefined;
  /** Nothing while the last one has not ended: no action twice by a nervous finger. */
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
      if (mine) void follow<T>(`/jobs/${mine.id}`, {}, take, mine as Job<T>).then(end);
    });
  }, [device, kind]);
  const begun = useRef(false);
  const start = (route: string, options: Options): void => {
    if (begun.current) return;
    begun.current = true;
    setEnded(undefined);
    void begin<T>(route, options, take).then((answer) => {
      begun.current = false;
      end(answer);
    });
  };
  return { job, ended, start };
}
