// The names of addresses.
import { whoText } from "./i18n";
import { devices, status } from "./live/gateway";
import { hexByte } from "./protocol/table";

/** The name that the device gives itself, else the gateway's name for the address. */
export function nameOf(address: number): string {
  const hex = hexByte(address);
  const said = devices.get().find((device) => Number(device.address) === address)?.name;
  const known = status.get(), replayed = known?.links.flatMap((link) => link.replayed ?? []) ?? [];
  return said || whoText([...(known?.routes ?? []), ...replayed].find((one) => one.address === hex)?.who ?? "");
}
