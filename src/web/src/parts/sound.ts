// Sound and vibration of alarms. Browsers allow both only after the first user interaction with the page.
import { remember, remembered } from "../kept";
import { Store } from "../live/store";

export const soundOn = new Store(remembered("sound") !== "off");

export function setSound(on: boolean): void {
  remember("sound", on ? "on" : "off");
  soundOn.set(on);
}

let context: AudioContext | undefined;

function unlock(): void {
  try {
    context ??= new AudioContext();
    void context.resume();
  } catch {
    // no sound in this browser
  }
}

export function beginSound(): void {
  for (const event of ["pointerdown", "keydown"]) addEventListener(event, unlock, { passive: true });
}

const tones = { red: [880, 660, 880, 660], amber: [660, 660] };

export function alarmSound(level: "amber" | "red"): void {
  if (!soundOn.get()) return;
  if (navigator.userActivation?.hasBeenActive) navigator.vibrate?.(level === "red" ? [300, 100, 300, 100, 300] : [200, 100, 200]);
  if (context?.state !== "running") return;
  tones[level].forEach((tone, i) => {
    const from = context!.currentTime + i * 0.22, voice = context!.createOscillator(), loud = context!.createGain();
    voice.frequency.value = tone;
    loud.gain.setValueAtTime(0.25, from);
    loud.gain.exponentialRampToValueAtTime(0.001, from + 0.2);
    voice.connect(loud).connect(context!.destination);
    voice.start(from);
    voice.stop(from + 0.21);
  });
}
