// Calibration of accelerometer and compass: instructions and progress.
import { useState } from "preact/hooks";
import { significant } from "../format";
import { messageText, t, useLanguage } from "../i18n";
import { path } from "../live/device";
import { mayAct } from "../live/gateway";
import { cancel, goOn } from "../live/jobs";
import { useRunning } from "../live/running";
import { DeviceHeading } from "../parts/device_text";
import { JobFault, OutcomeLine, useAction } from "../parts/action";
import { boxFaces, faceNames, sphereCells, viewFrom, type FaceName } from "../parts/solid";

interface FacesStep {
  face: FaceName | null;
  still: number;
  faces: Record<string, number>;
  done: string[];
}
interface SphereStep {
  bands: number;
  sectors: number;
  coverage: number[];
  filled: number;
}

const pointsText = (points: [number, number][]): string => points.map(([x, y]) => `${x.toFixed(3)},${y.toFixed(3)}`).join(" ");

function Box({ step }: { step: FacesStep }) {
  const up = faceNames.find((name) => name === step.face);
  const next = faceNames.find((name) => !step.done.includes(name));
  const shown = up ?? next ?? "+z";
  return (
    <div class="turning">
      <svg class="solid" viewBox="-1.5 -1.35 3 2.7" role="img" aria-label={up ? t("face_up", { face: up }) : t("face_unknown")}>
        {boxFaces(shown, viewFrom(25, 30)).map((face) => (
          <g key={face.name} class={step.done.includes(face.name) ? "done" : face.name === up ? "now" : ""}>
            <polygon points={pointsText(face.points)} />
            <text x={face.middle[0]} y={face.middle[1] + 0.07}>{face.name}</text>
          </g>
        ))}
      </svg>
      <ul class="faces">
        {faceNames.map((name) => (
          <li key={name} class={step.done.includes(name) ? "good" : name === up ? "now" : ""}>
            <span>{step.done.includes(name) ? "✓" : name === up ? "▸" : "·"} {t("face_up", { face: name })}</span>
            <progress max={1} value={step.faces[name] ?? 0} aria-label={name} />
          </li>
        ))}
      </ul>
      <p role="status">{up === undefined ? t("face_unknown") : step.done.includes(up) ? t("face_enough") : t("face_still", { percent: Math.round(step.still * 100) })}</p>
    </div>
  );
}

function Sphere({ step }: { step: SphereStep }) {
  const half = (azimuth: number, label: string) => (
    <svg class="solid" viewBox="-1.1 -1.1 2.2 2.2" role="img" aria-label={`${label}: ${Math.round(step.filled * 100)} %`}>
      <circle class="rim" r="1" />
      {sphereCells(step.bands, step.sectors, viewFrom(azimuth, 20)).map((cell) => (
        <polygon key={cell.index} class={step.coverage[cell.index] ? "filled" : ""} points={pointsText(cell.points)} />
      ))}
    </svg>
  );
  return (
    <div class="turning">
      <div class="halves">{half(0, t("front"))}{half(180, t("back"))}</div>
      <p role="status"><progress max={1} value={step.filled} aria-label={t("sphere_filled")} /> {t("sphere_filled")} {Math.round(step.filled * 100)} %</p>
    </div>
  );
}

function Step({ step }: { step: unknown }) {
  if (typeof step !== "object" || step === null) return null;
  if ("faces" in step) return <Box step={step as FacesStep} />;
  if ("coverage" in step) return <Sphere step={step as SphereStep} />;
  return null;
}

const shown = (value: unknown): string => (typeof value === "number" ? significant(value, 5) : String(value));

const titles: Record<string, "residual_before" | "residual_after" | "residual_verified" | "error_matrix" | "restarts" | "values_written"> = {
  before: "residual_before", after: "residual_after", verified: "residual_verified", error_matrix: "error_matrix", restarts: "restarts", values: "values_written",
};

const titleOf = (name: string): string => {
  const title = titles[name];
  return title ? t(title) : name;
};

/** All figures from the gateway about the quality of the result. */
function Result({ value }: { value: unknown }) {
  const rows = typeof value === "object" && value !== null ? Object.entries(value) : [];
  return (
    <div class="card">
      <p class="good">✓ {t("calibrated")}</p>
      <table>
        <tbody>
          {rows.map(([name, one]) => (
            <tr key={name}><th scope="row">{titleOf(name)}</th><td>{name === "error_matrix" ? t("matrix_kept") : typeof one === "object" && one !== null ? Object.entries(one).map(([k, v]) => `${k} ${shown(v)}`).join(", ") : shown(one)}</td></tr>
          ))}
        </tbody>
      </table>
    </div>
  );
}

export function Calibration({ device }: { device: number }) {
  useLanguage();
  const { job, ended, start } = useRunning<unknown>(device, "calibration");
  const [what, setWhat] = useState<"accelerometer" | "compass">("accelerometer");
  const action = useAction();
  return (
    <div>
      <DeviceHeading title={t("calibration")} device={device} />
      <p class="muted">{t("calibration_about")}</p>
      {mayAct() && !job && (
        <div class="tools">
          <select aria-label={t("calibration")} value={what} onChange={(event) => setWhat(event.currentTarget.value as typeof what)}>
            <option value="accelerometer">{t("accelerometer")}</option>
            <option value="compass">{t("compass")}</option>
          </select>
          <button class="main" onClick={() => start(path(device, "calibration"), { body: { what } })}>{t("begin")}</button>
        </div>
      )}
      {job && (
        <section class="card">
          <p role="status"><b>{messageText(job.message)}</b></p>
          <Step step={job.step} />
          {mayAct() && (
            <div class="tools">
              {job.state === "waiting" && <button class="main" disabled={action.busy} onClick={() => action.run(() => goOn(job), () => t("goes_on"))}>{t("go_on")}</button>}
              <button disabled={action.busy} onClick={() => action.run(() => cancel(job), () => t("cancelled"))}>{t("cancel_restore")}</button>
              <OutcomeLine action={action} />
            </div>
          )}
        </section>
      )}
      {ended && (ended.ok ? <Result value={ended.value} /> : <JobFault refusal={ended.refusal} />)}
    </div>
  );
}
