// Waypoints, on the ground and in a table.
import { useState } from "preact/hooks";
import { nameOf } from "../addresses";
import { ask } from "../api";
import { t, useLanguage } from "../i18n";
import { jsonIn } from "../json";
import { path } from "../live/device";
import { draftOf, setDraft } from "../live/edits";
import { mayAct } from "../live/gateway";
import { useAsked } from "../live/running";
import { useStore } from "../live/store";
import { JobLine, OutcomeLine, refusalText, useAction } from "../parts/action";
import { DeviceHeading, DeviceText } from "../parts/device_text";
import { Confirm } from "../parts/confirm";
import { download, stamp } from "../parts/download";
import { numberIn } from "../parts/numbers";
import type { Scene } from "../parts/ground";
import { Track } from "../parts/track";
import { foreignForm, isPlace, onEarth, onGround, waypointsIn, type Waypoint } from "../parts/waypoint_set";

type Column = "lng" | "lat" | "alt" | "spd" | "yaw" | "fun";
const columns: { name: Column; unit: string; factor: number }[] = [
  { name: "lng", unit: "°", factor: 1 }, { name: "lat", unit: "°", factor: 1 }, { name: "alt", unit: "m", factor: 100 },
  { name: "spd", unit: "m/s", factor: 100 }, { name: "yaw", unit: "°", factor: 1 }, { name: "fun", unit: "", factor: 1 },
];

/** An input for a number. Text that is not a number stays in the field, but does not change the value. */
function Cell({ label, value, disabled, onValue }: { label: string; value: number; disabled: boolean; onValue: (value: number) => void }) {
  const [typed, setTyped] = useState<string>();
  const bad = typed !== undefined && numberIn(typed) === undefined;
  return (
    <input aria-label={label} aria-invalid={bad} inputMode="decimal" disabled={disabled} value={typed ?? String(value)} onBlur={() => setTyped(undefined)}
      onInput={(event) => { const text = event.currentTarget.value; setTyped(text); const number = numberIn(text); if (number !== undefined) onValue(number); }} />
  );
}

function WaypointTable({ all, disabled, onChange }: { all: Waypoint[]; disabled: boolean; onChange: (all: Waypoint[]) => void }) {
  const set = (i: number, change: Partial<Waypoint>): void => onChange(all.map((one, k) => (k === i ? { ...one, ...change } : one)));
  return (
    <div class="scroll" tabIndex={0} role="group" aria-label={t("waypoints")}>
      <table class="waypoints">
        <thead><tr><th scope="col">#</th>{columns.map((column) => <th key={column.name} scope="col">{t(`waypoint_${column.name}`)} <small>{column.unit}</small></th>)}<th scope="col">cmd 1–4</th><th><span class="hidden">{t("remove")}</span></th></tr></thead>
        <tbody>
          {all.map((one, i) => (
            <tr key={i}>
              <th scope="row">{one.num === 0 ? t("home") : one.num}</th>
              {columns.map(({ name, factor, unit }) => (
                <td key={name} data-label={`${t(`waypoint_${name}`)} ${unit}`}><Cell label={`${one.num} ${t(`waypoint_${name}`)}`} value={one[name] / factor} disabled={disabled} onValue={(value) => set(i, { [name]: factor === 1 ? value : Math.round(value * factor) })} /></td>
              ))}
              <td data-label="cmd 1–4"><input aria-label={`${one.num} cmd`} disabled={disabled} value={one.cmd.join(" ")} onChange={(event) => { const cmd = event.currentTarget.value.split(/[\s,]+/).map(Number); set(i, { cmd: [0, 1, 2, 3].map((k) => cmd[k] || 0) }); }} /></td>
              <td>{one.num !== 0 && i === all.length - 1 && <button class="plain" disabled={disabled} aria-label={`${t("remove")} ${one.num}`} onClick={() => onChange(all.slice(0, -1))}>✕</button>}</td>
            </tr>
          ))}
        </tbody>
      </table>
    </div>
  );
}

