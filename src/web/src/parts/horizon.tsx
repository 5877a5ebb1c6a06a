// Attitude indicator. Angles in degrees, X forward, Y left, Z up: positive roll is to the right, positive pitch nose down, positive yaw to the left.
import { t } from "../i18n";

const perDegree = 1.6; // drawing units per degree

function Ladder() {
  const rungs = [-60, -50, -40, -30, -20, -10, 10, 20, 30, 40, 50, 60];
  return (
    <g class="ladder">
      {rungs.map((degrees) => (
        <g key={degrees}>
          <line x1={degrees % 20 === 0 ? -22 : -12} x2={degrees % 20 === 0 ? 22 : 12} y1={-degrees * perDegree} y2={-degrees * perDegree} />
          {degrees % 20 === 0 && <text x="27" y={-degrees * perDegree + 3}>{Math.abs(degrees)}</text>}
        </g>
      ))}
    </g>
  );
}

export function Horizon({ roll, pitch, yaw, late }: { roll: number; pitch: number; yaw: number; late: boolean }) {
  const label = `${t("attitude")}: ${t("roll")} ${roll.toFixed(0)}°, ${t("pitch")} ${pitch.toFixed(0)}°, ${t("yaw")} ${yaw.toFixed(0)}°`;
  const shift = Math.max(-60, Math.min(60, -pitch)) * perDegree;
  return (
    <svg class={`horizon ${late ? "late-drawing" : ""}`} viewBox="-110 -110 220 220" role="img" aria-label={label}>
      <clipPath id="disc"><circle r="88" /></clipPath>
      <g clip-path="url(#disc)">
        <g transform={`rotate(${(-roll).toFixed(2)}) translate(0 ${shift.toFixed(2)})`}>
          <rect class="sky" x="-300" y="-300" width="600" height="300" />
          <rect class="earth" x="-300" y="0" width="600" height="300" />
          <line class="edge" x1="-300" x2="300" y1="0" y2="0" />
          <Ladder />
        </g>
      </g>
      <circle class="rim" r="88" />
      <g class="scale">
        {[-60, -45, -30, -20, -10, 0, 10, 20, 30, 45, 60].map((degrees) => (
          <line key={degrees} x1="0" x2="0" y1="-88" y2={degrees % 30 === 0 ? -78 : -82} transform={`rotate(${degrees})`} />
        ))}
      </g>
      <path class="pointer" d="M0 -88 L5 -98 L-5 -98 Z" transform={`rotate(${(-roll).toFixed(2)})`} />
      <path class="self" d="M-48 0 H-18 L-9 8 M48 0 H18 L9 8 M-2 0 H2" />
    </svg>
  );
}

/** The heading, seen from above; yaw 0 is up. */
export function Rose({ yaw, late }: { yaw: number; late: boolean }) {
  return (
    <svg class={`rose ${late ? "late-drawing" : ""}`} viewBox="-50 -50 100 100" aria-hidden="true">
      <circle class="rim" r="44" />
      {Array.from({ length: 12 }, (_, i) => <line key={i} class="tick" x1="0" x2="0" y1="-44" y2={i % 3 === 0 ? -35 : -39} transform={`rotate(${i * 30})`} />)}
      <path class="needle" d="M0 -32 L11 22 L0 14 L-11 22 Z" transform={`rotate(${(-yaw).toFixed(1)})`} />
    </svg>
  );
}
