// Projects a box and a sphere onto a plane. X forward, Y left, Z up. Pure.
export type Vec = readonly [number, number, number];

export const faceNames = ["+x", "-x", "+y", "-y", "+z", "-z"] as const;
export type FaceName = (typeof faceNames)[number];

export const dot = (a: Vec, b: Vec): number => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];

const normals: Record<FaceName, Vec> = { "+x": [1, 0, 0], "-x": [-1, 0, 0], "+y": [0, 1, 0], "-y": [0, -1, 0], "+z": [0, 0, 1], "-z": [0, 0, -1] };

/** Rotates the box so that a face is up: by a quarter or half turn around a horizontal axis. */
export function turnedUp(face: FaceName, [x, y, z]: Vec): Vec {
  switch (face) {
    case "+x": return [-z, y, x];
    case "-x": return [z, y, -x];
    case "+y": return [x, -z, y];
    case "-y": return [x, z, -y];
    case "+z": return [x, y, z];
    case "-z": return [x, -y, -z];
  }
}

export interface View {
  right: Vec;
  up: Vec;
  towards: Vec; // direction to the viewer
}

/** The viewer is at `azimuth` around the vertical axis and elevation `height`, both in degrees. */
export function viewFrom(azimuth: number, height: number): View {
  const a = (azimuth * Math.PI) / 180, h = (height * Math.PI) / 180;
  return {
    towards: [Math.cos(h) * Math.cos(a), Math.cos(h) * Math.sin(a), Math.sin(h)],
    right: [-Math.sin(a), Math.cos(a), 0],
    up: [-Math.sin(h) * Math.cos(a), -Math.sin(h) * Math.sin(a), Math.cos(h)],
  };
}

export const flat = (view: View, v: Vec): [number, number] => [dot(view.right, v), -dot(view.up, v)];

export interface Flat {
  name: string;
  points: [number, number][];
  middle: [number, number];
}

const half: Vec = [1, 0.7, 0.35];

function corners(face: FaceName): Vec[] {
  const n = normals[face];
  const axis = n.findIndex((c) => c !== 0), [a, b] = [0, 1, 2].filter((k) => k !== axis) as [number, number];
  return [[-1, -1], [1, -1], [1, 1], [-1, 1]].map(([s, u]) => {
    const v = [0, 0, 0];
    v[axis] = n[axis]! * half[axis]!;
    v[a] = s! * half[a]!;
    v[b] = u! * half[b]!;
    return v as unknown as Vec;
  });
}

/** The visible faces of the box when `face` is up. */
export function boxFaces(face: FaceName, view: View): Flat[] {
  return faceNames
    .filter((name) => dot(turnedUp(face, normals[name]), view.towards) > 0.01)
    .map((name) => {
      const points = corners(name).map((corner) => flat(view, turnedUp(face, corner)));
      const middle: [number, number] = [points.reduce((s, p) => s + p[0], 0) / 4, points.reduce((s, p) => s + p[1], 0) / 4];
      return { name, points, middle };
    });
}

export interface Cell {
  index: number;
  points: [number, number][];
}

/** The visible cells of a sphere with cells of equal area. cell = band * sectors + sector; bands from the bottom, sectors from the back. */
export function sphereCells(bands: number, sectors: number, view: View): Cell[] {
  const at = (z: number, angle: number): Vec => {
    const r = Math.sqrt(Math.max(0, 1 - z * z));
    return [r * Math.cos(angle), r * Math.sin(angle), z];
  };
  const cells: Cell[] = [];
  for (let band = 0; band < bands; ++band)
    for (let sector = 0; sector < sectors; ++sector) {
      const z0 = -1 + (2 * band) / bands, z1 = -1 + (2 * (band + 1)) / bands;
      const a0 = -Math.PI + (2 * Math.PI * sector) / sectors, a1 = a0 + (2 * Math.PI) / sectors;
      if (dot(at((z0 + z1) / 2, (a0 + a1) / 2), view.towards) < 0.02) continue;
      const edge: Vec[] = [];
      for (let k = 0; k <= 6; ++k) edge.push(at(z0, a0 + ((a1 - a0) * k) / 6));
      for (let k = 0; k <= 6; ++k) edge.push(at(z1, a1 - ((a1 - a0) * k) / 6));
      cells.push({ index: band * sectors + sector, points: edge.map((v) => flat(view, v)) });
    }
  return cells;
}
