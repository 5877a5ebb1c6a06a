// The pictures of the gateway's map, loaded when they become visible.
import { onHeard, onTokenNeeded, path, refusalOf } from "../api";
import { Store } from "../live/store";
import { MapFile } from "./map_file";
import { MapFault, type Part } from "./pmtiles";

const maxKept = 160; // pictures: 40 MB at 256 × 256 pixels
const maxRequests = 6; // at the same time; others are requested later if still needed
const againAfter = 5000; // milliseconds after a failed request

type Kept = { picture?: ImageBitmap; asked?: boolean; failedAt?: number; none?: boolean };

/** Changes when a picture was loaded, so that the map is redrawn. */
export const mapNews = new Store(0);
/** The reason why no map can be shown. undefined: there is a map, or it is not known yet. */
export const mapFault = new Store<MapFault | undefined>(undefined);

export class MapTiles {
  private opening: Promise<MapFile> | undefined;
  private file: MapFile | undefined;
  private readonly kept = new Map<string, Kept>();
  private asking = 0;
  private failedAt = Number.NEGATIVE_INFINITY;
  private version = "";
  attribution = "";

  /** The zooms of the map; undefined: not known yet. */
  get zooms(): { minZoom: number; maxZoom: number } | undefined {
    if (!this.file) void this.open().catch(() => undefined);
    return this.file?.header;
  }

  /** The picture, if already loaded; with `ask`, a missing one is requested. */
  picture(zoom: number, x: number, y: number, ask: boolean): ImageBitmap | undefined {
    const key = `${zoom}/${x}/${y}`;
    const known = this.kept.get(key);
    if (known?.picture) {
      this.kept.delete(key); // moved to the end: most recently used
      this.kept.set(key, known);
      return known.picture;
    }
    const mayAsk = !known || (!known.asked && !known.none && performance.now() - (known.failedAt ?? 0) > againAfter);
    if (ask && mayAsk && this.asking < maxRequests) void this.ask(key, zoom, x, y);
    return undefined;
  }

  private async ask(key: string, zoom: number, x: number, y: number): Promise<void> {
    const one: Kept = { asked: true };
    this.kept.set(key, one);
    ++this.asking;
    try {
      const blob = await (await this.open()).tile(zoom, x, y);
      if (blob) one.picture = await createImageBitmap(blob).catch(() => { throw new MapFault("tile_no_image"); });
      else one.none = true;
      if (one.picture) mapFault.set(undefined);
    } catch (fault) {
      one.failedAt = performance.now();
      const isBlank = ![...this.kept.values()].some((other) => other.picture);
      if (isBlank && fault instanceof MapFault) mapFault.set(fault);
    }
    one.asked = false;
    --this.asking;
    this.forgetOldest();
    mapNews.update((n) => n + 1);
  }

  private forgetOldest(): void {
    for (const [key, one] of this.kept) {
      if (this.kept.size <= maxKept) return;
      if (one.asked) continue;
      one.picture?.close();
      this.kept.delete(key);
    }
  }

  private open(): Promise<MapFile> {
    if (this.opening) return this.opening;
    if (performance.now() - this.failedAt < againAfter) return Promise.reject(mapFault.get());
    this.opening = MapFile.open((part) => this.read(part));
    this.opening.then(
      async (file) => {
        this.file = file;
        mapFault.set(undefined);
        this.attribution = await file.attribution().catch(() => "");
        mapNews.update((n) => n + 1);
      },
      (fault: unknown) => {
        this.failedAt = performance.now();
        this.opening = undefined;
        mapFault.set(fault instanceof MapFault ? fault : undefined);
      },
    );
    return this.opening;
  }

  private async read({ at, size }: Part): Promise<ArrayBuffer> {
    if (size === 0) return new ArrayBuffer(0);
    const response = await fetch(path("/map.pmtiles"), { cache: "no-store", credentials: "same-origin", headers: { Range: `bytes=${at}-${at + size - 1}` } });
    onHeard.call();
    if (response.status === 401) onTokenNeeded.call();
    if (response.status !== 206) throw new MapFault(refusalOf(response.status, await response.json().catch(() => undefined)));
    const version = response.headers.get("ETag") ?? "";
    if (this.version !== "" && version !== this.version) return this.beginAnew();
    this.version = version;
    return response.arrayBuffer();
  }

  /** The file was replaced: discards all data of the old one. */
  private beginAnew(): never {
    this.version = "";
    this.file = this.opening = undefined;
    for (const one of this.kept.values()) one.picture?.close();
    this.kept.clear();
    throw new MapFault("map_replaced");
  }
}

export const mapTiles = new MapTiles();
