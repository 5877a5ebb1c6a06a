// Light, dark, or as set in the system.
import { remember, remembered } from "./kept";
import { Store } from "./live/store";

export const themes = ["auto", "light", "dark"] as const;
export type Theme = (typeof themes)[number];
export const theme = new Store<Theme>("auto");

export function setTheme(to: Theme): void {
  document.documentElement.dataset.theme = to;
  remember("theme", to);
  theme.set(to);
}

export function beginTheme(): void {
  const kept = themes.find((one) => one === remembered("theme")) ?? "auto";
  document.documentElement.dataset.theme = kept;
  theme.set(kept);
}
