// Hooks for jobs of a device.
import { useEffect, useRef, useState } from "preact/hooks";
import type { Answer, Options, Refusal } from "../api";
import { hexByte } from "../protocol/table";
import { begin, follow, followOn, isOver, jobs, type Job } from "./jobs";

export interface Running<T> {
  job: Job<T> | undefined; // undefined: ended, or none
  ended: Answer<T> | undefined;
  /** Has no effect while a job runs, so that a double click starts only one. */
  start(route: string, options: Options): void;
}

/** Follows a job of one kind, including a job that another client started. */
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
      if (mine) void followOn(mine as Job<T>, take).then(end);
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

export interface Asked {
  job: Job | undefined; // the running job
  fault: Refusal | undefined; // the error of the last read
  /** Runs a request that may start a job, and follows it with its progress. */
  run<R>(options: Options, to?: string): Promise<Answer<R>>;
  read(): Promise<void>;
}

/** Reads data of a device that takes long to read: once at the beginning, and on read(). `take` receives the result. */
export function useAsked<T>(route: string, take: (value: T) => void): Asked {
  const [job, setJob] = useState<Job>();
  const [fault, setFault] = useState<Refusal>();
  const run = async <R>(options: Options, to = route): Promise<Answer<R>> => {
    const answer = await follow<R>(to, options, setJob);
    setJob(undefined);
    return answer;
  };
  const read = async (): Promise<void> => {
    setFault(undefined);
    const answer = await run<T>({});
    if (answer.ok) take(answer.value);
    else setFault(answer.refusal);
  };
  useEffect(() => void read(), [route]);
  return { job, fault, run, read };
}
