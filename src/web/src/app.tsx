// The frame around every page: header, navigation, alerts and the current page.
import type { ComponentChildren } from "preact";
import { useEffect, useLayoutEffect, useRef, useState } from "preact/hooks";
import type { Refusal } from "./api";
import { inWords, t, setLanguage, useLanguage } from "./i18n";
import { rateText } from "./format";
import { access, contact, devices, isDigits, logIn, logOut, lostVehicles, silentFor, status, tokenNeeded, type Status } from "./live/gateway";
import { editedPages, isEdited } from "./live/edits";
import { replayedDevices } from "./live/replayed";
import { linkIsOver } from "./live/sign_in";
import { useStore, useTick } from "./live/store";
import { ageOf, alarms, lostDevices, lostNews, seenRateOf } from "./live/watch";
import { called, nameOf } from "./addresses";
import { hexByte, isHost } from "./protocol/table";
import { Alerts, alertTitle } from "./parts/alerts";
import { DeviceName } from "./parts/device_text";
import { Pinned } from "./parts/pinned";
import { setSound, soundOn } from "./parts/sound";
import { pages, pageAt, type Page } from "./pages";
import { hashOf, place } from "./route";
import { setTheme, theme, themes } from "./theme";
import { isolated } from "./visible";

function ContactLamp() {
  useTick(500);
  const known = useStore(contact), needed = useStore(tokenNeeded);
  const state = needed ? "shut" : known;
  const words = state === "shut" ? t("token_needed") : state === "live" ? t("live") : state === "never" ? t("connecting") : silentFor() < 1 ? t("no_contact_now") : t("no_contact_for", { s: Math.floor(silentFor()) });
  return (
    <span class={`contact ${state}`} role="status">
      <i class="lamp" aria-hidden="true" />
      <span class="words">{words}</span>
    </span>
  );
}

/** The chosen device, its rate, and the age of its last frame. */
function DeviceLamp({ device }: { device: number }) {
  useTick(200);
  const one = useStore(devices).find((one) => Number(one.address) === device);
  const isLost = useStore(lostDevices).has(device), gateway = useStore(contact);
  const seen = ageOf(device), age = seen ?? one?.age;
  const isHeard = gateway === "live" && !isLost && seen !== undefined;
  const rate = one?.rate !== undefined && one.rate > 0 ? rateText(one.rate) : t("at_least", { n: rateText(seenRateOf(device)) });
  return (
    <span class={`contact-of-device ${isLost ? "lost" : isHeard ? "live" : "never"}`} role="status" aria-live="off">
      <i class="lamp" aria-hidden="true" />
      <b><DeviceName device={device} /></b>{" "}
      <span class="number">
        {isLost ? t("no_data_for", { time: inWords(age ?? 0) })
          : isHeard ? `${rate} ${t("per_second")} · ${t("in_seconds", { s: age! < 10 ? age!.toFixed(1) : Math.floor(age!) })}`
          : age === undefined ? t("not_heard_yet") : t("ago", { time: inWords(age) })}
      </span>
    </span>
  );
}

/** Only for sessions that signed in with a token. */
function SignOut() {
  const may = useStore(access), needed = useStore(tokenNeeded), known = useStore(status);
  if (needed || may === "" || known?.http.token_needed !== true) return null;
  return <button class="plain sign-out" onClick={() => void logOut()}>{t("sign_out")}</button>;
}

function Switches() {
  const language = useLanguage();
  const now = useStore(theme), sounds = useStore(soundOn);
  const next = themes[(themes.indexOf(now) + 1) % themes.length]!;
  const sign = { auto: "◐", light: "☀", dark: "☾" }[now];
  return (
    <span class="switches">
      <button class="plain" lang={language === "zh" ? "en" : "zh-CN"} onClick={() => setLanguage(language === "zh" ? "en" : "zh")}>
        {t("language")}
      </button>
      <button class="plain sound" aria-pressed={!sounds} title={t(sounds ? "sound_on" : "sound_off")} aria-label={t(sounds ? "sound_on" : "sound_off")} onClick={() => setSound(!sounds)}>
        <svg viewBox="0 0 20 20" width="18" height="18" aria-hidden="true"><path d="M3 8v4h3l4 4V4L6 8zM13 7q3 3 0 6" fill="none" stroke="currentColor" stroke-width="1.8" stroke-linejoin="round" stroke-linecap="round" />{!sounds && <path d="M2 2l16 16" stroke="currentColor" stroke-width="2" />}</svg>
      </button>
      <button class="plain" title={t(`theme_${now}`)} aria-label={t(`theme_${now}`)} onClick={() => setTheme(next)}>
        {sign}
      </button>
      <SignOut />
    </span>
  );
}

