// Overview of the gateway, beginning with problems.
import { useState } from "preact/hooks";
import { causeText, errorText, hintText, inWords, faultText, t, useLanguage } from "../i18n";
import { lossesByCause } from "../live/counters";
import { devices, mayAct, rateOf, scan, status, type Link, type Status } from "../live/gateway";
import { faultsOf } from "../live/recordings";
import { replayedDevices } from "../live/replayed";
import { useStore } from "../live/store";
import { rateText, shortNumber } from "../format";
import { Hint } from "../parts/hint";
import { Network } from "../parts/network";
import { hashOf } from "../route";
import { calmHints } from "../words_of_gateway";

interface Trouble {
  who: string;
  text: string;
  bad: boolean;
  page?: string; // page with details
}

function troublesOf(status: Status): Trouble[] {
  const all: Trouble[] = [];
  for (const link of status.links) {
    if (link.error) all.push({ who: link.name, text: errorText(link.error_id, link.error, link.error_args), bad: link.state !== "up" });
    if (link.hint && !calmHints.has(link.hint_id)) all.push({ who: link.name, text: hintText(link.hint_id, link.hint, link.hint_args), bad: false });
  }
  for (const conflict of status.conflicts)
    all.push({ who: conflict.address, text: t("conflict", { address: conflict.address, links: (conflict.links ?? []).join(", ") }), bad: true });
  for (const { name, ...fault } of faultsOf(status.recording))
    all.push({ who: name ? t("recording_fails", { name }) : t("last_not_saved"), text: faultText(fault), bad: true, page: "recordings" });
  const { standstills, longest_standstill_s: longest } = status.gateway;
  if (standstills > 0) all.push({ who: status.gateway.name, text: t("standstills", { n: standstills, s: longest }), bad: false });
  return all.sort((a, b) => Number(b.bad) - Number(a.bad));
}

function Troubles({ status }: { status: Status }) {
  const all = troublesOf(status);
  if (all.length === 0) return <p class="well"><i class="lamp" aria-hidden="true" />{t("all_well")}</p>;
  return (
    <section aria-labelledby="troubles">
      <h2 id="troubles">{t("troubles")}</h2>
      <ul class="troubles">
        {all.map((one) => (
          <li key={one.who + one.text} class={one.bad ? "bad" : "warn"}>
            <b>{one.page ? <a href={hashOf({ page: one.page, device: undefined })}>{one.who}</a> : one.who}</b> <span><Hint text={one.text} /></span>
          </li>
        ))}
      </ul>
    </section>
  );
}

interface Drop {
  cause: string;
  total: number;
  now: number | undefined;
  links: string[];
}

function dropsOf(links: Link[]): Drop[] {
  const all = [...lossesByCause(links)].map(([cause, { total, of }]): Drop => ({ cause, total, now: rateOf(of, [cause]), links: of.map((link) => link.name) }));
  return all.sort((a, b) => (b.now ?? 0) - (a.now ?? 0) || b.total - a.total);
}

function Drops({ links }: { links: Link[] }) {
  const all = dropsOf(links);
  return (
    <section aria-labelledby="drops">
      <h2 id="drops">{t("drops")}</h2>
      {all.length === 0 ? <p class="muted">{t("drops_none")}</p> : (
        <div class="scroll" tabIndex={0} role="group" aria-labelledby="drops">
          <table class="drops">
            <thead>
              <tr><th scope="col">{t("cause")}</th><th scope="col" class="number">{t("now_rate")}</th><th scope="col" class="number">{t("total")}</th><th scope="col">{t("where")}</th></tr>
            </thead>
            <tbody>
              {all.map((drop) => (
                <tr key={drop.cause}>
                  <th scope="row">{causeText(drop.cause)} <code class="muted">{drop.cause}</code></th>
                  <td class={`number ${(drop.now ?? 0) > 0.05 ? "warn" : ""}`}>{rateText(drop.now)} {t("per_second")}</td>
                  <td class="number">{shortNumber(drop.total)}</td>
                  <td>{drop.links.join(", ")}</td>
                </tr>
              ))}
            </tbody>
          </table>
        </div>
      )}
    </section>
  );
}

function Scan() {
  const [words, setWords] = useState("");
  const [busy, setBusy] = useState(false);
  if (!mayAct()) return null;
  const look = async (): Promise<void> => {
    if (busy) return;
    setBusy(true);
    const answer = await scan();
    setBusy(false);
    setWords(answer.ok ? t("scan_done", { n: answer.value.devices.length }) : t("failed", { why: faultText(answer.refusal) || t("no_contact") }));
  };
  return (
    <span class="scan">
      <button disabled={busy} onClick={() => void look()}>{busy ? t("scanning") : t("scan")}</button>
      <span role="status">{words}</span>
    </span>
  );
}

export function Overview() {
  useLanguage();
  useStore(devices);
  const now = useStore(status);
  if (!now) return <p class="muted" role="status">{t("waiting_first")}</p>;
  const waiting = now.links.filter((link) => link.state !== "up").length;
  const heard = now.routes.filter((route) => route.via === "learned" || route.via === "pinned").length + replayedDevices(now).size;
  const coming = rateOf(now.links, ["frames_in"]);
  return (
    <div>
      <h1>{now.gateway.name} <small class="muted">{now.gateway.version} · {t("up_for", { time: inWords(now.gateway.uptime_s) })}</small></h1>
      <p class="facts">
        <span>{t("links_n", { n: now.links.length })}</span>
        {waiting > 0 && <span class="warn">{t("links_waiting", { n: waiting })}</span>}
        <span>{t("devices_n", { n: heard })}</span>
        <span>{t("frames_rate", { n: shortNumber(Math.round(coming ?? NaN)) })}</span>
        <Scan />
      </p>
      <Troubles status={now} />
      <section aria-labelledby="network">
        <h2 id="network">{t("network")}</h2>
        <Network status={now} />
      </section>
      <Drops links={now.links} />
    </div>
  );
}
