// Requests to a device through the gateway.
import { ask, type Answer } from "../api";
import { entryOf } from "../entries";
import { Store } from "./store";

export interface Command {
  id: number;
  name: string;
  text?: string;
  values: string[];
}

interface Identity {
  address: string;
  name?: string;
  hw?: number;
  sw?: number;
}

export interface Commands {
  device: Identity;
  commands: Command[];
}

export const path = (device: number, rest: string): string => `/devices/${device}/${rest}`;
const part = (name: string | number): string => encodeURIComponent(String(name));

const kept = new Map<number, Store<Commands | undefined>>();
const asking = new Set<number>();

/** The commands of a device; requested once, and again after a failure. */
export const commandsOf = (device: number): Store<Commands | undefined> => entryOf(kept, device, () => new Store<Commands | undefined>(undefined));

/** To be called after a firmware upgrade, which may change the commands. */
export const forgetCommands = (device: number): void => commandsOf(device).set(undefined);

/** `anew`: requests them from the device even if the gateway has them. */
export async function readCommands(device: number, anew = false): Promise<Answer<Commands> | undefined> {
  if (asking.has(device)) return undefined;
  asking.add(device);
  const answer = await ask<Commands>(path(device, anew ? "commands" : "commands?known"), { timeout: 60000 });
  asking.delete(device);
  if (answer.ok && Array.isArray(answer.value.commands)) commandsOf(device).set(answer.value);
  return answer;
}

/** By number; the name is sent as well, so that the gateway rejects the call if the number now belongs to another command. */
export const call = (device: number, command: Command, values: unknown[], repeat = false, type7 = ""): Promise<Answer<{ name: string; called: boolean }>> =>
  ask(path(device, "commands/" + part(command.id)), { method: "POST", body: { values, repeat, name: command.name, ...(type7 ? { type7 } : {}) }, timeout: 60000 });

/** A value type whose meaning the device does not state: the user has to choose it. */
export const openType = "f32|u64";

const plain = (name: string): string => name.replace(/[\s_-]+/g, "").toLowerCase();

/** The commands that lock and land, if the device has commands with these names and without values. */
export function pinnedOf(commands: readonly Command[]): { lock: Command | undefined; land: Command | undefined } {
  const called = (...names: string[]): Command | undefined => commands.find((command) => command.values.length === 0 && names.includes(plain(command.name)));
  return {
    lock: called("lock", "disarm", "上锁", "锁定", "加锁", "飞控上锁"),
    land: called("land", "landing", "一键降落", "降落", "着陆"),
  };
}