/** The addresses with pages: known devices except hosts, lost vehicles, devices in replayed recordings, and the chosen one. */
function useDevices(chosen: number | undefined, replayed: Map<number, string>): number[] {
  const heard = [...useStore(devices), ...useStore(lostVehicles)].map((device) => Number(device.address));
  const all = new Set([...heard.filter((address) => !isHost(address)), ...replayed.keys()]);
  if (chosen !== undefined) all.add(chosen);
  return [...all].sort((a, b) => a - b);
}

/** `among`: the number of tabs; when it changes, the tab is scrolled into view again. */
function Tab({ page, device, here, among }: { page: Page; device?: number | undefined; here: boolean; among: number }) {
  const ref = useRef<HTMLAnchorElement>(null);
  const marked = isEdited(useStore(editedPages), device ?? 0, page.name);
  useEffect(() => {
    if (here) ref.current?.scrollIntoView({ block: "nearest", inline: "center" });
  }, [here, among]);
  return (
    <li>
      <a ref={ref} href={hashOf({ page: page.name, device })} aria-current={here ? "page" : undefined}>
        {t(page.title)}{marked && <i class="edited" role="img" aria-label={t("unsaved")} title={t("unsaved")} />}
      </a>
    </li>
  );
}

/** The chosen device, also for pages of the gateway: the last one chosen, else the flight controller at 0xDC, else the first device. */
function useSelected(chosen: number | undefined, all: number[]): number | undefined {
  const remembered = useRef<number | undefined>(undefined);
  if (chosen !== undefined) remembered.current = chosen;
  return chosen ?? remembered.current ?? all.find((address) => address === 0xdc) ?? all[0];
}

