// The alarm limits of a device, stored in the gateway for all viewers.
import { useEffect, useMemo, useState } from "preact/hooks";
import { entryOf } from "../entries";
import { significant } from "../format";
import { t, titleText, useLanguage, type Key } from "../i18n";
import { mayAct, table } from "../live/gateway";
import { draftOf, setDraft } from "../live/edits";
import { keptLimits, readLimits, writeLimits } from "../live/kept_limits";
import { keyOf, type Limit } from "../live/limits";
import { isTelemetry } from "../live/presence";
import { useStore, useTick } from "../live/store";
import { alarms } from "../live/watch";
import { OutcomeLine, refusalText, useAction } from "../parts/action";
import { limitWords } from "../parts/alerts";
import { numberIn } from "../parts/numbers";
import { DeviceHeading, DeviceText } from "../parts/device_text";
import { isFlexible, isNumber, type MessageTable } from "../protocol/table";

/** A limit as typed, in the units shown to users. */
interface Draft {
  field: string;
  side: "below" | "above";
  amber: string;
  red: string;
  cells: string;
  for_s: string;
}

const usual: { title: Key; draft: Draft }[] = [
  { title: "limit_cell", draft: { field: "power.voltage", side: "below", amber: "3.6", red: "3.4", cells: "4", for_s: "2" } },
  { title: "limit_satellites", draft: { field: "gps.s_num", side: "below", amber: "10", red: "6", cells: "", for_s: "2" } },
  { title: "limit_distance", draft: { field: "return_home.r_d", side: "above", amber: "300", red: "500", cells: "", for_s: "0" } },
  { title: "limit_altitude", draft: { field: "altitude.alt_fu", side: "above", amber: "100", red: "120", cells: "", for_s: "0" } },
];

const text = (value: number | undefined, factor: number): string => (value === undefined ? "" : significant(value * factor, 9));

function formOf(limit: Limit): Draft {
  const { factor } = limitWords(limit);
  return { field: limit.field, side: limit.side, amber: text(limit.amber, factor), red: text(limit.red, factor), cells: text(limit.cells, 1), for_s: limit.for_s > 0 ? text(limit.for_s, 1) : "" };
}

/** The limit, or the key of the error text. */
function limitOf(draft: Draft): Limit | Key {
  const { factor } = limitWords({ field: draft.field, cells: undefined });
  const read = (typed: string): number | undefined => (typed.trim() === "" ? undefined : (numberIn(typed) ?? Number.NaN));
  const amber = read(draft.amber), red = read(draft.red), cells = read(draft.cells), for_s = read(draft.for_s) ?? 0;
  if ([amber, red, cells, for_s].some((one) => one !== undefined && Number.isNaN(one))) return "not_a_number";
  if (amber === undefined && red === undefined) return "limit_needs_value";
  if (amber !== undefined && red !== undefined && (draft.side === "below" ? red > amber : red < amber)) return "red_beyond_amber";
  if (cells !== undefined && (!Number.isInteger(cells) || cells < 1 || cells > 32)) return "cells_range";
  if (for_s < 0 || for_s > 60) return "for_range";
  const inTable = (value: number | undefined): number | undefined => (value === undefined ? undefined : Number((value / factor).toPrecision(12)));
  return { key: keyOf(draft), field: draft.field, side: draft.side, amber: inTable(amber), red: inTable(red), cells, for_s };
}

/** A field that may be the charge of the battery. The protocol has none, but a flexible message of the device may. */
const percentOf = (of: MessageTable | undefined, device: number): string | undefined => {
  const rows = (of?.rows ?? []).filter((row) => isFlexible(row.id) && (row.source === undefined || row.source === device));
  const all = rows.flatMap((row) => row.fields.filter((field) => field.unit === "%" && isNumber(field)).map((field) => `${row.name}.${field.name}`));
  return all.find((name) => /batt|soc|charge|capacity|percent|电/i.test(name)) ?? all[0];
};

/** All number fields that a device may send as telemetry, by message. */
const fieldsOf = (of: MessageTable | undefined): { message: string; fields: string[] }[] => {
  const found = new Map<string, Set<string>>();
  for (const row of of?.rows ?? [])
    for (const field of row.fields)
      if (isNumber(field) && isTelemetry(row.id)) entryOf(found, row.name, () => new Set<string>()).add(field.name);
  return [...found].map(([message, fields]) => ({ message, fields: [...fields] }));
};

