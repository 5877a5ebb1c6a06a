// The track of a vehicle from above, on a metric grid (up is x, forward at take-off), or on a map if the gateway has one.
import { useEffect, useRef, useState } from "preact/hooks";
import { faultText, t } from "../i18n";
import { remember, remembered } from "../kept";
import { status } from "../live/gateway";
import { useStore } from "../live/store";
import { mapFault, mapNews, mapTiles } from "../map/tiles";
import { drawGround, scaleFor, type Scene } from "./ground";
import { clearTracks } from "./tracks";

/** `onMap`: the scene by satellite position, if known. `way`: connects the marks in order. */
export function Track({ device, scene, onMap, yaw, way = false }: { device: number; scene: Scene; onMap: Scene | undefined; yaw: number; way?: boolean }) {
  const canvas = useRef<HTMLCanvasElement>(null);
  const [chosen, setScale] = useState<number>(); // metres per pixel
  const [wanted, setWanted] = useState(remembered("map") !== "off");
  const map = useStore(status)?.map;
  const fault = useStore(mapFault);
  useStore(mapNews);
  const shown = map && wanted && onMap ? onMap : scene;
  const scale = chosen ?? (way ? scaleFor(shown.marks) : shown === scene ? 0.05 : 0.3);
  const current = useRef(scale);
  current.current = scale;
  const zoom = (factor: number): void => setScale(Math.min(Math.max(current.current * factor, 0.002), 100));
  useEffect(() => {
    if (canvas.current) drawGround(canvas.current, shown, yaw, scale, way, shown === onMap ? map?.datum : undefined);
  });
  useEffect(() => {
    const element = canvas.current;
    const wheel = (event: WheelEvent): void => {
      event.preventDefault();
      zoom(event.deltaY > 0 ? 1.25 : 0.8);
    };
    element?.addEventListener("wheel", wheel, { passive: false });
    return () => element?.removeEventListener("wheel", wheel);
  }, []);
  const turn = (): void => {
    remember("map", wanted ? "off" : "on");
    setWanted(!wanted);
  };
  const { now } = shown;
  const where = now ? `x ${now.x.toFixed(1)} m, y ${now.y.toFixed(1)} m` : t("no_data");
  return (
    <div class="track">
      <canvas ref={canvas} role="img" aria-label={`${t(shown === scene ? "track" : "track_on_map")}: ${where}`} />
      <div class="zoom">
        <button aria-label={t("zoom_in")} onClick={() => zoom(0.67)}>+</button>
        <button aria-label={t("zoom_out")} onClick={() => zoom(1.5)}>−</button>
        <button aria-label={t("clear_track")} title={t("clear_track")} onClick={() => clearTracks(device)}>⌫</button>
        {map && <button class="to-map" aria-pressed={wanted} onClick={turn}>{t("map")}</button>}
      </div>
      {map && wanted && !onMap && <p class="about-map">{t("map_needs_place")}</p>}
      {map && wanted && onMap && fault && <p class="about-map warn" role="status">{t("no_map", { why: typeof fault.why === "string" ? t(fault.why, fault.args) : faultText(fault.why) })}</p>}
      {shown !== scene && !fault && mapTiles.attribution && <p class="about-map muted">{mapTiles.attribution}</p>}
    </div>
  );
}
