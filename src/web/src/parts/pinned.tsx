// The buttons for lock and land, on all pages of a device that has these commands.
import { useEffect } from "preact/hooks";
import { t } from "../i18n";
import { call, commandsOf, pinnedOf, readCommands, type Command } from "../live/device";
import { contact, mayAct } from "../live/gateway";
import { useStore } from "../live/store";
import { OutcomeLine, useAction } from "./action";
import { HoldButton } from "./hold_button";

const askAgainAfter = 10000;

export function Pinned({ device }: { device: number }) {
  const known = useStore(commandsOf(device));
  const state = useStore(contact);
  const action = useAction();
  useEffect(() => {
    if (known || state !== "live") return undefined;
    void readCommands(device);
    const timer = setInterval(() => void readCommands(device), askAgainAfter);
    return () => clearInterval(timer);
  }, [device, known, state]);
  const { lock, land } = pinnedOf(known?.commands ?? []);
  if (!mayAct() || (!lock && !land)) return null;
  const run = (command: Command): void => action.run(() => call(device, command, []), () => t("called", { name: command.name }));
  return (
    <aside class="pinned" aria-label={t("safety")}>
      {land && <HoldButton label={t("land")} kind="land" disabled={action.busy} onHeld={() => run(land)} />}
      {lock && <HoldButton label={t("lock")} kind="lock" disabled={action.busy} onHeld={() => run(lock)} />}
      {action.busy || action.outcome ? <OutcomeLine action={action} /> : <small class="muted">{t("hold_hint")}</small>}
    </aside>
  );
}
