// A job of one kind at one device, followed wherever it was begun.
import { useEffect, useState } from "preact/hooks";
import type { Answer } from "../api";
import { hexByte } from "../protocol/table";
import { begin, follow, jobs, type Job } from "./jobs";
import type { Options } from "../api";

export interface Running<T> {
  job: Job<T> | undefined; // while it has not ended
  ended: Answer<T> | undefined;
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
      if (mine) void follow<T>(`/jobs/${mine.id}`, {}, take).then(end);
    });
  }, [device, kind]);
  const start = (route: string, options: Options): void => {
    setEnded(undefined);
    void begin<T>(route, options, take).then(end);
  };
  return { job, ended, start };
}
