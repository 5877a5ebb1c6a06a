// What the gateway finds in alarm and which devices it has lost (GET /alarms), told whole at each change, so that all viewers see the same; also
// to a hidden page.
import { jsonIn } from "../json";
import { Connection } from "./connection";
import { hurry } from "./gateway";
import { alarmsIn, type Alarm } from "./limits";
import { Store } from "./store";
import { heardDevicesIn, type HeardDevice } from "./heard_devices";

export const alarmsOfGateway = new Store<readonly Alarm[]>([]);

/** `told` is called for each message. */
export function followAlarms(told: (heard: HeardDevice[]) => void): void {
  const take = (message: string | ArrayBuffer): void => {
    const body = typeof message === "string" ? jsonIn(message) : undefined, now = performance.now() / 1000;
    if (body === undefined) return;
    alarmsOfGateway.set(alarmsIn(body, now));
    told(heardDevicesIn(body, now));
  };
  new Connection().open({ route: "/alarms", whileHidden: true, take, opened: hurry, closed: hurry });
}
