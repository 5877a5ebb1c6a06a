// Settings stored in the browser for the next visit.

/** Does nothing if the browser forbids storage. */
export function remember(key: string, value: string): void {
  try {
    localStorage.setItem("anogate." + key, value);
  } catch {
    // not kept
  }
}
export function remembered(key: string): string {
  try {
    return localStorage.getItem("anogate." + key) ?? "";
  } catch {
    return "";
  }
}
