// Charts of fields over time.
import { useEffect, useMemo, useRef, useState } from "preact/hooks";
import { called } from "../addresses";
import { significant } from "../format";
import { t, titleText, useLanguage } from "../i18n";
import { jsonIn } from "../json";
import { remember, remembered } from "../kept";
import { ChartData, keyOf, type Chosen, type Line } from "../live/chart_data";
import { frameStream } from "../live/frames";
import { devices, seconds, table } from "../live/gateway";
import { lostDevices } from "../live/watch";
import { isolated } from "../visible";
import { csvOf } from "../live/series";
import { useStore, useTick } from "../live/store";
import { download, stamp } from "../parts/download";
import { LostFrames } from "../parts/lost_frames";
import { colours, Plot } from "../parts/plot";
import { isNumber, type MessageTable } from "../protocol/table";

const windows = [5, 10, 30, 60, 180, 600];

/** Kept while the web page is open, also while another view is shown. */
let kept: ChartData | undefined;

function chosenBefore(): Chosen[] {
  const json = jsonIn(remembered("charts"));
  if (!Array.isArray(json)) return [];
  return json.filter((one): one is Chosen => typeof one?.from === "number" && typeof one?.id === "number" && typeof one?.field === "string").slice(0, 40);
}

function dataFor(of: MessageTable): ChartData {
  if (kept?.table === of) return kept;
  kept = new ChartData(of, called);
  for (const one of chosenBefore()) kept.add(one);
  if (kept.lines.length === 0) {
    const id = of.idOf("euler");
    const first = devices.get().map((device) => Number(device.address)).sort((a, b) => Number(b === 0xdc) - Number(a === 0xdc))[0];
    if (id !== undefined && first) for (const field of ["rol", "pit", "yaw"]) kept.add({ from: first, id, field });
  }
  return kept;
}

const keep = (data: ChartData): void => remember("charts", JSON.stringify(data.lines.map(({ from, id, field }) => ({ from, id, field }))));

function Picker({ data, onChange }: { data: ChartData; onChange: () => void }) {
  useTick(1000);
  const of = data.table;
  const heard = [...data.heard].sort((a, b) => a - b);
  const [frame, setFrame] = useState<number>();
  const now = frame ?? heard[0];
  const names = now === undefined ? [] : [...new Set(of.layouts(now & 255).filter((row) => row.source === undefined || row.source === now >> 8).flatMap((row) => row.fields.filter((field) => isNumber(field)).map((field) => field.name)))];
  return (
    <fieldset class="card picker">
      <legend>{t("choose_fields")}</legend>
      {now === undefined ? <p class="muted">{t("waiting_first")}</p> : (
        <>
          <select aria-label={t("message")} value={String(now)} onChange={(event) => setFrame(Number(event.currentTarget.value))}>
            {heard.map((one) => (
              <option key={one} value={String(one)}>{isolated(called(one >> 8))} · {of.name(one & 255)}: {titleText(of.name(one & 255), of.title(one & 255))}</option>
            ))}
          </select>
          <div class="checks">
            {names.map((field) => {
              const chosen = { from: now >> 8, id: now & 255, field };
              const on = data.lines.some((line) => keyOf(line) === keyOf(chosen));
              return (
                <label key={field} class="check">
                  <input type="checkbox" checked={on} onChange={() => { if (on) data.remove(keyOf(chosen)); else data.add(chosen); keep(data); onChange(); }} />
                  {field}
                </label>
              );
            })}
          </div>
        </>
      )}
    </fieldset>
  );
}

const numberText = (value: number | undefined): string => (value === undefined || Number.isNaN(value) ? "–" : significant(value, 6));

/** For each line, the newest value, the value at the pointer, and its difference from the value at the measuring mark. */
function Values({ lines, look, mark, onRemove }: { lines: readonly Line[]; look: number | undefined; mark: number | undefined; onRemove: (key: string) => void }) {
  useTick(250);
  const gone = useStore(lostDevices);
  const measures = look !== undefined && mark !== undefined;
  return (
    <div class="scroll" tabIndex={0} role="group" aria-label={t("values")}>
      <table class="chart-values">
        <thead>
          <tr>
            <th scope="col">{t("field")}</th><th scope="col" class="number">{t("newest")}</th><th scope="col" class="number">{t("at_pointer")}</th>
            <th scope="col" class="number">{measures ? `Δ ${t("in_seconds", { s: (look - mark).toFixed(3) })}` : "Δ"}</th><th><span class="hidden">{t("remove")}</span></th>
          </tr>
        </thead>
        <tbody>
          {lines.map((line, i) => {
            const here = look === undefined ? undefined : line.series.before(look);
            const there = mark === undefined ? undefined : line.series.before(mark);
            const newest = line.series.length > 0 ? line.series.value(line.series.length - 1) : undefined;
            const isOld = gone.has(line.from);
            return (
              <tr key={keyOf(line)}>
                <th scope="row"><i class="swatch" style={{ background: colours[i % colours.length]! }} aria-hidden="true" /><bdi>{line.label}</bdi> <small class="muted">{line.unit}</small></th>
                <td class={`number ${isOld ? "late-value" : ""}`}>{numberText(newest)}</td>
                <td class="number">{numberText(here)}</td>
                <td class="number">{here !== undefined && there !== undefined ? numberText(here - there) : "–"}</td>
                <td><button class="plain" aria-label={`${t("remove")} ${line.label}`} onClick={() => onRemove(keyOf(line))}>✕</button></td>
              </tr>
            );
          })}
        </tbody>
      </table>
    </div>
  );
}

