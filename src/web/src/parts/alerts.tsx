// Alerts on every page: no contact to the gateway, lost devices, values that exceed their limit, errors logged by devices.
import type { ComponentChildren } from "preact";
import { called } from "../addresses";
import { fixed } from "../format";
import { deviceText, inWords, t } from "../i18n";
import { contact, seconds, status, table } from "../live/gateway";
import { inPeoplesUnits } from "../live/latest";
import { type Alarm, fieldOf, messageOf, type Limit } from "../live/limits";
import { useStore, useTick } from "../live/store";
import { ageOf, alarms, dismissAlarm, dismissLost, dismissRed, elsewhereOf, flagOf, lostNews, oldAfter, redLines, silence, sounding } from "../live/watch";
import { hashOf, pageOfDevice } from "../route";
import { DeviceText, tx } from "./device_text";

const shown = 3; // devices; with more, the alerts would hide the page

const stateWord = (flag: number | undefined): string => (flag === 0 ? t("flag_locked") : flag === 1 ? t("flag_unlocked") : flag === 2 ? t("flag_airborne") : "");

const known: Record<string, () => string> = {
  "power.voltage": () => t("battery"), "power.current": () => t("current"), "gps.s_num": () => t("satellites"),
  "return_home.r_d": () => t("home_distance"), "altitude.alt_fu": () => t("altitude"),
};

/** The name of the value of a limit, and the unit, factor and digits of its numbers. */
export function limitWords(limit: Pick<Limit, "field" | "cells">): { label: string; unit: string; factor: number; digits: number } {
  const field = table.get()?.rows.filter((row) => row.name === messageOf(limit)).flatMap((row) => row.fields).find((one) => one.name === fieldOf(limit));
  const [factor, unit] = inPeoplesUnits(1, field?.unit ?? "");
  const label = known[limit.field]?.() ?? limit.field;
  return { label: !limit.cells ? label : limit.field === "power.voltage" ? t("limit_cell") : t("per_cell", { label }), unit, factor, digits: limit.cells || (field?.scale ?? 1) < 1 || factor !== 1 ? 2 : 0 };
}

function Line({ kind, children, device }: { kind: string; children: ComponentChildren; device?: number }) {
  return <li class={kind} data-device={device}>{children}</li>;
}

function LostLine({ device }: { device: number }) {
  const state = stateWord(flagOf(device)), elsewhere = elsewhereOf(device);
  return (
    <Line kind="lost" device={device}>
      <span>
        <a href={hashOf({ page: pageOfDevice, device })}><b><DeviceText text={called(device)} /></b></a>{" "}
        <b>{t("no_data_for", { time: inWords(ageOf(device) ?? 0) })}</b>{state && <> · {t("last_state", { state })}</>}
        {elsewhere !== undefined && <> · {t("heard_elsewhere", { where: elsewhere })}</>}
      </span>
      <button type="button" onClick={() => dismissLost(device)}>{t("dismiss")}</button>
    </Line>
  );
}

function AlarmLine({ alarm }: { alarm: Alarm }) {
  const { device, limit, level, value, edge } = alarm;
  const { label, unit, factor, digits } = limitWords(limit), age = seconds() - alarm.heardAt, isOld = age > oldAfter;
  return (
    <Line kind={`beyond ${level}`} device={device}>
      <span>
        <b><DeviceText text={called(device)} />: {label} {fixed(value * factor, digits)} {unit}</b> {t(limit.side === "below" ? "is_below" : "is_above", { edge: `${fixed(edge * factor, digits)} ${unit}` })}
        {isOld && <> · {t("value_of_before", { time: inWords(age) })}</>}
      </span>
      {isOld && <button type="button" onClick={() => dismissAlarm(alarm)}>{t("dismiss")}</button>}
    </Line>
  );
}

export function Alerts() {
  useTick(250);
  const gateway = useStore(contact), lost = [...useStore(lostNews)], beyond = useStore(alarms), red = useStore(redLines), loud = useStore(sounding);
  useStore(status);
  const isLost = gateway === "lost";
  if (!isLost && lost.length === 0 && beyond.length === 0 && red.length === 0) return null;
  return (
    <div class="alerts">
      {isLost && <p class="banner" role="alert"><b>{t("no_contact")}{t("full_stop")}</b>{t("old_values")}</p>}
      {!isLost && (
        <ul role="alert">
          {lost.slice(0, shown).map((device) => <LostLine key={device} device={device} />)}
          {lost.length > shown && <Line kind="lost">{t("lost_more", { n: lost.length - shown })}</Line>}
          {beyond.slice(0, 6).map((alarm) => <AlarmLine key={`${alarm.device} ${alarm.limit.key}`} alarm={alarm} />)}
        </ul>
      )}
      {!isLost && loud.length > 0 && <button type="button" class="silence" onClick={silence}>{t("silence")}</button>}
      {red.slice(0, shown).map((line) => (
        <p key={line.device} class="strip" role="status">
          <span><b>{tx("red_lines", { name: called(line.device), n: line.count })}</b> <a href={hashOf({ page: "log", device: undefined })}><DeviceText text={deviceText(line.text)} /></a></span>
          <button type="button" onClick={() => dismissRed(line.device)}>{t("dismiss")}</button>
        </p>
      ))}
    </div>
  );
}

/** The beginning of the document title; empty: no alerts. */
export function alertTitle(): string {
  if (contact.get() === "lost") return `⚠ ${t("no_contact")} · `;
  const [lost] = lostNews.get();
  if (lost !== undefined) return `⚠ ${t("no_data_of", { name: called(lost) })} · `;
  const first = alarms.get()[0];
  return first ? `⚠ ${called(first.device)}: ${limitWords(first.limit).label} · ` : "";
}
