// Reads the gateway's map by HTTP ranges: only the parts that are needed.
import { damaged, headerOf, headerSize, directoryOf, entryFor, MapFault, tileNumber, type Entry, type MapHeader, type Part } from "./pmtiles";

/** Reads the bytes of a part; returns fewer at the end of the file. */
export type ReadPart = (part: Part) => Promise<ArrayBuffer>;

const firstBytes = 16384; // contain the header and the root directory
const maxDirectory = 4 << 20; // bytes, uncompressed
const maxTile = 4 << 20;
const maxAbout = 1 << 20;
const maxLevels = 4; // levels of directories
const keptDirectories = 32;

async function unpacked(bytes: ArrayBuffer, maxBytes: number, what: string): Promise<Uint8Array> {
  const reader = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip")).getReader();
  const parts: Uint8Array[] = [];
  let size = 0;
  for (let part = await reader.read(); !part.done; part = await reader.read()) {
    parts.push(part.value);
    if ((size += part.value.length) > maxBytes) throw damaged(`${what} is too large`);
  }
  const all = new Uint8Array(size);
  let at = 0;
  for (const part of parts) (all.set(part, at), (at += part.length));
  return all;
}

/** Removes HTML tags: the attribution is shown as text. */
const plain = (html: string): string => html.replace(/<[^>]*>/g, "").replace(/&copy;/g, "©").replace(/&amp;/g, "&").trim().slice(0, 200);

export class MapFile {
  private readonly directories = new Map<number, Promise<Entry[]>>();

  private constructor(
    private readonly read: ReadPart,
    readonly header: MapHeader,
  ) {}

  static async open(read: ReadPart): Promise<MapFile> {
    const first = await read({ at: 0, size: firstBytes });
    const header = headerOf(first);
    const { at, size } = header.root;
    if (at < headerSize || at + size > firstBytes) throw damaged("its first directory is not where it must be");
    const file = new MapFile(read, header), root = await file.entriesIn(first.slice(at, at + size));
    file.directories.set(at, Promise.resolve(root));
    return file;
  }

  /** The attribution required by the maker of the map. */
  async attribution(): Promise<string> {
    const { about } = this.header;
    if (about.size === 0 || about.size > maxAbout) return "";
    const bytes = await this.bytesOf(await this.read(about), maxAbout, "its description");
    const json = JSON.parse(new TextDecoder().decode(bytes)) as { attribution?: unknown };
    return typeof json.attribution === "string" ? plain(json.attribution) : "";
  }

  /** The picture of a tile; undefined: the map has none. */
  async tile(zoom: number, x: number, y: number): Promise<Blob | undefined> {
    const number = tileNumber(zoom, x, y);
    let directory: Part = this.header.root;
    for (let level = 0; level < maxLevels; ++level) {
      const entry = entryFor(await this.entries(directory), number);
      if (!entry) return undefined;
      if (entry.run > 0) return this.picture({ at: this.header.tiles.at + entry.at, size: entry.size });
      directory = { at: this.header.leaves.at + entry.at, size: entry.size };
    }
    throw damaged("its directories form a loop");
  }

  private async picture(part: Part): Promise<Blob> {
    if (part.size > maxTile) throw new MapFault("tile_too_large");
    return new Blob([await this.read(part)], { type: this.header.type });
  }

  private async bytesOf(bytes: ArrayBuffer, maxBytes: number, what: string): Promise<Uint8Array> {
    if (!this.header.packed) return new Uint8Array(bytes);
    return unpacked(bytes, maxBytes, what).catch((fault: unknown) => { throw fault instanceof MapFault ? fault : damaged(`${what} is damaged`); });
  }

  private async entriesIn(bytes: ArrayBuffer): Promise<Entry[]> {
    return directoryOf(await this.bytesOf(bytes, maxDirectory, "a directory"));
  }

  private entries(part: Part): Promise<Entry[]> {
    let known = this.directories.get(part.at);
    if (known) return known;
    if (part.size > maxDirectory) throw damaged("a directory is too large");
    if (this.directories.size > keptDirectories) this.directories.delete([...this.directories.keys()].find((at) => at !== this.header.root.at)!);
    known = this.read(part).then((bytes) => this.entriesIn(bytes));
    this.directories.set(part.at, known);
    known.catch(() => this.directories.delete(part.at)); // read again next time
    return known;
  }
}
