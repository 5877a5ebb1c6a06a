// A note that the stream of the current view has lost frames.
import { t } from "../i18n";
import { frameStream } from "../live/frames";

export const LostFrames = () => (frameStream.lostFrames > 0 ? <p class="note warn" role="status">{t("lost_on_the_way", { n: frameStream.lostFrames })}</p> : null);