interface View {
  width: number; // visible seconds
  stopped: { from: number; to: number } | undefined; // the visible range while paused
}

/** Milliseconds for which frames are collected: longer than for single values, because the curves are drawn with this
 * delay and therefore move smoothly. */
const batch = 100;

/** Draws once per screen frame, and only if there is a visible change. */
function useDrawing(data: ChartData | undefined, count: number, view: { current: View }, onLook: (time: number | undefined) => void, onZoom: (from: number, to: number) => void) {
  const holder = useRef<HTMLDivElement>(null);
  const plot = useRef<Plot | undefined>(undefined);
  useEffect(() => {
    if (!data || !holder.current || data.lines.length === 0) return undefined;
    const drawn = new Plot(holder.current, data.lines, onLook, onZoom);
    plot.current = drawn;
    let changed = true;
    const watch = new ResizeObserver(() => { drawn.fit(); changed = true; });
    watch.observe(holder.current);
    let lead = Number.NEGATIVE_INFINITY; // lead of the newest frame over the page's clock without delay: everything older than that by `batch` has been received
    let running = 0;
    const step = (): void => {
      running = requestAnimationFrame(step);
      const now = seconds();
      lead = Math.max(lead - 0.0005, data.newest - now);
      const edge = Number.isFinite(lead) ? now + lead - batch / 1000 : Date.now() / 1000;
      const { stopped, width } = view.current;
      const from = stopped ? stopped.from : edge - width, to = stopped ? stopped.to : edge;
      drawn.draw(from, to, changed);
      changed = false;
    };
    running = requestAnimationFrame(step);
    return () => {
      cancelAnimationFrame(running);
      watch.disconnect();
      drawn.destroy();
      plot.current = undefined;
    };
  }, [data, count]);
  return { holder, plot };
}

export function Charts() {
  useLanguage();
  const of = useStore(table);
  useStore(devices);
  const data = useMemo(() => (of && devices.get().length > 0 ? dataFor(of) : undefined), [of, devices.get().length > 0]);
  const [version, setVersion] = useState(0);
  const [picks, setPicks] = useState(false);
  const [look, setLook] = useState<number>();
  const [mark, setMark] = useState<number>();
  const [width, setWidth] = useState(30);
  const [stopped, setStopped] = useState<View["stopped"]>();
  const view = useRef<View>({ width, stopped });
  view.current = { width, stopped };
  const { holder, plot } = useDrawing(data, version, view, setLook, (from, to) => setStopped({ from, to }));
  useEffect(() => {
    if (!data) return undefined;
    const chosen = new Set(data.lines.map((line) => line.id));
    const ids = [...new Set(data.table.rows.map((row) => row.id))];
    const wish = picks
      ? { limit: Object.fromEntries(ids.filter((id) => !chosen.has(id)).map((id) => [id, 2])) }
      : { from: [...new Set(data.lines.map((line) => line.from))], id: [...chosen] };
    if (!picks && chosen.size === 0) return undefined;
    return frameStream.use({ wish: { ...wish, batch }, take: (record) => data.take(record), began: () => data.gap() });
  }, [data, version, picks]);
  if (!data) return <p class="muted" role="status">{t("waiting_first")}</p>;
  const range = (): { from: number; to: number } => stopped ?? { from: data.newest - width, to: data.newest };
  const saveCsv = (): void => {
    const { from, to } = range();
    download(`anogate_${stamp()}.csv`, new Blob([csvOf(data.lines, from, to)], { type: "text/csv" }));
  };
  const savePng = (): void => plot.current?.canvas().toBlob((blob) => blob && download(`anogate_${stamp()}.png`, blob));
  const pause = (): void => setStopped(stopped ? undefined : range());
  return (
    <div class="charts">
      <h1>{t("charts")}</h1>
      <div class="tools">
        <button aria-expanded={picks} onClick={() => setPicks(!picks)}>{t("choose_fields")}</button>
        <select aria-label={t("window")} value={String(width)} onChange={(event) => { setWidth(Number(event.currentTarget.value)); setStopped(undefined); }}>
          {windows.map((one) => <option key={one} value={String(one)}>{one < 60 ? t("in_seconds", { s: one }) : t("in_minutes", { n: one / 60 })}</option>)}
        </select>
        <button aria-pressed={stopped !== undefined} onClick={pause}>{stopped ? t("go_on") : t("pause")}</button>
        <button onClick={saveCsv}>CSV</button>
        <button onClick={savePng}>PNG</button>
        <button onClick={() => { data.clear(); setStopped(undefined); setMark(undefined); }}>{t("clear")}</button>
      </div>
      {picks && <Picker data={data} onChange={() => setVersion(version + 1)} />}
      <LostFrames />
      {data.lines.length === 0 ? <p class="muted">{t("no_fields")}</p> : (
        <>
          <div class="plot card" ref={holder} role="img" aria-label={data.lines.map((line) => line.label).join(", ")} onClick={() => setMark(look)} />
          <p class="muted"><small>{t("chart_hint")}</small></p>
          <Values lines={data.lines} look={look} mark={mark} onRemove={(key) => { data.remove(key); keep(data); setVersion(version + 1); }} />
        </>
      )}
    </div>
  );
}
