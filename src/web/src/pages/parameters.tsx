// The parameters of a device: writes only the changed ones, and shows the values that the device stored.
import { useEffect, useState } from "preact/hooks";
import { nameOf as nameOfAddress } from "../addresses";
import { ask, type Answer } from "../api";
import { t, useLanguage } from "../i18n";
import { path } from "../live/device";
import { mayAct } from "../live/gateway";
import { cancel, follow, type Job } from "../live/jobs";
import { JobLine, OutcomeLine, refusalText, useAction } from "../parts/action";
import { Confirm } from "../parts/confirm";
import { download, stamp } from "../parts/download";
import { draftOf, setDraft } from "../live/edits";
import { useStore } from "../live/store";
import { DeviceText } from "../parts/device_text";
import { changesOf, faultOf, fileOf, has, isCalibration, isSame, named, nameOf, strangerIn, valuesIn, type Parameter } from "../parts/parameter_set";
import { hexByte } from "../protocol/table";

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

function useParameters(device: number) {
  const [all, setAll] = useState<All>();
  const [job, setJob] = useState<Job>();
  const [fault, setFault] = useState("");
  const read = async (): Promise<void> => {
    setFault("");
    const answer = await follow<All>(path(device, "parameters"), {}, setJob);
    setJob(undefined);
    if (answer.ok) setAll(answer.value);
    else setFault(refusalText(answer.refusal));
  };
  useEffect(() => void read(), [device]);
  return { all, setAll, job, setJob, fault, read };
}

function Row({ parameter, typed, file, end, disabled, onType }: { parameter: Parameter; typed: string | undefined; file: string | undefined; end: Written | undefined; disabled: boolean; onType: (text: string | undefined) => void }) {
  const name = nameOf(parameter);
  const id = "parameter-" + parameter.id;
  const changed = typed !== undefined && !isSame(parameter.value, typed, parameter.type);
  const fault = changed ? faultOf(parameter, typed) : undefined;
  const differs = file !== undefined && !isSame(parameter.value, file, parameter.type);
  return (
    <li class={changed ? "changed" : ""}>
      <label for={id}><b><DeviceText text={name} /></b> <small>{parameter.type ?? ""}{parameter.mul !== undefined ? ` / ${parameter.mul}` : ""}{parameter.min !== undefined ? ` ${parameter.min}…${parameter.max}` : ""}</small></label>
      <input id={id} disabled={disabled || parameter.missing === true || parameter.unreadable !== undefined} value={typed ?? String(parameter.value ?? "")} aria-invalid={fault !== undefined} aria-describedby={id + "-text"} onInput={(event) => onType(event.currentTarget.value)} />
      <span id={id + "-text"} class="about">
        {fault && <b class="bad fault">{t(fault.key, "min" in fault ? { min: fault.min, max: fault.max } : {})} </b>}
        {parameter.unreadable && <span class="bad">{t("parameter_unreadable", { bytes: parameter.unreadable })} </span>}
        {parameter.missing && <span class="bad">{t("parameter_missing")} </span>}
        {changed && <button class="plain" onClick={() => onType(undefined)}>{t("undo_to", { value: String(parameter.value ?? "–") })}</button>}
        {differs && <button class="plain warn" onClick={() => onType(file)}>{t("file_says", { value: file })}</button>}
        {end && <span class={end.state === "failed" ? "bad" : end.clamped ? "warn" : "good"}>{end.state === "failed" ? <DeviceText text={end.what} /> : end.clamped ? t("stored_clamped", { value: String(end.stored) }) : end.stored !== undefined ? t("stored", { value: String(end.stored) }) : end.state} </span>}
        <span class="muted"><DeviceText text={parameter.text} /></span>
      </span>
    </li>
  );
}

type Which = "all" | "changed" | "file" | "defaults";

/** By the name of the parameter. */
type Typed = Record<string, string>;
const nothing: Typed = {};

