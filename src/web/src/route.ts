// The visible page: "#/frames", or "#/220/vehicle" for a device.
import { Store } from "./live/store";

export interface Place {
  page: string;
  device: number | undefined;
}

/** The page that opens when a device is chosen. */
export const pageOfDevice = "vehicle";

export function placeOf(hash: string): Place {
  const parts = hash.replace(/^#?\/?/, "").split("/");
  const number = Number(parts[0]);
  const isDevice = parts[0] !== "" && Number.isInteger(number) && number > 0 && number < 255;
  return isDevice ? { page: parts[1] ?? "", device: number } : { page: parts[0] ?? "", device: undefined };
}

export const hashOf = (place: Place): string => (place.device === undefined ? `#/${place.page}` : `#/${place.device}/${place.page}`);

export const place = new Store<Place>({ page: "", device: undefined });

export function beginRoute(): void {
  const look = (): void => place.set(placeOf(location.hash));
  addEventListener("hashchange", look);
  look();
}
