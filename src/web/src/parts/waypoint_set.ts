// Waypoints in the gateway's format, and their positions on the ground. Pure.
import type { Place } from "../map/datum";
import type { Point } from "./ground";

export interface Waypoint {
  num: number;
  lng: number;
  lat: number;
  alt: number; // cm
  spd: number; // cm/s
  yaw: number; // degrees from north; 400: face the target
  fun: number;
  cmd: number[];
}

/** False for 0, 0, which devices send if they have no position. */
export const isPlace = (at: Place | undefined): at is Place => at !== undefined && (at.lng !== 0 || at.lat !== 0) && Math.abs(at.lat) <= 90 && Math.abs(at.lng) <= 180;

const metresPerDegree = 111_320;

/** Metres north and west of `home`; accurate for some kilometres. */
export function onGround(home: Place, at: Place): Point {
  return { x: (at.lat - home.lat) * metresPerDegree, y: -(at.lng - home.lng) * metresPerDegree * Math.cos((home.lat * Math.PI) / 180) };
}

/** The inverse of onGround(). */
export function onEarth(home: Place, at: Point): Place {
  const rounded = (n: number): number => Math.round(n * 1e7) / 1e7;
  return { lat: rounded(home.lat + at.x / metresPerDegree), lng: rounded(home.lng - at.y / (metresPerDegree * Math.cos((home.lat * Math.PI) / 180))) };
}

const numbers = ["num", "lng", "lat", "alt", "spd", "yaw", "fun"] as const;

/** The waypoints of a file in the gateway's format; undefined: another format. */
export function waypointsIn(json: unknown): Waypoint[] | undefined {
  const list = typeof json === "object" && json !== null ? (json as { waypoints?: unknown }).waypoints : undefined;
  if (!Array.isArray(list)) return undefined;
  const all = list.map((one): Waypoint | undefined => {
    if (typeof one !== "object" || one === null) return undefined;
    const given = one as Record<string, unknown>;
    if (numbers.some((name) => given[name] !== undefined && typeof given[name] !== "number")) return undefined;
    const number = (name: string): number => (given[name] as number | undefined) ?? 0;
    const cmd = Array.isArray(given.cmd) ? given.cmd.map(Number).slice(0, 4) : [];
    return { num: number("num"), lng: number("lng"), lat: number("lat"), alt: number("alt"), spd: number("spd"), yaw: number("yaw"), fun: number("fun"), cmd: [0, 1, 2, 3].map((i) => cmd[i] ?? 0) };
  });
  return all.some((one) => !one) ? undefined : (all as Waypoint[]);
}

/** Formats of other programs, which the gateway parses. */
export function foreignForm(json: unknown): "geojson" | "qgc" | undefined {
  const given = typeof json === "object" && json !== null ? (json as Record<string, unknown>) : {};
  return given.type === "FeatureCollection" || given.type === "Feature" ? "geojson" : given.fileType === "Plan" ? "qgc" : undefined;
}
