// The received frames: one row for each sender and message; an opened row shows fields and bytes.
import { useEffect, useMemo, useRef, useState } from "preact/hooks";
import { nameOf } from "../addresses";
import { finder } from "../finder";
import { meaningOf, rateText, valueText } from "../format";
import { causeText, t, titleText, useLanguage } from "../i18n";
import { frameStream } from "../live/frames";
import { devices, mayAct, seconds, table } from "../live/gateway";
import { FrameRows, type FrameRow } from "../live/rows";
import { useStore, useTick } from "../live/store";
import { directions, type Direction, type Tables } from "../protocol/records";
import { hexByte, hexOf, type MessageTable, type Reading, type Unreadable } from "../protocol/table";
import { lostDevices } from "../live/watch";
import { DeviceText } from "../parts/device_text";
import { LostFrames } from "../parts/lost_frames";
import { visible } from "../visible";
import { SendForm } from "../parts/send_form";

const maxShown = 300;

/** The first values; CSS hides those that don't fit in the line. */
function Brief({ reading, size }: { reading: Reading | Unreadable; size: number }) {
  if (typeof reading === "string") return <span class="muted">{t(reading, { n: size })}</span>;
  const shown = reading.fields().filter(({ field }) => field.type !== "bytes" && field.type !== "list" && field.type !== "frames").slice(0, 8);
  return (
    <span class="brief">
      {shown.map(({ field, value }) => (
        <span key={field.name}><small>{field.label ?? field.name}</small> <bdi>{visible(valueText(value, field)).slice(0, 60)}</bdi>{value !== null && field.unit ? <small> {field.unit}</small> : null}</span>
      ))}
    </span>
  );
}

function Bytes({ data }: { data: Uint8Array }) {
  const shown = data.subarray(0, 256);
  const text = hexOf(shown).replace(/../g, "$& ").trim();
  return <pre class="bytes" tabIndex={0} aria-label={t("raw")}>{text}{data.length > 256 ? ` … (${data.length})` : ""}</pre>;
}

function Opened({ row, reading, tables }: { row: FrameRow; reading: Reading | Unreadable; tables: Tables | undefined }) {
  return (
    <div class="opened">
      <p class="muted">
        {t("to")} {row.to === 255 ? t("broadcast") : <>{hexByte(row.to)} <DeviceText text={nameOf(row.to)} /></>} · {t("link")} {tables?.links[row.link] ?? row.link} · {t("count")} {row.count} · {row.data.length} {t("size")}
        {row.cause > 0 && <> · <b class="warn">{causeText(tables?.causes[row.cause] ?? String(row.cause))}</b></>}
      </p>
      {typeof reading !== "string" && (
        <table class="fields">
          <tbody>
            {reading.fields().map(({ field, value }) => (
              <tr key={field.name}>
                <th scope="row">{field.label ?? field.name}</th>
                <td class="number">{value === null ? <span class="muted">{t("no_data")}</span> : <bdi>{visible(valueText(value, field))}</bdi>}</td>
                <td class="unit">{field.unit ?? ""}{meaningOf(value, field) ? <i>{meaningOf(value, field)}</i> : null}{field.note ? <span class="muted"> {field.note}</span> : null}</td>
              </tr>
            ))}
            {reading.extra().length > 0 && <tr><th scope="row">{t("extra")}</th><td colSpan={2}><code>{hexOf(reading.extra().subarray(0, 64))}</code></td></tr>}
          </tbody>
        </table>
      )}
      <Bytes data={row.data} />
    </div>
  );
}

