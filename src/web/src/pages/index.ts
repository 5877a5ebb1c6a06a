// All pages, in the order of the navigation.
import type { FunctionComponent } from "preact";
import type { Key } from "../i18n";
import { pageOfDevice, type Place } from "../route";
import { Alarms } from "./alarms";
import { Calibration } from "./calibration";
import { Charts } from "./charts";
import { Commands } from "./commands";
import { Firmware } from "./firmware";
import { Frames } from "./frames";
import { Images } from "./images";
import { Log } from "./log";
import { Overview } from "./overview";
import { Parameters } from "./parameters";
import { Recordings } from "./recordings";
import { Vehicle } from "./vehicle";
import { Waypoints } from "./waypoints";

export interface Page {
  name: string;
  title: Key;
  ofDevice: boolean;
  asks?: true; // sends requests to the device, so not available for devices of a recording
  view: FunctionComponent<{ device: number }>;
}

export const pages: Page[] = [
  { name: "overview", title: "overview", ofDevice: false, view: Overview },
  { name: "frames", title: "frames", ofDevice: false, view: Frames },
  { name: "charts", title: "charts", ofDevice: false, view: Charts },
  { name: "log", title: "log", ofDevice: false, view: Log },
  { name: "images", title: "images", ofDevice: false, view: Images },
  { name: "recordings", title: "recordings", ofDevice: false, view: Recordings },
  { name: pageOfDevice, title: "vehicle", ofDevice: true, view: Vehicle },
  { name: "alarms", title: "alarms", ofDevice: true, asks: true, view: Alarms },
  { name: "parameters", title: "parameters", ofDevice: true, asks: true, view: Parameters },
  { name: "commands", title: "commands", ofDevice: true, asks: true, view: Commands },
  { name: "waypoints", title: "waypoints", ofDevice: true, asks: true, view: Waypoints },
  { name: "calibration", title: "calibration", ofDevice: true, asks: true, view: Calibration },
  { name: "firmware", title: "firmware", ofDevice: true, asks: true, view: Firmware },
];

export const pageAt = (place: Place): Page =>
  pages.find((page) => page.name === place.page && page.ofDevice === (place.device !== undefined)) ?? pages[0]!;