function Navigation({ all, device, replayed }: { all: number[]; device: number | undefined; replayed: Map<number, string> }) {
  const here = pageAt(useStore(place)), edited = useStore(editedPages);
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
            title={isEdited(edited, device) ? t("unsaved") : undefined}
            value={String(device)}
            onChange={(event) => {
              const chosen = Number(event.currentTarget.value), there = offered(chosen);
              const page = there.includes(here) ? here.name : there[0]!.name;
              location.hash = hashOf({ page, device: chosen });
            }}
          >
            {all.map((address) => (
              <option key={address} value={String(address)} title={isEdited(edited, address) ? t("unsaved") : undefined}>
                {isEdited(edited, address) ? "• " : ""}{hexByte(address)} {isolated(nameOf(address))}{replayed.has(address) ? ` · ${t("replayed")}` : ""}
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

/** Shown above each page in a read-only session, with a form for the control token. */
function OnlyView() {
  const [enters, setEnters] = useState(false);
  if (enters) return <Login title={t("control_enter")} done={() => setEnters(false)} />;
  return (
    <p class="note only-view">
      {t("only_view")} <button class="plain" onClick={() => setEnters(true)}>{t("control_enter")}</button>
    </p>
  );
}

function loginFault({ status, error }: Refusal, kind: "token" | "code"): string {
  if (status === 401) return t(kind === "code" ? "code_wrong" : "token_wrong");
  if (status === 429) return t("too_many_wrong");
  return status === 0 ? t("no_contact") : error;
}

/** `done`: called when the form is closed; without it, the form can't be closed without a token. */
function Login({ title = t("token_title"), done }: { title?: string; done?: () => void }) {
  const [token, setToken] = useState("");
  const [wrong, setWrong] = useState("");
  const [busy, setBusy] = useState(false);
  const isOver = useStore(linkIsOver);
  const enter = async (event: Event): Promise<void> => {
    event.preventDefault();
    if (busy) return;
    setBusy(true);
    linkIsOver.set(false);
    const typed = token.replace(/\s/g, ""), kind = isDigits(typed) ? "code" : "token";
    const refusal = await logIn(typed, kind);
    setBusy(false);
    if (!refusal) done?.();
    setWrong(refusal ? loginFault(refusal, kind) : "");
  };
  return (
    <form class="login card" onSubmit={(event) => void enter(event)}>
      <h1>{title}</h1>
      <p>{t("token_where", { pair: "sudo anoctl web --pair", qr: "--qr", command: "anoctl web" })}</p>
      <label>
        {t("token")}
        <input type="password" autocomplete="current-password" required autofocus value={token} onInput={(event) => setToken(event.currentTarget.value)} />
      </label>
      <button class="main" disabled={busy}>{t("token_enter")}</button>
      {done && <button type="button" onClick={done}>{t("cancel")}</button>}
      {(wrong || isOver) && <p class="bad" role="alert">{wrong || t("link_is_over")}</p>}
    </form>
  );
}

/** The text for two devices with one address. If the address has a route or is pinned, the pages show only the values of that device, and it receives
 * the commands. Otherwise the values and commands may belong to either device. */
function conflictWords({ links = [], home = [], pinned, claimed_by: by }: Status["conflicts"][number]): string {
  if (!by || home.length === 0) return t("two_claim_more", { links: links.join(", ") });
  const values = { home: home.join(", "), by: by.peer ? `${by.link} (${by.peer})` : by.link };
  return t(pinned ? "two_claim_pinned" : "two_claim_home", values);
}

function ConflictNote({ device }: { device: number }) {
  const conflict = useStore(status)?.conflicts.find((one) => Number(one.address) === device);
  if (!conflict) return null;
  return (
    <p class="note clash" role="alert">
      <b>{t("two_claim", { address: hexByte(device) })}</b> {conflictWords(conflict)}
    </p>
  );
}

/** A note that the chosen device exists only in a replayed recording. */
function ReplayedNote({ link }: { link: string }) {
  return <p class="note" role="status">{t("replayed_more", { link })}</p>;
}

/** Greyed out if the gateway, or the device of the page, is lost. */
function Body({ device, children }: { device: number | undefined; children: ComponentChildren }) {
  const state = useStore(contact), lost = useStore(lostDevices);
  const isOld = state === "lost" || (device !== undefined && lost.has(device));
  return (
    <main id="content" tabIndex={-1} class={isOld ? "old" : ""}>
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
  useStore(lostNews);
  useStore(alarms);
  useStore(contact);
  useEffect(() => scrollTo(0, 0), [page, now.device]);
  useLayoutEffect(() => { // not useEffect: on a hidden page it runs about a second late
    const whose = page.ofDevice && now.device !== undefined ? called(now.device) : known?.gateway.name;
    document.title = `${alertTitle()}${t(page.title)} · ${whose ?? "anogate"}`;
  });
  const replayed = replayedDevices(known), all = useDevices(now.device, replayed), selected = useSelected(now.device, all);
  const replayedBy = page.ofDevice && now.device !== undefined ? replayed.get(now.device) : undefined;
  const mayAsk = known !== undefined && replayedBy === undefined;
  const View = page.view;
  return (
    <>
      <a class="skip" href="#content" onClick={(event) => { event.preventDefault(); document.getElementById("content")?.focus(); }}>{t("skip")}</a>
      <header class="top">
        <a class="brand" href="#/">anogate</a>
        <span class="of">{known && known.gateway.name !== "anogate" ? known.gateway.name : ""}</span>
        <ContactLamp />
        {!needed && selected !== undefined && <DeviceLamp device={selected} />}
        <Switches />
      </header>
      {!needed && <Navigation all={all} device={selected} replayed={replayed} />}
      <Body device={page.ofDevice ? now.device : undefined}>
        <Alerts />
        {needed ? <Login /> : (
          <>
            {may === "view" && known?.http.token_needed && <OnlyView />}
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
