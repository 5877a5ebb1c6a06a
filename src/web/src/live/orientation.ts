// The orientation of a device, from its quaternion (0x04), else from its Euler angles (0x03); by the same rule as for ROS 2 (src/ros/README.md).
import type { Latest, Seen } from "./latest";

export interface Orientation {
  roll: Seen | undefined;
  pitch: Seen | undefined;
  yaw: Seen | undefined;
  late: boolean;
}

const degrees = 180 / Math.PI;

/** `lx`: pitch and yaw of the Euler angles have the opposite sign. */
export function orientationOf(latest: Latest, now: number, lx: boolean): Orientation {
  return latest.isLate("quaternion", now) ? byEuler(latest, now, lx) : byQuaternion(latest, now) ?? byEuler(latest, now, lx);
}

function byEuler(latest: Latest, now: number, lx: boolean): Orientation {
  const seen = (name: string, sign: number): Seen | undefined => {
    const angle = latest.number("euler", name, now);
    return angle && { ...angle, value: sign * angle.value };
  };
  const sign = lx ? -1 : 1;
  return { roll: seen("rol", 1), pitch: seen("pit", sign), yaw: seen("yaw", sign), late: latest.isLate("euler", now) };
}

/** undefined: not a quaternion, because its length is not near 1. */
function byQuaternion(latest: Latest, now: number): Orientation | undefined {
  const parts = ["v0", "v1", "v2", "v3"].map((name) => latest.number("quaternion", name, now)?.value ?? 0);
  const length = Math.hypot(...parts);
  if (length < 0.9 || length > 1.1) return undefined;
  const [w, x, y, z] = parts.map((part) => part / length) as [number, number, number, number];
  const seen = (radians: number): Seen => ({ value: radians * degrees, unit: "°", late: false });
  return {
    roll: seen(Math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))),
    pitch: seen(Math.asin(Math.max(-1, Math.min(1, 2 * (w * y - z * x))))),
    yaw: seen(Math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))),
    late: false,
  };
}
