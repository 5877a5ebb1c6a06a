import { render } from "preact";
import { App } from "./app";
import { beginLanguage } from "./i18n";
import { beginEdits } from "./live/edits";
import { begin } from "./live/gateway";
import { beginLimits } from "./live/kept_limits";
import { beginSignIn } from "./live/sign_in";
import { beginWatch } from "./live/watch";
import { beginSound } from "./parts/sound";
import { beginRoute } from "./route";
import { beginTheme } from "./theme";

beginTheme();
beginLanguage();
void beginSignIn().then(() => {
  beginRoute();
  begin();
  beginLimits();
  beginWatch();
  beginEdits();
  beginSound();
  render(<App />, document.getElementById("app")!);
});
