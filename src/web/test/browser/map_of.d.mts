export interface Tile {
  zoom: number;
  x: number;
  y: number;
  picture: Uint8Array;
}
export function mapFile(tiles: Tile[], how?: { leaves?: boolean | undefined; packed?: boolean | undefined; attribution?: string }): Uint8Array;
