// A vehicle: attitude, position, state.
import { useEffect, useMemo } from "preact/hooks";
import { nameOf } from "../addresses";
import { fixed } from "../format";
import { inWords, t, useLanguage, type Key } from "../i18n";
import { frameStream } from "../live/frames";
import { devices, seconds, status, table } from "../live/gateway";
import { Latest, type Seen } from "../live/latest";
import { orientationOf } from "../live/orientation";
import { useStore, useTick } from "../live/store";
import { lastStateOf, lostDevices } from "../live/watch";
import { hexByte, hosts, type MessageTable } from "../protocol/table";
import { DeviceText } from "../parts/device_text";
import { Horizon, Rose } from "../parts/horizon";
import type { Place } from "../map/datum";
import type { Point, Scene } from "../parts/ground";
import { Track } from "../parts/track";
import { addPlace, addPoint, earthTrackOf, trackOf } from "../parts/tracks";
import { isPlace, onGround } from "../parts/waypoint_set";

/** Maximum rates of the messages on this page, per second; higher rates would not be visible. */
const wanted: Record<string, number> = {
  euler: 30, quaternion: 30, altitude: 10, velocity: 10, position: 10, mode: 10, power: 4, gps: 5, module_status: 2, return_home: 4, wind: 2, remote_control: 20, pwm: 10,
};

function useLatest(of: MessageTable | undefined, device: number): Latest | undefined {
  const latest = useMemo(() => of && new Latest(of), [of, device]);
  useEffect(() => {
    if (!of || !latest) return undefined;
    const known = of.rows.filter((row) => row.layout === undefined && row.name in wanted);
    const sticks = of.idOf("remote_control"), position = of.idOf("position"), gps = of.idOf("gps");
    return frameStream.use({
      wish: { from: [...new Set([device, ...hosts])], id: known.map((row) => row.id), limit: Object.fromEntries(known.map((row) => [row.id, wanted[row.name]!])) },
      take: (record, at) => {
        if (record.from !== device && !(record.id === sticks && record.to === device)) return;
        latest.take(record, at);
        if (record.id === position) addPointOf(latest, device);
        const place = record.id === gps ? placeOf(latest) : undefined;
        if (place) addPlace(device, place);
      },
    });
  }, [of, latest, device]);
  return latest;
}

function pointOf(latest: Latest): Point | undefined {
  const x = latest.number("position", "pos_x", 0), y = latest.number("position", "pos_y", 0);
  return x && y && { x: x.value, y: y.value };
}

function addPointOf(latest: Latest, device: number): void {
  const point = pointOf(latest);
  if (point) addPoint(trackOf(device), point);
}

const fixes = [2, 3, 4]; // values of fix_sta with a valid position

function placeOf(latest: Latest): Place | undefined {
  const fix = latest.number("gps", "fix_sta", 0), lng = latest.number("gps", "lng", 0), lat = latest.number("gps", "lat", 0);
  const place = lng && lat && { lng: lng.value, lat: lat.value };
  return fix && fixes.includes(fix.value) && isPlace(place) ? place : undefined;
}

function onMap(latest: Latest, device: number): Scene | undefined {
  const track = earthTrackOf(device), place = placeOf(latest);
  return track && place && { track: track.points, marks: [], now: onGround(track.origin, place), origin: track.origin };
}

function Figure({ label, seen, digits = 1 }: { label: string; seen: Seen | undefined; digits?: number }) {
  return (
    <div class={`figure ${seen?.late ? "late-value" : ""}`}>
      <dt>{label}</dt>
      <dd>{seen ? <>{fixed(seen.value, digits)}<small> {seen.unit}</small></> : <span class="muted">–</span>}</dd>
    </div>
  );
}

function Bars({ title, late, values, low, high, unit }: { title: string; late: boolean; values: [string, number][]; low: number; high: number; unit: string }) {
  if (values.length === 0) return null;
  return (
    <section class={late ? "late-bars" : ""}>
      <h2>{title}</h2>
      <ul class="bars">
        {values.map(([name, value]) => (
          <li key={name}>
            <span>{name}</span>
            <meter min={low} max={high} value={Math.min(Math.max(value, low), high)} aria-label={name} />
            <span class="number">{Number.isInteger(value) ? value : value.toFixed(1)}{unit}</span>
          </li>
        ))}
      </ul>
    </section>
  );
}

function numbersOf(latest: Latest, message: string): [string, number][] {
  return (latest.reading(message)?.fields() ?? []).flatMap(({ field, value }): [string, number][] => (typeof value === "number" ? [[field.name, value]] : []));
}

const lockWords: Record<number, Key> = { 0: "flag_locked", 1: "flag_unlocked", 2: "flag_airborne" };

