// Pictures from devices: 0xB0.
import { useEffect, useRef, useState } from "preact/hooks";
import { called } from "../addresses";
import { rateText } from "../format";
import { t, useLanguage } from "../i18n";
import { frameStream } from "../live/frames";
import { seconds, table } from "../live/gateway";
import { Pictures, pixelsOf, rowBytes, type Picture } from "../live/pictures";
import { Rate } from "../live/rate";
import { useStore, useTick } from "../live/store";
import { DeviceName } from "../parts/device_text";
import { download, stamp } from "../parts/download";
import { LostFrames } from "../parts/lost_frames";
import { hexByte, Reading } from "../protocol/table";

interface Shown {
  picture: Picture;
  rate: Rate;
  broken: number; // number of pictures with missing rows
}

function Canvas({ picture, stopped }: { picture: Picture; stopped: boolean }) {
  const canvas = useRef<HTMLCanvasElement>(null);
  const drawn = useRef<Picture | undefined>(undefined);
  useEffect(() => {
    const element = canvas.current;
    if (!element || (stopped && drawn.current) || drawn.current === picture) return;
    drawn.current = picture;
    element.width = picture.width;
    element.height = picture.height;
    element.getContext("2d")?.putImageData(new ImageData(pixelsOf(picture), picture.width, picture.height), 0, 0);
  });
  const save = (): void => canvas.current?.toBlob((blob) => blob && download(`image_${hexByte(picture.from)}_${stamp()}.png`, blob));
  return (
    <>
      <canvas ref={canvas} class="picture" role="img" aria-label={t("image_of", { name: called(picture.from) })} />
      <button onClick={save}>PNG</button>
    </>
  );
}

export function Images() {
  useLanguage();
  const of = useStore(table);
  const [stopped, setStopped] = useState(false);
  const shown = useRef(new Map<number, Shown>());
  const pictures = useRef(new Pictures());
  const heard = useRef(new Set<number>());
  useTick(66);
  useEffect(() => {
    const id = of?.idOf("image");
    if (!of || id === undefined) return undefined;
    return frameStream.use({
      wish: { id: [id] },
      take: (record) => {
        const reading = of.read(record.id, record.from, record.data);
        if (!(reading instanceof Reading)) return;
        for (const picture of pictures.current.take(reading, record.from, record.time)) {
          const whole = picture.filled === rowBytes(picture) * picture.height;
          const isFirst = !heard.current.has(record.from);
          heard.current.add(record.from);
          if (isFirst && !whole) continue; // reception may have begun in the middle of this picture
          const one = shown.current.get(record.from) ?? { picture, rate: new Rate(), broken: 0 };
          one.picture = picture;
          one.rate.add(seconds());
          if (!whole) ++one.broken;
          shown.current.set(record.from, one);
        }
      },
    });
  }, [of]);
  const all = [...shown.current.entries()].sort((a, b) => a[0] - b[0]);
  const now = seconds();
  return (
    <div>
      <h1>{t("images")}</h1>
      <div class="tools"><button aria-pressed={stopped} onClick={() => setStopped(!stopped)}>{stopped ? t("go_on") : t("pause")}</button></div>
      <LostFrames />
      {all.length === 0 && <p class="muted">{t("no_images")}</p>}
      <div class="images">
        {all.map(([from, one]) => (
          <figure key={from} class={`card ${one.rate.isLate(now) ? "late" : ""}`}>
            <Canvas picture={one.picture} stopped={stopped} />
            <figcaption><DeviceName device={from} /> · {one.picture.width} × {one.picture.height} px · {one.rate.isLate(now) ? "–" : rateText(one.rate.perSecond(now))} {t("per_second")}{one.broken > 0 && <span class="warn"> · {t("images_broken", { n: one.broken })}</span>}</figcaption>
          </figure>
        ))}
      </div>
    </div>
  );
}
