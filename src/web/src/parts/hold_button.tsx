// A button that must be held down by finger, mouse or key, so that an accidental touch has no effect.
import { useEffect, useRef, useState } from "preact/hooks";
import { t } from "../i18n";

export const holdFor = 800; // milliseconds

/** Releases the pointer capture of a touch: with it, the button gets no event when the finger slips off. */
function letGo(event: PointerEvent): void {
  const at = event.currentTarget as Element;
  if (at.hasPointerCapture(event.pointerId)) at.releasePointerCapture(event.pointerId);
}

export function HoldButton({ label, kind, disabled, onHeld }: { label: string; kind?: string; disabled?: boolean; onHeld: () => void }) {
  const timer = useRef<ReturnType<typeof setTimeout> | undefined>(undefined);
  const [held, setHeld] = useState(false);
  const stop = (): void => {
    clearTimeout(timer.current);
    timer.current = undefined;
    setHeld(false);
  };
  const start = (): void => {
    if (disabled || timer.current !== undefined) return;
    setHeld(true);
    timer.current = setTimeout(() => {
      stop();
      navigator.vibrate?.(60);
      onHeld();
    }, holdFor);
  };
  useEffect(() => stop, []);
  const isHoldKey = (event: KeyboardEvent): boolean => event.key === " " || event.key === "Enter";
  return (
    <button
      type="button"
      class={`hold ${kind ?? ""} ${held ? "held" : ""}`}
      disabled={disabled}
      title={t("hold_hint")}
      aria-label={`${label}: ${t("hold_hint")}`}
      onPointerDown={(event) => { if (event.button === 0) { letGo(event); start(); } }}
      onPointerUp={stop}
      onPointerLeave={stop}
      onPointerCancel={stop}
      onContextMenu={(event) => event.preventDefault()}
      onKeyDown={(event) => { if (isHoldKey(event)) { event.preventDefault(); if (!event.repeat) start(); } }}
      onKeyUp={(event) => { if (isHoldKey(event)) stop(); }}
      onBlur={stop}
    >
      <span>{label}</span>
    </button>
  );
}