/** If no state was received while this page was open, shows the last one known to the gateway. */
function State({ latest, device, now }: { latest: Latest; device: number; now: number }) {
  const seen = latest.number("mode", "sflag", now), mode = latest.number("mode", "mode", now);
  const before = seen ? undefined : lastStateOf(device);
  const flag: Pick<Seen, "value" | "late"> | undefined = seen ?? (before && { value: before.flag, late: true });
  const word = flag && lockWords[flag.value];
  const state = word ? t(word) : flag ? String(flag.value) : "–";
  const age = before ? now - before.at : flag?.late ? latest.age("mode", now) : undefined;
  return (
    <p class="state">
      <b class={`flag ${flag?.late ?? true ? "late-value" : flag?.value === 0 ? "good" : "warn"}`}>{age !== undefined && age >= 1 ? t("state_ago", { state, time: inWords(age) }) : state}</b>
      {mode && <span class={mode.late ? "late-value" : ""}>{t("mode_n", { n: mode.value })}</span>}
    </p>
  );
}

function speedOf(latest: Latest, now: number): Seen | undefined {
  const x = latest.number("velocity", "speed_x", now), y = latest.number("velocity", "speed_y", now);
  return x && y && { value: Math.hypot(x.value, y.value), unit: x.unit, late: x.late };
}

function Modules({ latest, now }: { latest: Latest; now: number }) {
  const reading = latest.reading("module_status");
  if (!reading) return null;
  const late = latest.isLate("module_status", now);
  const names: Record<string, Key> = { sta_g_vel: "module_velocity", sta_g_pos: "module_position", sta_gps: "module_gps", sta_alt_add: "module_height" };
  const words: Key[] = ["module_none", "module_unusable", "module_normal", "module_good"];
  return (
    <ul class={`modules ${late ? "late-value" : ""}`}>
      {reading.fields().map(({ field, value }) => (
        <li key={field.name} class={late || value === 0 ? "muted" : value === 1 ? "bad" : "good"}>
          <i class="lamp" aria-hidden="true" />{t("module_state", { module: names[field.name] ? t(names[field.name]!) : field.name, state: typeof value === "number" && words[value] ? t(words[value]!) : String(value) })}
        </li>
      ))}
    </ul>
  );
}

export function Vehicle({ device }: { device: number }) {
  useLanguage();
  const of = useStore(table);
  const latest = useLatest(of, device);
  useTick(50);
  const now = seconds(), gone = useStore(lostDevices).has(device);
  if (latest) latest.isGone = gone;
  if (!latest) return <p class="muted" role="status">{t("waiting_first")}</p>;
  const link = devices.get().find((one) => Number(one.address) === device)?.link;
  const is = orientationOf(latest, now, status.get()?.links.find((one) => one.name === link)?.attitude === "lx");
  const roll = is.roll?.value ?? 0, pitch = is.pitch?.value ?? 0, yaw = is.yaw?.value ?? 0;
  const sticks = numbersOf(latest, "remote_control"), motors = numbersOf(latest, "pwm");
  return (
    <div class="vehicle">
      <h1><DeviceText text={nameOf(device) || t("vehicle")} /> <small class="muted">{hexByte(device)}</small></h1>
      <State latest={latest} device={device} now={now} />
      <div class="panels">
        <div class="attitude card">
          <Horizon roll={roll} pitch={pitch} yaw={yaw} late={is.late} />
          <Rose yaw={yaw} late={is.late} />
          <dl class="figures">
            <Figure label={t("roll")} seen={is.roll} />
            <Figure label={t("pitch")} seen={is.pitch} />
            <Figure label={t("yaw")} seen={is.yaw} />
          </dl>
        </div>
        <div class="card">
          <dl class="figures large">
            <Figure label={t("altitude")} seen={latest.number("altitude", "alt_fu", now)} digits={2} />
            <Figure label={t("speed")} seen={speedOf(latest, now)} digits={2} />
            <Figure label={t("climb")} seen={latest.number("velocity", "speed_z", now)} digits={2} />
            <Figure label={t("battery")} seen={latest.number("power", "voltage", now)} digits={2} />
            <Figure label={t("current")} seen={latest.number("power", "current", now)} digits={2} />
            <Figure label={t("satellites")} seen={latest.number("gps", "s_num", now)} digits={0} />
            <Figure label={t("home_distance")} seen={latest.number("return_home", "r_d", now)} digits={0} />
            <Figure label={t("barometer")} seen={latest.number("altitude", "alt_bar", now)} digits={2} />
          </dl>
          <Modules latest={latest} now={now} />
        </div>
        <div class="card wide"><Track device={device} scene={{ track: trackOf(device), marks: [], now: pointOf(latest) }} onMap={onMap(latest, device)} yaw={yaw} /></div>
        {sticks.length > 0 && <div class="card"><Bars title={t("sticks")} late={latest.isLate("remote_control", now)} values={sticks} low={1000} high={2000} unit="" /></div>}
        {motors.length > 0 && <div class="card"><Bars title={t("motors")} late={latest.isLate("pwm", now)} values={motors} low={0} high={100} unit=" %" /></div>}
      </div>
    </div>
  );
}
