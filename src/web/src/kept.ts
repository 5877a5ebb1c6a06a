// Settings that the browser keeps for the next visit.

/** A browser may forbid storage: then nothing is kept. */
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
