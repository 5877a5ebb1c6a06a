// Changes that were not sent to the device yet, by page and device. They are kept while the web page is open.
import { entryOf } from "../entries";
import { Store } from "./store";

const kept = new Map<string, Store<unknown>>();
const key = (page: string, device: number): string => `${page} ${device}`;

/** undefined: no changes. `T` must be the same for all uses of one `page`. */
export const draftOf = <T>(page: string, device: number): Store<T | undefined> =>
  entryOf(kept, key(page, device), () => new Store<unknown>(undefined)) as Store<T | undefined>;

/** "waypoints 220": pages and devices with unsent changes. */
export const editedPages = new Store<ReadonlySet<string>>(new Set());
export const isEdited = (all: ReadonlySet<string>, device: number, page?: string): boolean =>
  page === undefined ? [...all].some((one) => one.endsWith(` ${device}`)) : all.has(key(page, device));

export function setDraft<T>(page: string, device: number, draft: T | undefined): void {
  draftOf<T>(page, device).set(draft);
  const one = key(page, device);
  if ((draft !== undefined) === editedPages.get().has(one)) return;
  editedPages.update((all) => (draft !== undefined ? new Set([...all, one]) : new Set([...all].filter((other) => other !== one))));
}

/** The browser asks before the page is closed or reloaded while there are unsent changes. */
export function beginEdits(): void {
  addEventListener("beforeunload", (event) => {
    if (editedPages.get().size > 0) event.preventDefault();
  });
}