export function Waypoints({ device }: { device: number }) {
  useLanguage();
  const [stored, setStored] = useState<Waypoint[]>(); // as read from the device
  const draft = useStore(draftOf<Waypoint[]>("waypoints", device));
  const all = draft ?? stored;
  const setAll = (changed: Waypoint[]): void => setDraft("waypoints", device, JSON.stringify(changed) === JSON.stringify(stored) ? undefined : changed);
  const [foreign, setForeign] = useState<{ form: string; json: unknown; name: string }>();
  const action = useAction();
  const { job, fault, run, read } = useAsked(path(device, "waypoints"), (value) => setStored(waypointsIn(value) ?? []));
  const put = (form: string, body: unknown): void =>
    action.run(
      async () => {
        const answer = await run<{ written: number }>({ method: "PUT", body }, path(device, "waypoints" + (form ? "?format=" + form : "")));
        if (answer.ok && !form) setDraft("waypoints", device, undefined); // everything was sent
        if (answer.ok) void read();
        return answer;
      },
      (value) => t("waypoints_written", { n: value.written }),
    );
  const save = (form: "" | "geojson" | "qgc"): void =>
    action.run(
      async () => {
        if (!form) return { ok: true as const, value: { waypoints: all } as unknown, status: 200 };
        return ask<unknown>(path(device, "waypoints?format=" + form), { timeout: 60000 });
      },
      (value) => {
        const name = `${nameOf(device) || "device"}_${stamp()}.${form === "qgc" ? "plan" : form || "json"}`;
        download(name, new Blob([JSON.stringify(value, null, 1) + "\n"], { type: "application/json" }));
        return name;
      },
    );
  const load = async (from: File | undefined): Promise<void> => {
    if (!from) return;
    const json = from.size < 1e6 ? jsonIn(await from.text().catch(() => "")) : undefined;
    const own = waypointsIn(json), form = foreignForm(json);
    setForeign(form ? { form, json, name: from.name } : undefined);
    if (own) setAll(own);
    else if (!form) action.say({ words: t("no_waypoint_file", { name: from.name }), good: false });
  };
  const home = all?.find((one) => one.num === 0) ?? all?.[0];
  const marks = home && all ? all.filter((one) => one.num !== 0).map((one) => ({ ...onGround(home, one), label: String(one.num) })) : [];
  const scene: Scene = { track: [], marks, now: undefined, ...(isPlace(home) ? { origin: home } : {}) };
  const add = (): void => {
    const last = all?.[all.length - 1] ?? { num: 0, lng: 0, lat: 0, alt: 300, spd: 200, yaw: 400, fun: 0, cmd: [0, 0, 0, 0] };
    const next = home ? onEarth(home, { x: onGround(home, last).x + 10, y: onGround(home, last).y }) : last;
    setAll([...(all ?? []), { ...last, ...next, alt: last.alt || 300, spd: last.spd || 200, num: last.num + 1, yaw: 400 }]);
  };
  const may = mayAct() && !action.busy;
  return (
    <div>
      <DeviceHeading title={t("waypoints")} device={device} />
      <div class="tools">
        {mayAct() && <Confirm label={t("write_waypoints")} question={t("waypoints_question", { n: all?.length ?? 0 })} yes={t("write_waypoints")} kind="main" disabled={!all?.length || !may} onYes={() => put("", { waypoints: all })} />}
        {mayAct() && <button disabled={!may} onClick={add}>{t("add_waypoint")}</button>}
        <button disabled={job !== undefined} onClick={() => void read()}>{t("read_again")}</button>
        <button disabled={!all} onClick={() => save("")}>JSON</button>
        <button onClick={() => save("geojson")}>GeoJSON</button>
        <button onClick={() => save("qgc")}>QGC</button>
        {mayAct() && <label class="file">{t("import")}<input type="file" accept=".json,.geojson,.plan" onChange={(event) => void load(event.currentTarget.files?.[0])} /></label>}
        <OutcomeLine action={action} />
      </div>
      {foreign && <p class="note">{foreign.name}: <Confirm label={t("write_file")} question={t("write_file_question")} yes={t("write_file")} disabled={!may} onYes={() => { put(foreign.form, foreign.json); setForeign(undefined); }} /></p>}
      {draft && <p class="note unsent" role="status">{t("waypoints_not_sent")} <button type="button" disabled={!may} onClick={() => setDraft("waypoints", device, undefined)}>{t("discard")}</button></p>}
      <JobLine job={job} />
      {fault && <p class="bad" role="alert"><DeviceText text={refusalText(fault)} /></p>}
      <div class="card map"><Track device={device} scene={scene} onMap={scene.origin && scene} yaw={0} way /></div>
      {all && <WaypointTable all={all} disabled={!may} onChange={setAll} />}
    </div>
  );
}
