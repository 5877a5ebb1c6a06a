// Names for addresses.
import { whoText } from "./i18n";
import { devices, lostVehicles, status } from "./live/gateway";
import { hexByte } from "./protocol/table";
import { visible } from "./visible";

/** The name from the device; else the gateway's name for the address; else empty. */
export function nameOf(address: number): string {
  const hex = hexByte(address);
  const said = [...devices.get(), ...lostVehicles.get()].find((device) => Number(device.address) === address)?.name;
  const known = status.get(), replayed = known?.links.flatMap((link) => link.replayed ?? []) ?? [];
  return (said && visible(said)) || whoText([...(known?.routes ?? []), ...replayed].find((one) => one.address === hex)?.who ?? "");
}

export const called = (address: number): string => nameOf(address) || hexByte(address);
