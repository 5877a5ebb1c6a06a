// Receives the current alarms and the lost devices from the gateway (GET /alarms): the complete state at each change, so that all viewers see the
// same. Also while the page is hidden.
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
