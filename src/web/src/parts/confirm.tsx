// A question before what moves something or can't be taken back.
import type { ComponentChildren } from "preact";
import { useEffect, useRef, useState } from "preact/hooks";
import { t } from "../i18n";

export function Confirm({ label, question, yes, disabled, kind, onYes }: { label: string; question: ComponentChildren; yes: string; disabled?: boolean; kind?: string; onYes: () => void }) {
  const [asks, setAsks] = useState(false);
  const no = useRef<HTMLButtonElement>(null);
  const first = useRef<HTMLButtonElement>(null);
  useEffect(() => {
    if (asks) no.current?.focus();
  }, [asks]);
  const close = (): void => {
    setAsks(false);
    setTimeout(() => first.current?.focus(), 0);
  };
  if (!asks) return <button ref={first} type="button" class={kind ?? ""} disabled={disabled} onClick={() => setAsks(true)}>{label}</button>;
  return (
    <span class="confirm" role="group" aria-label={label} onKeyDown={(event) => { if (event.key === "Escape") close(); }}>
      <b>{question}</b>
      <button type="button" class="main" onClick={() => { close(); onYes(); }}>{yes}</button>
      <button ref={no} type="button" onClick={close}>{t("cancel")}</button>
    </span>
  );
}
