// A diagram of the network: the gateway, its links, the devices on each link, and the current traffic.
import { useState } from "preact/hooks";
import { causeText, hintText, inWords, t } from "../i18n";
import { drops, lost } from "../live/counters";
import { rateOf, type Link, type Route, type Status } from "../live/gateway";
import { replayedDevices } from "../live/replayed";
import { rateText, shortNumber } from "../format";
import { hashOf, pageOfDevice } from "../route";
import { nameOf } from "../addresses";
import { isHost } from "../protocol/table";
import { useStore } from "../live/store";
import { ageOf, lostDevices } from "../live/watch";
import { DeviceText } from "./device_text";
import { Hint } from "./hint";
import { calmHints } from "../words_of_gateway";

/** A line with an animated flow, faster at a higher rate; no animation without frames. */
function Wire({ rate, back }: { rate: number; back: boolean }) {
  const flows = rate > 0.05;
  const period = flows ? Math.max(0.35, 2.2 - 0.55 * Math.log10(1 + rate)) : 0;
  return (
    <svg class={`wire ${flows ? "flows" : ""} ${back ? "back" : ""}`} viewBox="0 0 100 6" preserveAspectRatio="none" aria-hidden="true">
      <line class="bed" x1="0" y1="3" x2="100" y2="3" vector-effect="non-scaling-stroke" />
      {flows && <line class="flow" x1="0" y1="3" x2="100" y2="3" vector-effect="non-scaling-stroke" style={{ animationDuration: `${period.toFixed(2)}s` }} />}
    </svg>
  );
}

function Who({ route }: { route: Route }) {
  const address = Number(route.address);
  const isLost = useStore(lostDevices).has(address);
  const age = isLost ? (ageOf(address) ?? route.age_s ?? 0) : (route.age_s ?? 0);
  const text = (
    <>
      <b>{route.address}</b> <DeviceText text={nameOf(address)} />
      {(isLost || age > 3) && <small> · {t("ago", { time: inWords(age) })}</small>}
    </>
  );
  const title = route.via === "replayed" ? t("replayed") : t(`via_${route.via}` as "via_own");
  return (
    <li class={isLost ? "who late lost" : age > 3 ? "who late" : "who"} title={title}>
      {!isHost(address) ? <a href={hashOf({ page: pageOfDevice, device: address })}>{text}</a> : text}
    </li>
  );
}

/** The peers of a listening link. */
function Peers({ link }: { link: Link }) {
  if (!link.kind.endsWith("-listen")) return null;
  const shown = link.channels.slice(0, 6);
  if (shown.length === 0 && link.hint_id === "no_peer_yet") return null; // the hint already says so
  if (shown.length === 0) return <p class="muted">{t("no_peers")}</p>;
  return (
    <ul class="peers" aria-label={t("peers")}>
      {shown.map((channel) => (
        <li key={channel.peer}>
          <code>{channel.peer}</code>
          {channel.listening_since_s !== undefined && <small class="muted"> · {t("listening_since", { time: inWords(channel.listening_since_s) })}</small>}
        </li>
      ))}
      {link.channels.length > shown.length && <li class="muted">{t("peers_more", { n: link.channels.length - shown.length })}</li>}
    </ul>
  );
}

function CounterTable({ link }: { link: Link }) {
  const keptBack = ["kept_back_of_hosts", "kept_back_commands", "kept_back_tunnels"].filter((name) => name in link);
  const names = ["frames_in", "bytes_in", "skipped_bytes", ...keptBack, "frames_out", "bytes_out", "empty_out", "flush_bytes", "waiting", ...drops(link).map(([name]) => name)];
  return (
    <table aria-label={t("details_of", { name: link.name })}>
      <tbody>
        {names.map((name) => (
          <tr key={name}>
            <th scope="row">{causeText(name)}</th>
            <td class="number">{String(link[name] ?? "")}</td>
            <td class="number">{rateText(rateOf([link], [name]))} {t("per_second")}</td>
          </tr>
        ))}
      </tbody>
    </table>
  );
}

function Branch({ link, routes }: { link: Link; routes: Route[] }) {
  const [open, setOpen] = useState(false);
  const up = link.state === "up";
  const rate = (name: string): number | undefined => rateOf([link], [name]);
  const losing = rateOf([link], lost(link).map(([name]) => name));
  const calm = calmHints.has(link.hint_id);
  const troubled = link.error !== "" || (link.hint !== "" && !calm); // the list above shows the error or hint
  const where = link.device ?? link.address ?? link.peer;
  return (
    <li class={`branch ${up ? "up" : "down"} ${troubled ? "troubled" : ""}`}>
      <div class="wires">
        <Wire rate={up ? (rate("frames_in") ?? 0) : 0} back />
        <Wire rate={up ? (rate("frames_out") ?? 0) : 0} back={false} />
      </div>
      <article class="link" aria-label={link.name}>
        <header>
          <i class="lamp" aria-hidden="true" />
          <h3>{link.name}</h3>
          <span class="muted">{link.kind}</span>
          {typeof where === "string" && where !== link.name && <code class="muted">{where}</code>}
          {link.id ? <span class="muted">{t("port_id", { id: link.id })}</span> : null}
          {!up && <span class="tag">{t("state_waiting")}</span>}
        </header>
        <dl class="flows">
          <div><dt>{t("in")}</dt><dd>{rateText(rate("frames_in"))}<small> {t("per_second")}</small></dd></div>
          <div><dt>{t("out")}</dt><dd>{rateText(rate("frames_out"))}<small> {t("per_second")}</small></dd></div>
          <div class={(losing ?? 0) > 0.05 ? "warn" : ""}><dt>✕</dt><dd>{rateText(losing)}<small> {t("per_second")}</small></dd></div>
        </dl>
        {link.replayed && <p class="calm">{t("replayed")}</p>}
        {calm && <p class="calm"><Hint text={hintText(link.hint_id, link.hint, link.hint_args)} /></p>}
        <ul class="whos">{routes.map((route) => <Who key={route.address} route={route} />)}</ul>
        <Peers link={link} />
        <button class="plain more" aria-expanded={open} onClick={() => setOpen(!open)}>{t("counters")} <span aria-hidden="true">{open ? "▴" : "▾"}</span></button>
        {open && <CounterTable link={link} />}
      </article>
    </li>
  );
}

export function Network({ status }: { status: Status }) {
  const replayed = replayedDevices(status);
  const behind = (link: Link): Route[] => [
    ...status.routes.filter((route) => route.links.includes(link.name) && route.via !== "port"),
    ...(link.replayed ?? []).filter((one) => replayed.get(Number(one.address)) === link.name).map((one) => ({ ...one, links: [link.name], via: "replayed" })),
  ];
  const all = status.links;
  const coming = rateOf(all, ["frames_in"]);
  return (
    <div class="network">
      <div class="hub">
        <b>{status.gateway.name}</b>
        {status.gateway.id !== null && <span>{status.gateway.id}</span>}
        <span class="muted">{shortNumber(Math.round(coming ?? NaN))}{t("per_second")}</span>
      </div>
      <ol>{all.map((link) => <Branch key={link.name} link={link} routes={behind(link)} />)}</ol>
    </div>
  );
}
