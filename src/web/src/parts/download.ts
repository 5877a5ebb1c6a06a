// Offers data as a file to download.
import { clockText, dayText } from "../format";

export function download(name: string, blob: Blob): void {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}

/** 2026-11-23_14-05-09. */
export function stamp(now = Date.now() / 1000): string {
  return `${dayText(now)}_${clockText(now).replace(/:/g, "-")}`;
}
