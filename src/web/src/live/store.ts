// A value with notification of changes.
import { useEffect, useState } from "preact/hooks";

export class Store<T> {
  private readonly listeners = new Set<() => void>();

  constructor(private current: T) {}

  get(): T {
    return this.current;
  }

  set(value: T): void {
    if (Object.is(value, this.current)) return;
    this.current = value;
    for (const listener of [...this.listeners]) listener();
  }

  update(change: (value: T) => T): void {
    this.set(change(this.current));
  }

  subscribe(listener: () => void): () => void {
    this.listeners.add(listener);
    return () => this.listeners.delete(listener);
  }
}

/** Renders the component again when the value changes. */
export function useStore<T>(store: Store<T>): T {
  const [, again] = useState(0);
  const shown = store.get();
  useEffect(() => {
    if (store.get() !== shown) again((n) => n + 1); // it changed before this effect, which runs late on a hidden page
    return store.subscribe(() => again((n) => n + 1));
  }, [store]);
  return shown;
}

/** Renders the component again at this interval, while the page is visible. */
export function useTick(milliseconds: number): void {
  const [, again] = useState(0);
  useEffect(() => {
    const timer = setInterval(() => {
      if (!document.hidden) again((n) => n + 1);
    }, milliseconds);
    return () => clearInterval(timer);
  }, [milliseconds]);
}
