// @ts-check
// Start of the page: language and theme first, so that nothing is drawn twice.

import { preferredLanguage, setLanguage } from "./i18n.js";
import { applyTheme } from "./theme.js";

applyTheme();
await setLanguage(preferredLanguage());
await import("../components/app-frame.js");
