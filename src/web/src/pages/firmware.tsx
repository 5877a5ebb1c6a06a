// Firmware upgrade: shows the file, the device, and each step until the device has checked the image.
import { useEffect, useState } from "preact/hooks";
import { called } from "../addresses";
import { shortNumber } from "../format";
import { t, useLanguage } from "../i18n";
import { forgetCommands, path } from "../live/device";
import { devices, mayAct, scan } from "../live/gateway";
import { cancel } from "../live/jobs";
import { useRunning } from "../live/running";
import { useStore } from "../live/store";
import { DeviceHeading } from "../parts/device_text";
import { JobFault, JobLine, OutcomeLine, useAction } from "../parts/action";
import { Confirm } from "../parts/confirm";
import { firmwareFile, type FirmwareFile } from "../parts/firmware_file";

const crcs = ["crc16/ibm-3740", "xmodem", "kermit", "modbus", "arc"];

interface Flashed {
  bytes: number;
  frames: number;
  repeats: number;
  seconds: number;
}

export function Firmware({ device }: { device: number }) {
  useLanguage();
  const known = useStore(devices).find((one) => Number(one.address) === device);
  const { job, ended, start } = useRunning<Flashed>(device, "firmware");
  const [file, setFile] = useState<{ file: File; about: FirmwareFile }>();
  const [crc, setCrc] = useState(crcs[0]!);
  const [force, setForce] = useState(false);
  const action = useAction();
  const [isAskedAnew, setAskedAnew] = useState(false); // new firmware has another version: the old one is hidden until the scan ends
  useEffect(() => {
    if (!ended?.ok) return;
    setFile(undefined);
    forgetCommands(device);
    setAskedAnew(true);
    void scan().then(() => setAskedAnew(false));
  }, [ended, device]);
  const choose = async (chosen: File | undefined): Promise<void> => {
    if (chosen) setFile({ file: chosen, about: firmwareFile(await chosen.slice(0, 100).arrayBuffer(), chosen.size) });
  };
  const flash = (): void => {
    action.say(undefined);
    if (file) start(path(device, `firmware?crc=${encodeURIComponent(crc)}${force ? "&force" : ""}`), { body: file.file });
  };
  const header = file?.about.header;
  return (
    <div>
      <DeviceHeading title={t("firmware")} device={device} />
      {known?.hw !== undefined && !job && !isAskedAnew && <p>{t(ended?.ok ? "now_has" : "device_versions", { hw: known.hw, sw: known.sw ?? "–" })}</p>}
      {known?.in_loader && !job && !ended?.ok && <p class="note warn">{t("in_loader")}</p>}
      {mayAct() && !job && (
        <div class="card">
          <div class="tools">
            <label class="file">{t("choose_firmware")}<input type="file" accept=".bin,.bia" onChange={(event) => void choose(event.currentTarget.files?.[0])} /></label>
            {file && <span>{file.file.name}: {shortNumber(file.about.bytes)} {t("size")}{header ? `, ${t("bia_says", { version: header.version, type: header.hwType, min: header.hwMin, max: header.hwMax })}` : `, ${t("bin_says")}`}</span>}
          </div>
          <div class="tools">
            <label>CRC <select value={crc} onChange={(event) => setCrc(event.currentTarget.value)}>{crcs.map((one) => <option key={one} value={one}>{one}</option>)}</select></label>
            <label class="check"><input type="checkbox" checked={force} onChange={() => setForce(!force)} />{t("force_firmware")}</label>
          </div>
          {header && known?.hw !== undefined && header.hwMax > 0 && (known.hw < header.hwMin || known.hw > header.hwMax) && <p class="note warn">{t("bia_misfit", { hw: known.hw, min: header.hwMin, max: header.hwMax })}</p>}
          <Confirm label={t("flash")} question={t("flash_question", { file: file?.file.name ?? "", device: called(device) })} yes={t("flash")} kind="main" disabled={!file} onYes={flash} />
        </div>
      )}
      <JobLine job={job} {...(job && mayAct() ? { onCancel: () => action.run(() => cancel(job), () => t("cancelled")), question: t("cancel_firmware_question") } : {})} />
      <OutcomeLine action={action} />
      {ended && (ended.ok
        ? <p class="good" role="status">✓ {t("flashed", { bytes: ended.value.bytes, frames: ended.value.frames, repeats: ended.value.repeats, s: ended.value.seconds })}</p>
        : <JobFault refusal={ended.refusal} />)}
    </div>
  );
}