function Row({ draft, level, disabled, onChange, onRemove }: { draft: Draft; level: string; disabled: boolean; onChange: (change: Partial<Draft>) => void; onRemove: () => void }) {
  const words = limitWords({ field: draft.field, cells: draft.cells ? 1 : undefined }), limit = limitOf(draft);
  const input = (name: "amber" | "red" | "cells" | "for_s", label: string, unit: string) => (
    <label>{label} <small>{unit}</small>
      <input inputMode="decimal" disabled={disabled} value={draft[name]} onInput={(event) => onChange({ [name]: event.currentTarget.value })} />
    </label>
  );
  return (
    <li class={`limit card ${level}`}>
      <div class="of-what"><b>{words.label}</b> <code class="muted">{draft.field}</code></div>
      <label>{t("limit_side")}
        <select disabled={disabled} value={draft.side} onChange={(event) => onChange({ side: event.currentTarget.value as Draft["side"] })}>
          <option value="below">{t("limit_below")}</option>
          <option value="above">{t("limit_above")}</option>
        </select>
      </label>
      {input("amber", t("limit_amber"), words.unit)}
      {input("red", t("limit_red"), words.unit)}
      {input("cells", t("limit_cells"), "")}
      {input("for_s", t("limit_for"), "s")}
      {!disabled && <button type="button" class="plain" aria-label={`${t("remove")} ${words.label}`} onClick={onRemove}>✕</button>}
      {typeof limit === "string" && <p class="bad fault">{t(limit)}</p>}
    </li>
  );
}

export function Alarms({ device }: { device: number }) {
  useLanguage();
  useTick(500);
  const of = useStore(table), kept = useStore(keptLimits).get(device), beyond = useStore(alarms);
  const drafts = useStore(draftOf<Draft[]>("alarms", device)); // undefined: unchanged, as stored in the gateway
  const setDrafts = (changed: Draft[] | undefined): void => setDraft("alarms", device, changed);
  const [fault, setFault] = useState("");
  const action = useAction();
  useEffect(() => {
    void readLimits(device).then((answer) => setFault(answer.ok ? "" : refusalText(answer.refusal)));
  }, [device]);
  const fields = useMemo(() => fieldsOf(of), [of]);
  const shown = drafts ?? (kept?.limits ?? []).map(formOf);
  const limits = shown.map(limitOf);
  const keys = limits.map((one) => (typeof one === "string" ? "" : one.key));
  const isDouble = keys.some((key, i) => key !== "" && keys.indexOf(key) !== i);
  const isGood = !isDouble && limits.every((one) => typeof one !== "string");
  const may = mayAct() && !action.busy;
  const add = (draft: Draft): void => setDrafts([...shown, draft]);
  const save = (): void => action.run(async () => {
    const answer = await writeLimits(device, limits.filter((one): one is Limit => typeof one !== "string"));
    if (answer.ok) setDrafts(undefined);
    return answer;
  }, (value) => t(value.kept === false ? "limits_not_kept" : "limits_saved"));
  const percent = useMemo(() => percentOf(of, device), [of, device]);
  const missing = usual.filter(({ draft }) => !shown.some((one) => one.field === draft.field && one.side === draft.side));
  return (
    <div>
      <DeviceHeading title={t("alarms")} device={device} />
      <p class="muted">{t("alarms_about")}</p>
      {fault && <p class="bad" role="alert"><DeviceText text={fault} /></p>}
      {shown.length === 0 && <p class="muted">{t("no_limits")}</p>}
      <ul class="limits">
        {shown.map((draft, i) => (
          <Row key={i} draft={draft} disabled={!may} level={beyond.find((one) => one.device === device && one.limit.key === keyOf(draft))?.level ?? ""}
            onChange={(change) => setDrafts(shown.map((one, k) => (k === i ? { ...one, ...change } : one)))} onRemove={() => setDrafts(shown.filter((_, k) => k !== i))} />
        ))}
      </ul>
      {mayAct() && (
        <>
          <div class="tools">
            {missing.map(({ title, draft }) => <button key={draft.field} type="button" disabled={!may} onClick={() => add(draft)}>+ {t(title)}</button>)}
            {!shown.some((one) => one.field === percent && one.side === "below") && (
              <button type="button" disabled={!may || percent === undefined} title={percent === undefined ? t("no_percent") : percent}
                onClick={() => percent !== undefined && add({ field: percent, side: "below", amber: "30", red: "15", cells: "", for_s: "2" })}>+ {t("limit_percent")}</button>
            )}
            <select aria-label={t("limit_other")} disabled={!may} value="" onChange={(event) => { const field = event.currentTarget.value; event.currentTarget.value = ""; if (field) add({ field, side: "above", amber: "", red: "", cells: "", for_s: "" }); }}>
              <option value="">+ {t("limit_other")}</option>
              {fields.map(({ message, fields: names }) => (
                <optgroup key={message} label={`${message} · ${titleText(message, "")}`}>
                  {names.map((name) => <option key={name} value={`${message}.${name}`}>{message}.{name}</option>)}
                </optgroup>
              ))}
            </select>
          </div>
          {percent === undefined && <p class="muted">{t("no_percent")}</p>}
          {isDouble && <p class="bad">{t("limit_double")}</p>}
          <div class="tools">
            <button class="main" disabled={!may || !isGood || drafts === undefined} onClick={save}>{t("save_limits")}</button>
            {drafts !== undefined && <button type="button" onClick={() => setDrafts(undefined)}>{t("discard")}</button>}
            <OutcomeLine action={action} />
          </div>
        </>
      )}
    </div>
  );
}
