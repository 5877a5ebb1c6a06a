// The tracks of devices since the page was opened. Pure.
import { entryOf } from "../entries";
import type { Place } from "../map/datum";
import type { Point } from "./ground";
import { onGround } from "./waypoint_set";

const maxPoints = 6000;
const nearest = 0.05; // m; nearer points count as the same
const maxDistance = 100_000; // m from the start of a track: beyond this, a flat earth is not accurate enough

/** From the position reported by the device, relative to take-off. */
const tracks = new Map<number, Point[]>();
export const trackOf = (device: number): Point[] => entryOf(tracks, device, () => []);

/** From the satellite position. */
export interface EarthTrack {
  origin: Place;
  points: Point[];
}
const earthTracks = new Map<number, EarthTrack>();
export const earthTrackOf = (device: number): EarthTrack | undefined => earthTracks.get(device);

export function addPlace(device: number, place: Place): void {
  let track = earthTracks.get(device);
  const from = track && onGround(track.origin, place);
  if (!track || Math.hypot(from!.x, from!.y) > maxDistance) earthTracks.set(device, (track = { origin: place, points: [] }));
  addPoint(track.points, onGround(track.origin, place));
}

export function addPoint(track: Point[], point: Point): void {
  const last = track[track.length - 1];
  if (last && Math.hypot(last.x - point.x, last.y - point.y) < nearest) return;
  track.push(point);
  // Of the older half, removes every second point, which preserves the shape.
  if (track.length > maxPoints) {
    const half = track.splice(0, maxPoints / 2).filter((_, i) => i % 2 === 0);
    track.unshift(...half);
  }
}

export function clearTracks(device: number): void {
  trackOf(device).length = 0;
  const track = earthTracks.get(device);
  if (track) track.points.length = 0;
}
