// Converts positions to GCJ-02, the datum of maps made in China, which is shifted by some hundred metres from WGS 84. Pure.

export interface Place {
  lng: number; // degrees
  lat: number;
}

export type Datum = "wgs84" | "gcj02";

// The Krassowsky ellipsoid, on which the shift is defined.
const axis = 6378245.0; // m
const eccentricity = 0.00669342162296594323; // squared

/** Maps of other countries are not shifted. */
const isShifted = ({ lng, lat }: Place): boolean => lng >= 72.004 && lng <= 137.8347 && lat >= 0.8293 && lat <= 55.8271;

/** A pair of sine waves, one of the terms of the shift. */
const wave = (a: number, p: number, b: number, q: number): number => ((a * Math.sin(p * Math.PI) + b * Math.sin(q * Math.PI)) * 2) / 3;

/** The shift in metres; x and y: degrees from 105° E, 35° N. */
function shiftOf(x: number, y: number): { north: number; east: number } {
  const both = wave(20, 6 * x, 20, 2 * x), root = Math.sqrt(Math.abs(x));
  return {
    north: -100 + 2 * x + 3 * y + 0.2 * y * y + 0.1 * x * y + 0.2 * root + both + wave(20, y, 40, y / 3) + wave(160, y / 12, 320, y / 30),
    east: 300 + x + 2 * y + 0.1 * x * x + 0.1 * x * y + 0.1 * root + both + wave(20, x, 40, x / 3) + wave(150, x / 12, 300, x / 30),
  };
}

export function gcj02Of(place: Place): Place {
  if (!isShifted(place)) return place;
  const { north, east } = shiftOf(place.lng - 105, place.lat - 35);
  const latitude = (place.lat * Math.PI) / 180;
  const bulge = 1 - eccentricity * Math.sin(latitude) ** 2;
  const metresOfLat = ((axis * (1 - eccentricity)) / bulge ** 1.5) * (Math.PI / 180);
  const metresOfLng = (axis / Math.sqrt(bulge)) * Math.cos(latitude) * (Math.PI / 180);
  return { lng: place.lng + east / metresOfLng, lat: place.lat + north / metresOfLat };
}

/** The position of a WGS 84 `place` on a map with `datum`. */
export const onMap = (place: Place, datum: Datum): Place => (datum === "gcj02" ? gcj02Of(place) : place);
