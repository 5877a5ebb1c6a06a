// The parameters of a device. Writes only changed ones, and shows the values that the device has stored.
import { useState } from "preact/hooks";
import { ask, type Answer } from "../api";
import { deviceText, t, useLanguage } from "../i18n";
import { path } from "../live/device";
import { mayAct } from "../live/gateway";
import { cancel } from "../live/jobs";
import { useAsked } from "../live/running";
import { JobLine, OutcomeLine, refusalText, useAction } from "../parts/action";
import { Confirm } from "../parts/confirm";
import { download, stamp } from "../parts/download";
import { finder } from "../finder";
import { draftOf, setDraft } from "../live/edits";
import { useStore } from "../live/store";
import { DeviceHeading, DeviceText } from "../parts/device_text";
import { changesOf, faultOf, fileOf, has, isCalibration, isSame, keyed, named, strangerIn, valuesIn, type Parameter } from "../parts/parameter_set";

interface All {
  device: { address: string; name?: string; sw?: number };
  parameters: Parameter[];
}
interface Written {
  name: string;
  stored?: number | string;
  written?: number | string;
  clamped?: boolean;
  state: string;
  what?: string;
}

function Row({ parameter, typed, file, end, disabled, onType }: { parameter: Parameter; typed: string | undefined; file: string | undefined; end: Written | undefined; disabled: boolean; onType: (text: string | undefined) => void }) {
  const id = "parameter-" + parameter.id;
  const changed = typed !== undefined && !isSame(parameter.value, typed, parameter.type);
  const fault = changed ? faultOf(parameter, typed) : undefined;
  const differs = file !== undefined && !isSame(parameter.value, file, parameter.type);
  return (
    <li class={changed ? "changed" : ""}>
      <label for={id}><b><DeviceText text={parameter.key} /></b> <small>{parameter.type ?? ""}{parameter.mul !== undefined ? ` / ${parameter.mul}` : ""}{parameter.min !== undefined ? ` ${parameter.min}…${parameter.max}` : ""}</small></label>
      <input id={id} disabled={disabled || parameter.missing === true || parameter.unreadable !== undefined} value={typed ?? String(parameter.value ?? "")} aria-invalid={fault !== undefined} aria-describedby={id + "-text"} onInput={(event) => onType(event.currentTarget.value)} />
      <span id={id + "-text"} class="about">
        {fault && <b class="bad fault">{t(fault.key, "min" in fault ? { min: fault.min, max: fault.max } : {})} </b>}
        {parameter.unreadable && <span class="bad">{t("parameter_unreadable", { bytes: parameter.unreadable })} </span>}
        {parameter.missing && <span class="bad">{t("parameter_missing")} </span>}
        {changed && <button class="plain" onClick={() => onType(undefined)}>{t("undo_to", { value: String(parameter.value ?? "–") })}</button>}
        {differs && <button class="plain warn" onClick={() => onType(file)}>{t("file_says", { value: file })}</button>}
        {end && <span class={end.state === "failed" ? "bad" : end.clamped ? "warn" : "good"}>{end.state === "failed" ? <DeviceText text={end.what} /> : end.clamped ? t("stored_clamped", { value: String(end.stored) }) : end.stored !== undefined ? t("stored", { value: String(end.stored) }) : end.state} </span>}
        <span class="muted"><DeviceText text={deviceText(parameter.text)} /></span>
      </span>
    </li>
  );
}

type Which = "all" | "changed" | "file" | "defaults";

/** By key of the parameter. */
type Typed = Record<string, string>;
const nothing: Typed = {};

