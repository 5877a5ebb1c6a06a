// The frame around every page: the present page, the state of the gateway, the navigation.
import type { ComponentChildren } from "preact";
import { useEffect, useRef, useState } from "preact/hooks";
import { t, setLanguage, useLanguage } from "./i18n";
import { access, contact, devices, logIn, silentFor, status, tokenNeeded } from "./live/gateway";
import { replayedDevices } from "./live/replayed";
import { useStore, useTick } from "./live/store";
import { nameOf } from "./addresses";
import { hexByte } from "./protocol/table";
import { Pinned } from "./parts/pinned";
import { pages, pageAt, type Page } from "./pages";
import { hashOf, place } from "./route";
import { setTheme, theme, themes } from "./theme";

function ContactLamp() {
  useTick(500);
  const known = useStore(contact), needed = useStore(tokenNeeded);
  const state = needed ? "shut" : known;
  const words = state === "shut" ? t("token_needed") : state === "live" ? t("live") : state === "never" ? t("connecting") : silentFor() < 1 ? t("no_contact_now") : t("no_contact_for", { s: Math.floor(silentFor()) });
  return (
    <span class={`contact ${state}`} role="status">
      <i class="lamp" aria-hidden="true" />
      {words}
    </span>
  );
}

function Switches() {
  const language = useLanguage();
  const now = useStore(theme);
  const next = themes[(themes.indexOf(now) + 1) % themes.length]!;
  const sign = { auto: "◐", light: "☀", dark: "☾" }[now];
  return (
    <span class="switches">
      <button class="plain" lang={language === "zh" ? "en" : "zh-CN"} onClick={() => setLanguage(language === "zh" ? "en" : "zh")}>
        {t("language")}
      </button>
      <button class="plain" title={t(`theme_${now}`)} aria-label={t(`theme_${now}`)} onClick={() => setTheme(next)}>
        {sign}
      </button>
    </span>
  );
}

/** The addresses whose pages are offered: those that were heard, except hosts; those in a recording; and the chosen one. */
function useDevices(chosen: number | undefined, replayed: Map<number, string>): number[] {
  const heard = useStore(devices).map((device) => Number(device.address));
  const all = new Set([...heard.filter((address) => address !== 0xfe && address !== 0xd2), ...replayed.keys()]);
  if (chosen !== undefined) all.add(chosen);
  return [...all].sort((a, b) => a - b);
}

/** `among`: the number of tabs; when it changes, this one may have to be scrolled into view again. */
function Tab({ page, device, here, among }: { page: Page; device?: number | undefined; here: boolean; among: number }) {
  const ref = useRef<HTMLAnchorElement>(null);
  useEffect(() => {
    if (here) ref.current?.scrollIntoView({ block: "nearest", inline: "center" });
  }, [here, among]);
  return (
    <li>
      <a ref={ref} href={hashOf({ page: page.name, device })} aria-current={here ? "page" : undefined}>
        {t(page.title)}
      </a>
    </li>
  );
}

function Navigation() {
  const now = useStore(place);
  const here = pageAt(now);
  const replayed = replayedDevices(useStore(status));
  const all = useDevices(now.device, replayed);
  const remembered = useRef<number | undefined>(undefined);
  if (now.device !== undefined) remembered.current = now.device;
  const device = now.device ?? remembered.current ?? all.find((address) => address === 0xdc) ?? all[0];
  const offered = (of: number): Page[] => pages.filter((page) => page.ofDevice && !(page.asks && replayed.has(of)));
  const ofDevice = device === undefined ? [] : offered(device);
  return (
    <nav aria-label={t("pages")}>
      <ul>
        {pages.filter((page) => !page.ofDevice).map((page) => (
          <Tab key={page.name} page={page} here={page === here} among={all.length} />
        ))}
      </ul>
      {device !== undefined && ofDevice.length > 0 && (
        <>
          <select
            aria-label={t("device")}
            value={String(device)}
            onChange={(event) => {
              const chosen = Number(event.currentTarget.value), there = offered(chosen);
              const page = there.includes(here) ? here.name : there[0]!.name;
              location.hash = hashOf({ page, device: chosen });
            }}
          >
            {all.map((address) => (
              <option key={address} value={String(address)}>
                {hexByte(address)} {nameOf(address)}{replayed.has(address) ? ` · ${t("replayed")}` : ""}
              </option>
            ))}
          </select>
          <select
            class={here.ofDevice ? "narrow here" : "narrow"}
            aria-label={t("pages_of_device")}
            value={here.ofDevice ? here.name : ""}
            onChange={(event) => { location.hash = hashOf({ page: event.currentTarget.value, device }); }}
          >
            {!here.ofDevice && <option value="">{t("open_page")}</option>}
            {ofDevice.map((page) => (
              <option key={page.name} value={page.name}>{t(page.title)}</option>
            ))}
          </select>
          <ul class="roomy">
            {ofDevice.map((page) => (
              <Tab key={page.name} page={page} device={device} here={page === here} among={all.length} />
            ))}
          </ul>
        </>
      )}
    </nav>
  );
}

