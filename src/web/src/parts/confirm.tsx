// Asks for confirmation before an action that moves something or can't be undone.
import type { ComponentChildren } from "preact";
import { useEffect, useRef, useState } from "preact/hooks";
import { t } from "../i18n";

// Clicks within this time are ignored, so that the second click of a double click does not confirm.
const deafFor = 400; // milliseconds

export function Confirm({ label, question, yes, no: leave, disabled, kind, onYes }: { label: string; question: ComponentChildren; yes: string; no?: string; disabled?: boolean; kind?: string; onYes: () => void }) {
  const [asks, setAsks] = useState(false);
  const no = useRef<HTMLButtonElement>(null);
  const first = useRef<HTMLButtonElement>(null);
  const opened = useRef(0);
  useEffect(() => {
    if (asks) no.current?.focus();
  }, [asks]);
  const close = (): void => {
    setAsks(false);
    setTimeout(() => first.current?.focus(), 0);
  };
  if (!asks) return <button ref={first} type="button" class={kind ?? ""} disabled={disabled} onClick={() => { opened.current = performance.now(); setAsks(true); }}>{label}</button>;
  return (
    <span class="confirm" role="group" aria-label={label} onKeyDown={(event) => { if (event.key === "Escape") close(); }}>
      <b>{question}</b>
      <button type="button" class="main" onClick={() => { if (performance.now() - opened.current < deafFor) return; close(); onYes(); }}>{yes}</button>
      <button ref={no} type="button" onClick={close}>{leave ?? t("cancel")}</button>
    </span>
  );
}