export function Parameters({ device }: { device: number }) {
  useLanguage();
  const [all, setAll] = useState<All>();
  const { job, fault, run, read } = useAsked<All>(path(device, "parameters"), (read) => setAll({ ...read, parameters: keyed(read.parameters) }));
  const draft = draftOf<Typed>("parameters", device), typed = useStore(draft) ?? nothing;
  const setTyped = (change: (before: Typed) => Typed): void => {
    const after = change(draft.get() ?? nothing);
    setDraft("parameters", device, Object.keys(after).length > 0 ? after : undefined);
  };
  const [file, setFile] = useState<Record<string, string>>();
  const [stranger, setStranger] = useState<string>();
  const [ends, setEnds] = useState<Record<string, Written>>({});
  const [search, setSearch] = useState("");
  const [which, setWhich] = useState<Which>("all");
  const action = useAction();
  const parameters = all?.parameters ?? [];
  const changes = changesOf(parameters, typed);
  const [calibration, setCalibration] = useState(false);
  const differing = changesOf(parameters, Object.fromEntries(Object.entries(file ?? {}).filter(([name]) => calibration || !isCalibration(name))));
  const hasCalibration = Object.keys(file ?? {}).some(isCalibration);
  const unknown = Object.keys(file ?? {}).filter((name) => all && !parameters.some((one) => one.key === name));
  const count = Object.keys(changes).length;
  const faults = parameters.filter((one) => has(changes, one.key) && faultOf(one, changes[one.key]!)).length;

  const stored = (written: Written[]): void => {
    setEnds((before) => ({ ...before, ...Object.fromEntries(written.map((one) => [one.name, one])) }));
    const now = new Map(written.filter((one) => one.stored !== undefined).map((one) => [one.name, one.stored!]));
    setAll((before) => before && { ...before, parameters: before.parameters.map((one) => (now.has(one.key) ? { ...one, value: now.get(one.key)! } : one)) });
    const done = new Set(written.filter((one) => one.state === "written" || one.state === "same").map((one) => one.name));
    setTyped((before) => Object.fromEntries(Object.entries(before).filter(([name]) => !done.has(name))));
  };
  const write = (): void =>
    action.run(
      async (): Promise<Answer<{ parameters: Written[] }>> => {
        const answer = await run<{ parameters: Written[] }>({ method: "POST", body: { parameters: changes } }, path(device, "apply"));
        const result = answer.ok ? answer.value : (answer.refusal.body as { parameters?: Written[] } | undefined);
        const keys = Object.keys(changes); // the gateway reports the rows in this order, and only with their names
        if (Array.isArray(result?.parameters)) stored(result.parameters.map((one, i) => ({ ...one, name: has(changes, one.name) ? one.name : (keys[i] ?? one.name) })));
        return answer;
      },
      (value) => t("written_n", { n: value.parameters.filter((one) => one.state === "written").length, clamped: value.parameters.filter((one) => one.clamped).length }),
    );
  const act = (name: "save" | "restore_defaults"): void =>
    action.run(
      async () => {
        const answer = await ask(path(device, "actions"), { method: "POST", body: { action: name } });
        if (answer.ok && name === "restore_defaults") void read();
        return answer;
      },
      () => (name === "save" ? t("saved_in_device") : t("defaults_restored")),
    );
  const load = async (from: File | undefined): Promise<void> => {
    if (!from) return;
    const text = from.size < 1e6 ? await from.text() : "";
    const values = valuesIn(text);
    if (!values) return action.say({ words: t("no_parameter_file", { name: from.name }), good: false });
    setFile(values);
    setStranger(all && strangerIn(text, all.device));
    setWhich("file");
  };
  const isFound = finder(search);
  const shown = parameters.filter((one) => {
    if (which === "changed" && !has(changes, one.key)) return false;
    if (which === "defaults") return false;
    if (which === "file" && !has(differing, one.key) && !has(changes, one.key)) return false;
    return isFound(`${one.key} ${one.text ?? ""}`);
  });
  return (
    <div>
      <DeviceHeading title={t("parameters")} device={device} name={all?.device.name} />
      <div class="tools">
        <input type="search" aria-label={t("search")} placeholder={t("search_parameters")} value={search} onInput={(event) => setSearch(event.currentTarget.value)} />
        <select aria-label={t("direction")} value={which} onChange={(event) => setWhich(event.currentTarget.value as Which)}>
          <option value="all">{t("any")}</option>
          <option value="changed">{t("show_changed", { n: count })}</option>
          {!file && <option value="defaults">{t("show_defaults")}</option>}
          {file && <option value="file">{t("show_file", { n: Object.keys(differing).length })}</option>}
        </select>
        <button disabled={job !== undefined} onClick={() => void read()}>{t("read_again")}</button>
        <button disabled={!all} onClick={() => all && download(`${all.device.name || "device"}_${stamp()}.json`, new Blob([fileOf(all.device, all.parameters)], { type: "application/json" }))}>{t("export")}</button>
        <label class="file">{t("compare_file")}<input type="file" accept=".json,application/json" onChange={(event) => void load(event.currentTarget.files?.[0])} /></label>
      </div>
      {mayAct() && (
        <div class="tools">
          <button class="main" disabled={count === 0 || faults > 0 || action.busy} onClick={write}>{t("write_n", { n: count })}</button>
          {faults > 0 && <span class="bad">{t("fix_first", { n: faults })}</span>}
          {hasCalibration && <label class="check"><input type="checkbox" checked={calibration} onChange={() => setCalibration(!calibration)} />{t("with_calibration")}</label>}
          {file && Object.keys(differing).length > 0 && <button onClick={() => setTyped((before) => ({ ...before, ...differing }))}>{t("take_from_file", { n: Object.keys(differing).length })}</button>}
          <button disabled={action.busy || !all} onClick={() => act("save")}>{t("save_in_device")}</button>
          <Confirm label={t("restore_defaults")} question={t("restore_question")} yes={t("restore_defaults")} disabled={action.busy || !all} onYes={() => act("restore_defaults")} />
          <OutcomeLine action={action} />
        </div>
      )}
      {stranger && <p class="note warn stranger" role="alert">{t("file_of_another", { whose: stranger.slice(0, 40) })}</p>}
      {which === "defaults" && <p class="note">{t("defaults_unknown")}</p>}
      {unknown.length > 0 && <p class="note warn">{t("file_unknown", { names: unknown.slice(0, 8).join(", ") + (unknown.length > 8 ? " …" : "") })}</p>}
      <JobLine job={job} {...(job && mayAct() ? { onCancel: () => void cancel(job) } : {})} />
      {fault && <p class="bad" role="alert"><DeviceText text={refusalText(fault)} /></p>}
      <ul class="set card">
        {shown.map((one) => (
          <Row key={one.id} parameter={one} typed={named(typed, one.key)} file={named(file, one.key)} end={named(ends, one.key)} disabled={!mayAct() || action.busy}
            onType={(text) => setTyped((before) => (text === undefined || text === String(one.value ?? "") ? Object.fromEntries(Object.entries(before).filter(([other]) => other !== one.key)) : { ...before, [one.key]: text }))} />
        ))}
      </ul>
      {all && shown.length === 0 && which !== "defaults" && <p class="muted">{t("nothing_fits")}</p>}
    </div>
  );
}
