/** Light or dark: what the person chose, else what the system has. */
import { keep, playhead, set, useStore, type Theme } from "./store";

const dark = matchMedia("(prefers-color-scheme: dark)");

function apply(): void {
  const theme = useStore.getState().theme;
  document.documentElement.dataset.theme = theme === "auto" ? (dark.matches ? "dark" : "light") : theme;
  set((s) => ({ paths: s.paths && { ...s.paths }, problems: s.problems && { ...s.problems } })); // all that is drawn is drawn anew
  playhead.draw();
}

export function followTheme(): void {
  const asked = new URLSearchParams(location.search).get("theme");
  if (asked === "light" || asked === "dark") set({ theme: asked });
  apply();
  dark.addEventListener("change", apply);
}

export function chooseTheme(theme: Theme): void {
  keep("theme", theme);
  set({ theme });
  apply();
}
