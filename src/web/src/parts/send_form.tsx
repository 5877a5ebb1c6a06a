// Sends a frame from a form based on the message table, and shows the links that sent, queued or dropped it.
import { useState } from "preact/hooks";
import { ask } from "../api";
import { causeText, faultText, t, titleText } from "../i18n";
import { isNumber, isNumeric, type FieldRow, type MessageRow, type MessageTable } from "../protocol/table";
import { frameOf } from "./frame_of";

interface Place {
  link: string;
  peer?: string;
  cause?: string;
}
interface Fate {
  sent?: Place[];
  waiting?: Place[];
  dropped?: Place[];
  taken_by?: string;
}

const linksOf = (places: Place[] | undefined): string => [...new Set((places ?? []).map((place) => place.link + (place.cause ? ` (${causeText(place.cause)})` : "")))].join(", ");

function fateText(fate: Fate): string {
  const parts: string[] = [];
  if (fate.taken_by) parts.push(t("taken_by_gateway"));
  if (fate.sent?.length) parts.push(t("sent_by", { links: linksOf(fate.sent) }));
  if (fate.waiting?.length) parts.push(t("waits_at", { links: linksOf(fate.waiting) }));
  if (fate.dropped?.length) parts.push(t("dropped_at", { links: linksOf(fate.dropped) }));
  return parts.join("; ");
}

function FieldInput({ field, value, onInput }: { field: FieldRow; value: string; onInput: (text: string) => void }) {
  const id = "send-" + field.name;
  const label = (
    <label for={id}>{field.label ?? field.name}{field.unit ? <small> {field.unit}</small> : null}</label>
  );
  if (field.values && isNumber(field))
    return (
      <div class="field">
        {label}
        <input id={id} list={id + "-list"} inputMode="decimal" value={value} placeholder="0" onInput={(event) => onInput(event.currentTarget.value)} />
        <datalist id={id + "-list"}>{Object.entries(field.values).map(([number, words]) => <option key={number} value={number}>{words}</option>)}</datalist>
      </div>
    );
  const hint = field.type === "bytes" || field.type === "frames" ? "hex" : field.type === "ip" ? "192.168.0.1" : field.type === "text" ? "" : "0";
  return (
    <div class="field">
      {label}
      <input id={id} value={value} placeholder={hint} inputMode={isNumeric(field.type) ? "decimal" : "text"} onInput={(event) => onInput(event.currentTarget.value)} />
    </div>
  );
}

const keyOf = (row: MessageRow): string => `${row.id} ${row.layout ?? ""} ${row.source ?? ""}`;

export function SendForm({ of, onClose }: { of: MessageTable; onClose: () => void }) {
  const rows = of.rows.filter((row) => row.fields.every((field) => field.type !== "list" && field.type !== "frames"));
  const [key, setKey] = useState(keyOf(rows.find((row) => row.name === "parameter_command") ?? rows[0]!));
  const [from, setFrom] = useState("0xFE");
  const [to, setTo] = useState("0xFF");
  const [values, setValues] = useState<Record<string, string>>({});
  const [outcome, setOutcome] = useState<{ words: string; bad: boolean }>();
  const [busy, setBusy] = useState(false);
  const row = rows.find((one) => keyOf(one) === key) ?? rows[0]!;
  const send = async (event: Event): Promise<void> => {
    event.preventDefault();
    if (busy) return;
    const frame = frameOf(row, from, to, values);
    if ("fault" in frame) return setOutcome({ words: t("bad_number", { name: frame.fault }), bad: true });
    setBusy(true);
    const answer = await ask<Fate>("/send", { method: "POST", body: frame.frame, timeout: 5000 });
    setBusy(false);
    setOutcome(answer.ok ? { words: fateText(answer.value), bad: false } : { words: t("refused", { why: faultText(answer.refusal) || t("no_contact") }), bad: true });
  };
  return (
    <form class="card send" aria-label={t("send_frame")} onSubmit={(event) => void send(event)}>
      <p class="muted">{t("send_moves")}</p>
      <div class="fields">
        <div class="field wide">
          <label for="send-message">{t("message")}</label>
          <select id="send-message" value={key} onChange={(event) => { setKey(event.currentTarget.value); setValues({}); setOutcome(undefined); }}>
            {rows.map((one) => <option key={keyOf(one)} value={keyOf(one)}>{one.name}{one.layout ? ` · ${one.layout}` : ""}: {titleText(one.name, one.title)}</option>)}
          </select>
          <small class="full muted">{titleText(row.name, row.title)}</small>
        </div>
        <div class="field"><label for="send-from">{t("from")}</label><input id="send-from" value={from} onInput={(event) => setFrom(event.currentTarget.value)} /></div>
        <div class="field"><label for="send-to">{t("to")}</label><input id="send-to" value={to} onInput={(event) => setTo(event.currentTarget.value)} /></div>
        {row.fields.map((field) => (
          <FieldInput key={field.name} field={field} value={values[field.name] ?? ""} onInput={(text) => setValues({ ...values, [field.name]: text })} />
        ))}
      </div>
      <div class="tools">
        <button class="main" disabled={busy}>{busy ? t("sending") : t("send")}</button>
        <button type="button" onClick={onClose}>{t("close")}</button>
        <span role="status" class={outcome?.bad ? "bad" : "good"}>{outcome?.words}</span>
      </div>
    </form>
  );
}
