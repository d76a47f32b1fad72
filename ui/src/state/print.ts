/** Printing what is shown: light in either theme, as it stands on the screen where that is drawn, else as a page of text. */
import * as api from "../api/client";
import { get, set, type Theme } from "./store";
import { showTheme } from "./theme";

/** px of A4 across, at 96 a inch, within margins of 10 mm. */
const PAPER = { width: 1047, height: 718 };
/** ms until drawings have followed the theme; chosen. */
const DRAWN_MS = 150;

/** Print the page that is shown; of a report, its own page. */
export function print(): void {
  const { screen, id, theme, header } = get();
  if (screen === "report" && id && header?.session_id != null) return void window.open(api.reportAddress(id), "_blank", "noreferrer");
  paint("light");
  setTimeout(() => {
    window.print();
    paint(theme);
  }, DRAWN_MS);
}

/** For the time of printing; what the person chose is kept elsewhere. */
function paint(theme: Theme): void {
  set({ theme });
  showTheme(theme);
}

/** Before it is printed, what is drawn keeps the size that it has on the screen, and is made smaller as a whole. */
export function fitPaper(): void {
  const main = document.getElementById("main")!, { width, height } = main.getBoundingClientRect(), style = document.documentElement.style;
  style.setProperty("--shown-width", `${width}px`);
  style.setProperty("--shown-height", `${height}px`);
  style.setProperty("--shown-zoom", String(Math.min(PAPER.width / width, PAPER.height / height, 1)));
}
