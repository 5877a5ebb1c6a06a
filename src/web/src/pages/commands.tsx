// The commands that a device describes.
import { useEffect, useState } from "preact/hooks";
import { called } from "../addresses";
import { deviceText, t, useLanguage } from "../i18n";
import { call, commandsOf, openType, readCommands, type Command } from "../live/device";
import { mayAct } from "../live/gateway";
import { useStore } from "../live/store";
import { OutcomeLine, refusalText, useAction } from "../parts/action";
import { Confirm } from "../parts/confirm";
import { rangeText, valuesOf } from "../parts/command_values";
import { DeviceHeading, DeviceText, tx } from "../parts/device_text";

function CommandRow({ device, command }: { device: number; command: Command }) {
  const action = useAction();
  const [typed, setTyped] = useState<string[]>([]);
  const [repeat, setRepeat] = useState(false);
  const [type7, setType7] = useState("");
  const isOpen = command.values.includes(openType);
  const id = `command-${command.id}`;
  const values = valuesOf(command.values, typed);
  const run = (): void => {
    if (values) action.run(() => call(device, command, values, repeat, type7), () => t("called", { name: command.name }));
  };
  const question = tx("call_question", { name: command.name + (values?.length ? ` ${values.join(" ")}` : ""), device: called(device) });
  return (
    <li class="card command">
      <h2><DeviceText text={command.name} /></h2>
      {command.text && <p class="muted"><DeviceText text={deviceText(command.text)} /></p>}
      {command.values.length > 0 && (
        <div class="values">
          {command.values.map((type, i) => (
            <label key={i} for={`${id}-${i}`}>{type}<small>{rangeText(type)}</small>
              <input id={`${id}-${i}`} inputMode="decimal" placeholder="0" value={typed[i] ?? ""} onInput={(event) => { const next = [...typed]; next[i] = event.currentTarget.value; setTyped(next); }} />
            </label>
          ))}
        </div>
      )}
      {isOpen && (
        <label for={`${id}-type7`}>{t("type7")}
          <select id={`${id}-type7`} value={type7} onChange={(event) => setType7(event.currentTarget.value)}>
            {["", "f32", "u64"].map((type) => <option key={type} value={type}>{type || "?"}</option>)}
          </select>
        </label>
      )}
      {mayAct() && (
        <div class="tools">
          <Confirm label={t("call")} question={question} yes={t("yes_call")} disabled={action.busy || !values || (isOpen && !type7)} kind="main" onYes={run} />
          <label class="check"><input type="checkbox" checked={repeat} onChange={() => setRepeat(!repeat)} />{t("repeat")}</label>
        </div>
      )}
      {!values && <p class="bad">{t("bad_value", { types: command.values.map((type) => type + rangeText(type)).join(", ") })}</p>}
      <OutcomeLine action={action} />
    </li>
  );
}

export function Commands({ device }: { device: number }) {
  useLanguage();
  const known = useStore(commandsOf(device));
  const [fault, setFault] = useState("");
  const read = (anew: boolean): void => {
    setFault("");
    void readCommands(device, anew).then((answer) => {
      if (answer && !answer.ok) setFault(refusalText(answer.refusal));
    });
  };
  useEffect(() => read(false), [device]);
  return (
    <div>
      <DeviceHeading title={t("commands")} device={device} />
      <div class="tools">
        <button onClick={() => read(true)}>{t("read_again")}</button>
        <span role="status" class="bad"><DeviceText text={fault} /></span>
      </div>
      {!known && !fault && <p class="muted" role="status">{t("asking_device")}</p>}
      {known?.commands.length === 0 && <p class="muted">{t("no_commands")}</p>}
      <ul class="commands">{known?.commands.map((command) => <CommandRow key={command.id} device={device} command={command} />)}</ul>
    </div>
  );
}
