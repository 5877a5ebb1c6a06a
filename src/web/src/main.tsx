import { render } from "preact";
import { App } from "./app";
import { beginLanguage } from "./i18n";
import { begin } from "./live/gateway";
import { beginRoute } from "./route";
import { beginTheme } from "./theme";

beginTheme();
beginLanguage();
beginRoute();
begin();
render(<App />, document.getElementById("app")!);
