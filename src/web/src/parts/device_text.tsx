// Texts from devices: isolated, so that they neither reorder nor hide the text beside them.
import type { ComponentChildren } from "preact";
import { called, nameOf } from "../addresses";
import { filledWith, type Key } from "../i18n";
import { hexByte } from "../protocol/table";
import { visible } from "../visible";

export const DeviceText = ({ text }: { text: string | undefined }) => <bdi>{visible(text ?? "")}</bdi>;

/** The name of a device, or its address if it has no name. */
export const DeviceName = ({ device }: { device: number }) => <bdi>{called(device)}</bdi>;

/** The heading of a device page. */
export const DeviceHeading = ({ title, device, name = nameOf(device) }: { title: string; device: number; name?: string | undefined }) => (
  <h1>{title} <small class="muted"><DeviceText text={name} /> {hexByte(device)}</small></h1>
);

/** t() with texts from devices as values, each isolated. */
export const tx = (key: Key, args: Record<string, unknown>): ComponentChildren => filledWith(key, args, (value) => <bdi>{visible(value)}</bdi>);
