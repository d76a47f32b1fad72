/** The screens, each with what it alone needs: loaded when it is gone to, and all of them while nothing else is done. */
import { known } from "../api/client";
import { keep, kept, type Screen } from "../state/store";

type View = () => React.JSX.Element;

const LOAD: Record<Screen, () => Promise<View>> = {
  home: async () => (await import("./Home")).Home,
  new: async () => (await import("./NewSession")).NewSession,
  cameras: async () => (await import("./Cameras")).Cameras,
  detect: async () => (await import("./Detect")).Detect,
  digitise: async () => (await import("./Digitise")).Digitise,
  tracks: async () => (await import("./Tracks")).Tracks,
  labels: async () => (await import("./Labels")).Labels,
  gaps: async () => (await import("./Gaps")).Gaps,
  angles: async () => (await import("./Angles")).Angles,
  report: async () => (await import("./Report")).Report,
  history: async () => (await import("./History")).History,
  um2as: async () => (await import("./Um2as")).Um2as,
};

const loaded = new Map<Screen, View>();

/** A screen that is here already. */
export const loadedScreen = (screen: Screen): View | undefined => loaded.get(screen);

export async function loadScreen(screen: Screen): Promise<View> {
  const view = loaded.get(screen) ?? (await LOAD[screen]());
  loaded.set(screen, view);
  if (kept<string>(LOST, "") === screen) keep(LOST, "");
  return view;
}

/** The screen for which the page was loaded again; ms between two looks whether the server is there, chosen. */
const LOST = "lost", LOOK_MS = 1000;

/** A part of the page that was lost on its way is never asked for again by a browser, unless it loads the whole page
 * again: that is done once, as soon as the server answers. What the address says is shown then, and all edits are saved. */
export async function loadAgain(screen: Screen): Promise<void> {
  if (kept<string>(LOST, "") === screen) return; // it is not for that
  while (!(await known())) await new Promise((done) => setTimeout(done, LOOK_MS));
  keep(LOST, screen);
  location.reload();
}

/** The others, the editor first, so that going to them waits for nothing; one that cannot be had now is asked for again when it is wanted. */
export async function loadTheOthers(): Promise<void> {
  for (const screen of ["tracks", ...Object.keys(LOAD)] as Screen[]) await loadScreen(screen).catch(() => null);
}