function Row({ row, of, open, onToggle, now, tables, isGone }: { isGone: boolean; row: FrameRow; of: MessageTable; open: boolean; onToggle: () => void; now: number; tables: Tables | undefined }) {
  const reading = of.read(row.id, row.from, row.data);
  const layout = typeof reading === "string" ? undefined : reading.row.layout;
  const late = row.rate.isLate(now) || isGone;
  return (
    <li class={late ? "late" : ""}>
      <button class="row" aria-expanded={open} onClick={onToggle}>
        <span class="from"><b>{hexByte(row.from)}</b> <DeviceText text={nameOf(row.from)} /></span>
        <span class="message"><b>{of.name(row.id)}</b>{layout ? <small> {layout}</small> : null} <code class="muted">{hexByte(row.id)}</code><small class="muted title">{titleText(of.name(row.id), typeof reading === "string" ? of.title(row.id) : reading.row.title)}</small></span>
        <span class="rate number">{late ? "–" : rateText(row.rate.perSecond(now))}<small> {t("per_second")}</small></span>
        <Brief reading={reading} size={row.data.length} />
      </button>
      {open && <Opened row={row} reading={reading} tables={tables} />}
    </li>
  );
}

const textOf = (row: FrameRow, of: MessageTable): string => `${hexByte(row.from)} ${nameOf(row.from)} ${of.name(row.id)} ${hexByte(row.id)} ${titleText(of.name(row.id), of.title(row.id))}`;

/** The rows of one direction, updated while it is shown. */
function useRows(direction: Direction): { rows: FrameRows; tables: Tables | undefined} {
  const of = useStore(table);
  const rows = useMemo(() => new FrameRows(), [direction]);
  const [tables, setTables] = useState<Tables>();
  useEffect(() => rows.setTable(of), [rows, of]);
  useEffect(
    () => frameStream.use({ wish: { direction }, take: (record, at) => void rows.add(record, at), tables: setTables }),
    [rows, direction],
  );
  return { rows, tables };
}

export function Frames() {
  useLanguage();
  useStore(devices);
  const of = useStore(table), gone = useStore(lostDevices);
  const [direction, setDirection] = useState<Direction>("in");
  const [search, setSearch] = useState("");
  const [open, setOpen] = useState<ReadonlySet<string>>(new Set());
  const [paused, setPaused] = useState(false);
  const [sends, setSends] = useState(false);
  const { rows, tables } = useRows(direction);
  useTick(250);
  const drawn = useRef<{ all: FrameRow[]; now: number }>({ all: [], now: 0 });
  if (!paused || drawn.current.all.length === 0) drawn.current = { all: rows.sorted(), now: seconds() };
  const { all, now } = drawn.current;
  if (!of) return <p class="muted" role="status">{t("waiting_first")}</p>;
  const isFound = finder(search), found = search === "" ? all : all.filter((row) => isFound(textOf(row, of)));
  const toggle = (key: string): void => {
    const next = new Set(open);
    if (!next.delete(key)) next.add(key);
    setOpen(next);
  };
  return (
    <div class="frames">
      <h1>{t("frames")}</h1>
      <div class="tools">
        <input type="search" aria-label={t("search")} placeholder={t("search_frames")} value={search} onInput={(event) => setSearch(event.currentTarget.value)} />
        <select aria-label={t("direction")} value={direction} onChange={(event) => { setDirection(event.currentTarget.value as Direction); setOpen(new Set()); }}>
          {directions.map((one) => <option key={one} value={one}>{t(`direction_${one}`)}</option>)}
        </select>
        <button aria-pressed={paused} onClick={() => setPaused(!paused)}>{paused ? t("go_on") : t("pause")}</button>
        <button onClick={() => { rows.clear(); drawn.current = { all: [], now: 0 }; }}>{t("clear")}</button>
        {mayAct() && <button aria-expanded={sends} onClick={() => setSends(!sends)}>{t("send_frame")}</button>}
      </div>
      {sends && <SendForm of={of} onClose={() => setSends(false)} />}
      <LostFrames />
      {rows.left_out > 0 && <p class="note warn">{t("rows_left_out", { n: rows.left_out })}</p>}
      {found.length === 0 ? <p class="muted">{t("no_frames_yet")}</p> : (
        <ul class="rows">
          {found.slice(0, maxShown).map((row) => (
            <Row key={row.key} row={row} of={of} open={open.has(row.key)} onToggle={() => toggle(row.key)} now={now} tables={tables} isGone={gone.has(row.from)} />
          ))}
        </ul>
      )}
      {found.length > maxShown && <p class="muted">{t("rows_more", { n: found.length - maxShown })}</p>}
    </div>
  );
}