export function Parameters({ device }: { device: number }) {
  useLanguage();
  const { all, setAll, job, setJob, fault, read } = useParameters(device);
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
  const unknown = Object.keys(file ?? {}).filter((name) => all && !parameters.some((one) => nameOf(one) === name));
  const count = Object.keys(changes).length;
  const faults = parameters.filter((one) => has(changes, nameOf(one)) && faultOf(one, changes[nameOf(one)]!)).length;

  const stored = (written: Written[]): void => {
    setEnds((before) => ({ ...before, ...Object.fromEntries(written.map((one) => [one.name, one])) }));
    const now = new Map(written.filter((one) => one.stored !== undefined).map((one) => [one.name, one.stored!]));
    setAll((before) => before && { ...before, parameters: before.parameters.map((one) => (now.has(nameOf(one)) ? { ...one, value: now.get(nameOf(one))! } : one)) });
    const done = new Set(written.filter((one) => one.state === "written" || one.state === "same").map((one) => one.name));
    setTyped((before) => Object.fromEntries(Object.entries(before).filter(([name]) => !done.has(name))));
  };
  const write = (): void =>
    action.run(
      async (): Promise<Answer<{ parameters: Written[] }>> => {
        const answer = await follow<{ parameters: Written[] }>(path(device, "apply"), { method: "POST", body: { parameters: changes } }, setJob);
        setJob(undefined);
        const result = answer.ok ? answer.value : (answer.refusal.body as { parameters?: Written[] } | undefined);
        if (Array.isArray(result?.parameters)) stored(result.parameters);
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
  const words = search.toLowerCase().split(/\s+/).filter(Boolean);
  const shown = parameters.filter((one) => {
    const name = nameOf(one);
    if (which === "changed" && !has(changes, name)) return false;
    if (which === "defaults") return false;
    if (which === "file" && !has(differing, name) && !has(changes, name)) return false;
    const text = `${name} ${one.text ?? ""}`.toLowerCase();
    return words.every((word) => text.includes(word));
  });
  return (
    <div class="parameters">
      <h1>{t("parameters")} <small class="muted"><DeviceText text={all?.device.name ?? nameOfAddress(device)} /> {hexByte(device)}</small></h1>
      <div class="tools">
        <input type="search" aria-label={t("search")} placeholder={t("search_parameters")} value={search} onInput={(event) => setSearch(event.currentTarget.value)} />
        <select aria-label={t("direction")} value={which} onChange={(event) => setWhich(event.currentTarget.value as Which)}>
          <option value="all">{t("show_all")}</option>
          <option value="changed">{t("show_changed", { n: count })}</option>
          {!file && <option value="defaults">{t("show_defaults")}</option>}
          {file && <option value="file">{t("show_file", { n: Object.keys(differing).length })}</option>}
        </select>
        <button disabled={job !== undefined} onClick={() => void read()}>{t("read_again")}</button>
        <button disabled={!all} onClick={() => all && download(`${all.device.name || "device"}_${stamp()}.json`, new Blob([fileOf(all.device, all.parameters)], { type: "application/json" }))}>{t("export")}</button>
        <label class="file button">{t("compare_file")}<input type="file" accept=".json,application/json" onChange={(event) => void load(event.currentTarget.files?.[0])} /></label>
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
      {fault && <p class="bad" role="alert"><DeviceText text={fault} /></p>}
      <ul class="set card">
        {shown.map((one) => {
          const name = nameOf(one);
          return (
            <Row key={one.id} parameter={one} typed={named(typed, name)} file={named(file, name)} end={named(ends, name)} disabled={!mayAct() || action.busy}
              onType={(text) => setTyped((before) => (text === undefined || text === String(one.value ?? "") ? Object.fromEntries(Object.entries(before).filter(([other]) => other !== name)) : { ...before, [name]: text }))} />
          );
        })}
      </ul>
      {all && shown.length === 0 && which !== "defaults" && <p class="muted">{t("nothing_fits")}</p>}
    </div>
  );
}