function Login() {
  const [token, setToken] = useState("");
  const [wrong, setWrong] = useState("");
  const [busy, setBusy] = useState(false);
  const enter = async (event: Event): Promise<void> => {
    event.preventDefault();
    if (busy) return;
    setBusy(true);
    const fault = await logIn(token);
    setBusy(false);
    setWrong(fault === "no_contact" ? t("no_contact") : fault);
  };
  return (
    <form class="login card" onSubmit={(event) => void enter(event)}>
      <h1>{t("token_title")}</h1>
      <p>{t("token_where", { command: "anoctl web" })}</p>
      <label>
        {t("token")}
        <input type="password" autocomplete="current-password" required autofocus value={token} onInput={(event) => setToken(event.currentTarget.value)} />
      </label>
      <button class="main" disabled={busy}>{t("token_enter")}</button>
      {wrong && <p class="bad" role="alert">{wrong}</p>}
    </form>
  );
}

function Banner() {
  const state = useStore(contact);
  if (state !== "lost") return null;
  return (
    <p class="banner" role="alert">
      <b>{t("no_contact")}{t("full_stop")}</b>{t("old_values")}
    </p>
  );
}

/** A note when two devices have this address: the pages show values of both, and commands may reach either. */
function ConflictNote({ device }: { device: number }) {
  const conflict = useStore(status)?.conflicts.find((one) => Number(one.address) === device);
  if (!conflict) return null;
  return (
    <p class="note clash" role="alert">
      <b>{t("two_claim", { address: hexByte(device) })}</b> {t("two_claim_more", { links: (conflict.links ?? []).join(", ") })}
    </p>
  );
}

/** A note that the chosen device exists only in a recording. */
function ReplayedNote({ link }: { link: string }) {
  return <p class="note" role="status">{t("replayed_more", { link })}</p>;
}

function Body({ children }: { children: ComponentChildren }) {
  const state = useStore(contact);
  return (
    <main id="content" tabIndex={-1} class={state === "lost" ? "old" : ""}>
      {children}
    </main>
  );
}

export function App() {
  useLanguage();
  const now = useStore(place);
  const needed = useStore(tokenNeeded);
  const known = useStore(status);
  const may = useStore(access);
  const page = pageAt(now);
  useEffect(() => {
    const whose = page.ofDevice && now.device !== undefined ? nameOf(now.device) || hexByte(now.device) : known?.gateway.name;
    document.title = `${t(page.title)} · ${whose ?? "anogate"}`;
  });
  const replayedBy = page.ofDevice && now.device !== undefined ? replayedDevices(known).get(now.device) : undefined;
  const mayAsk = known !== undefined && replayedBy === undefined;
  const View = page.view;
  return (
    <>
      <a class="skip" href="#content" onClick={(event) => { event.preventDefault(); document.getElementById("content")?.focus(); }}>{t("skip")}</a>
      <header class="top">
        <a class="brand" href="#/">anogate</a>
        <span class="of">{known && known.gateway.name !== "anogate" ? known.gateway.name : ""}</span>
        <ContactLamp />
        <Switches />
      </header>
      {!needed && <Navigation />}
      <Body>
        <Banner />
        {needed ? <Login /> : (
          <>
            {may === "view" && known?.http.token_needed && <p class="note">{t("only_view")}</p>}
            {page.ofDevice && now.device !== undefined && <ConflictNote device={now.device} />}
            {replayedBy !== undefined && <ReplayedNote link={replayedBy} />}
            {page.asks && !mayAsk ? <h1>{t(page.title)}</h1> : <View key={`${page.name} ${now.device ?? ""}`} device={now.device ?? 0} />}
          </>
        )}
      </Body>
      {!needed && page.ofDevice && now.device !== undefined && mayAsk && <Pinned key={now.device} device={now.device} />}
    </>
  );
}
