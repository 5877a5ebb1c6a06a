// Reads the header of a .bia file (protocol.md, 0xF0). Pure.
export interface FirmwareFile {
  bytes: number; // of the image, without the header
  header?: { version: number; crc: number; hwType: number; hwMin: number; hwMax: number };
}

const headerSize = 100;

export function firmwareFile(start: ArrayBuffer, size: number): FirmwareFile {
  const view = new DataView(start);
  const isBia = start.byteLength >= headerSize && view.getUint8(0) === 0x62 && view.getUint8(1) === 0x69 && view.getUint8(2) === 0x61;
  if (!isBia) return { bytes: size };
  return {
    bytes: size - headerSize,
    header: { version: view.getUint16(10, true), crc: view.getUint16(12, true), hwType: view.getUint8(20), hwMin: view.getUint16(30, true), hwMax: view.getUint16(32, true) },
  };
}
