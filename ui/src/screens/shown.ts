/** The screens, each with what it alone needs: loaded when it is gone to, and all of them while nothing else is done. */
import type { Screen } from "../state/store";

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
  return view;
}

/** The others, the editor first, so that going to them waits for nothing; one that cannot be had now is asked for again when it is wanted. */
export async function loadTheOthers(): Promise<void> {
  for (const screen of ["tracks", ...Object.keys(LOAD)] as Screen[]) await loadScreen(screen).catch(() => null);
}
