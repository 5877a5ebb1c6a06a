// What was changed and not sent to its device yet, of each page of each device: it stays while the page is open, whichever page is shown.
import { entryOf } from "../entries";
import { Store } from "./store";

const kept = new Map<string, Store<unknown>>();
const key = (page: string, device: number): string => `${page} ${device}`;

/** undefined: nothing is changed. The page decides what it is: `T` is the same for each use of one `page`. */
export const draftOf = <T>(page: string, device: number): Store<T | undefined> =>
  entryOf(kept, key(page, device), () => new Store<unknown>(undefined)) as Store<T | undefined>;

/** "waypoints 220": pages and devices with such changes. */
export const editedPages = new Store<ReadonlySet<string>>(new Set());
export const isEdited = (all: ReadonlySet<string>, device: number, page?: string): boolean =>
  page === undefined ? [...all].some((one) => one.endsWith(` ${device}`)) : all.has(key(page, device));

export function setDraft<T>(page: string, device: number, draft: T | undefined): void {
  draftOf<T>(page, device).set(draft);
  const one = key(page, device);
  if ((draft !== undefined) === editedPages.get().has(one)) return;
  editedPages.update((all) => (draft !== undefined ? new Set([...all, one]) : new Set([...all].filter((other) => other !== one))));
}

/** The browser asks before the page with such changes is closed or loaded again. */
export function beginEdits(): void {
  addEventListener("beforeunload", (event) => {
    if (editedPages.get().size > 0) event.preventDefault();
  });
}
