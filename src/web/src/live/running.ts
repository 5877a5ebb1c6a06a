// Jobs at a device, as a page shows them.
import { useEffect, useRef, useState } from "preact/hooks";
import type { Answer, Options, Refusal } from "../api";
import { hexByte } from "../protocol/table";
import { begin, follow, followOn, isOver, jobs, type Job } from "./jobs";

export interface Running<T> {
  job: Job<T> | undefined; // undefined: it has ended, or there is none
  ended: Answer<T> | undefined;
  /** Does nothing while a job runs, so that a double click does not begin two. */
  start(route: string, options: Options): void;
}

/** Follows a job of one kind, also one that another client began. */
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
  job: Job | undefined; // the present one
  fault: Refusal | undefined; // why it could not be read
  /** Follows a job, with its progress. */
  run<R>(options: Options, to?: string): Promise<Answer<R>>;
  read(): Promise<void>;
}

/** What a device has, which takes long to read: read at once, and given to `take`. */
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
