// What the browser keeps for the next time.

/** A browser may forbid to keep anything: then it is forgotten. */
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
