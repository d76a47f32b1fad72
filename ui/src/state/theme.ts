/** Light or dark: what the person chose, else what the system has. */
import { keep, playhead, set, useStore, type Theme } from "./store";

const dark = (): MediaQueryList => matchMedia("(prefers-color-scheme: dark)");

/** Show all in a theme, which is not kept. */
export function showTheme(theme: Theme): void {
  document.documentElement.dataset.theme = theme === "auto" ? (dark().matches ? "dark" : "light") : theme;
  set((s) => ({ paths: s.paths && { ...s.paths }, problems: s.problems && { ...s.problems } })); // all that is drawn is drawn anew
  playhead.draw();
}

export function followTheme(): void {
  const asked = new URLSearchParams(location.search).get("theme");
  if (asked === "light" || asked === "dark") set({ theme: asked });
  const apply = (): void => showTheme(useStore.getState().theme);
  apply();
  dark().addEventListener("change", apply);
}

export function chooseTheme(theme: Theme): void {
  keep("theme", theme);
  set({ theme });
  showTheme(theme);
}
