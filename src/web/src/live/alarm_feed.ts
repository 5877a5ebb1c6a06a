// What the gateway finds in alarm (GET /alarms), told whole at each change, so that all viewers see the same.
import { jsonIn } from "../json";
import { Connection } from "./connection";
import { alarmsIn, type Alarm } from "./limits";
import { Store } from "./store";

export const alarmsOfGateway = new Store<readonly Alarm[]>([]);

const connection = new Connection();

function take(message: string | ArrayBuffer): void {
  const body = typeof message === "string" ? jsonIn(message) : undefined;
  if (body !== undefined) alarmsOfGateway.set(alarmsIn(body, performance.now() / 1000));
}

/** Without limits there is nothing to hear of: then it takes no place among the streams of the gateway. */
export function followAlarms(isWanted: boolean): void {
  if (isWanted) return connection.open({ route: "/alarms", take });
  connection.close();
  if (alarmsOfGateway.get().length > 0) alarmsOfGateway.set([]);
}
