/** What the page knows and what the person looks at. Not the frame: that is the playhead's. */
import { useMemo } from "react";
import { create } from "zustand";
import { useShallow } from "zustand/react/shallow";
import type { Click } from "../draw/Cameras";
import type { GapOrder } from "../model/gaps";
import type { Detected } from "../model/detections";
import type { Span } from "../model/lanes";
import { ofWhole } from "../model/problems";
import { shownPaths, type Path, type PathSet } from "../model/paths";
import { Playhead } from "../model/playhead";
import type { Tried } from "./detect";
import type { Digitised } from "./digitise";
import type { GapCandidates, GapRow, Gaps, History, Home, Job, Join, Labels, Problem, Problems, TrialHeader } from "../api/types";

export const SCREENS = ["home", "new", "cameras", "detect", "digitise", "tracks", "labels", "gaps", "angles", "report", "history", "um2as"] as const;
export type Screen = (typeof SCREENS)[number];
/** Screens by their names on the page and in the manual. */
export const TITLES: Record<Screen, string> = {
  home: "Home", new: "New session", cameras: "Cameras", detect: "Detect", digitise: "Digitise", tracks: "Tracks", labels: "Labels", gaps: "Gaps", angles: "Angles", report: "Report", history: "History", um2as: "UM²AS",
};
export type Dialog = "help" | "commands" | "name" | "why" | "finish" | "sign" | "event" | "smooth" | null;
export type Theme = "auto" | "light" | "dark";
export type Layout = 1 | 2 | 3 | 4;

/** What a proposal would give, drawn beside what is. */
export interface Instead { problem: string; key: string; paths: readonly Path[]; words: string; straight: boolean }
export interface Note { kind: "done" | "refused" | "news"; words: string; at: number }

export interface State {
  screen: Screen;
  home: Home | null;
  id: string | null;
  header: TrialHeader | null;
  paths: PathSet | null;
  detected: Detected | null;
  problems: Problems | null;
  gaps: Gaps | null;
  labels: Labels | null;
  history: History | null;
  detect: Tried | null;
  digitise: Digitised | null;
  jobs: Readonly<Record<string, Job>>;
  connected: boolean;
  /** Whether the server that is there now is another one, which does not let this window in. */
  stranger: boolean;
  busy: number;
  /** How often the server was there again after it was not. */
  returns: number;
  note: Note | null;
  /** Why the screen cannot be shown. */
  unshown: string;
  /** Whether the trial can be run, as a file of trajectories cannot; not yet known while it is opened. */
  runs: boolean;
  savedAt: string | null;

  problem: string | null;
  /** Whether problems that are not worth a look are shown too. */
  unlikely: boolean;
  later: readonly string[];
  instead: Instead | null;
  selected: readonly string[];
  first: number | null;
  last: number | null;
  join: { track: string; name: string; join: Join } | null;
  clicks: readonly Click[] | null;
  gap: GapRow | null;
  candidates: GapCandidates | null;
  method: string | null;
  /** Whether a person chose the method; else it is the best that is known. */
  picked: boolean;
  track: string | null;
  /** The trial of Home, or the folder of New session, that Enter opens. */
  marked: string | null;
  limit: number;
  gapOrder: GapOrder | null;
  why: string;

  dialog: Dialog;
  layout: Layout;
  theme: Theme;
  letters: boolean;
  lines: boolean;
  images: boolean;
  follow: boolean;
  alone: boolean;
  /** Whether points of a file that are no markers are shown. */
  computed: boolean;
  bands: boolean;
  fourth: "speed" | "residual";
  side: number;
  focused: number;
  /** Frames that the curves show, and those that the lanes do; null: all. */
  window: Span;
  span: Span;
}

export function kept<T extends string>(key: string, usual: T): T {
  try {
    return (localStorage.getItem(`kinemark.${key}`) as T | null) ?? usual;
  } catch {
    return usual; // storage may be forbidden
  }
}

export function keep(key: string, value: string): void {
  try {
    localStorage.setItem(`kinemark.${key}`, value);
  } catch {
    // then it is asked for again next time
  }
}

/** What is of one trial, and forgotten with it. */
export const OF_TRIAL = {
  header: null, paths: null, detected: null, problems: null, gaps: null, labels: null, history: null, savedAt: null, problem: null, unlikely: false, later: [],
  instead: null, selected: [], first: null, last: null, join: null, clicks: null, gap: null, candidates: null, method: null, picked: false, track: null, why: "",
  alone: false, computed: false, window: null, span: null, detect: null, digitise: null,
} satisfies Partial<State>;

export const useStore = create<State>()(() => ({
  ...OF_TRIAL,
  screen: "home", home: null, id: null, jobs: {}, connected: true, stranger: false, busy: 0, returns: 0, note: null, unshown: "", runs: true, limit: 5, gapOrder: null,
  dialog: null, marked: null, layout: Number(kept("layout", "1")) as Layout, theme: kept<Theme>("theme", "auto"), letters: kept("letters", "on") === "on",
  lines: true, images: true, follow: false, bands: true, fourth: "speed", side: 0, focused: 0,
}));

/** The state but for what only says that something is being worked on, at which nothing else is drawn anew. */
export const useSeen = (): State => useStore(useShallow((s) => ({ ...s, busy: 0, savedAt: null })));

/** Some parts of the state, so that others draw nothing anew. */
export const useParts = <K extends keyof State>(...names: readonly K[]): Pick<State, K> =>
  useStore(useShallow((s) => Object.fromEntries(names.map((name) => [name, s[name]])) as Pick<State, K>));

/** The paths as views show them. */
export function useShownPaths(): PathSet | null {
  const { header, paths, computed } = useParts("header", "paths", "computed");
  return useMemo(() => shownPaths(header, paths, computed), [header, paths, computed]);
}

export const playhead = new Playhead();
export const get = useStore.getState;
export const set = useStore.setState;

/** Whether nothing may move by itself: asked for by the system, or for pictures. */
export const still = (): boolean =>
  new URLSearchParams(location.search).has("still") || matchMedia("(prefers-reduced-motion: reduce)").matches;

/** Whether it runs or is calibrated now; what is begun twice is refused. */
export const running = (s: State, id: string | null): boolean => id !== null && s.jobs[id]?.state === "running";
/** Whether what is looked at is a file of trajectories, without images and recordings. */
export const ofFile = (s: State): boolean => (s.header ? s.header.session_id === null : !s.runs);
/** What views show: what is selected, else all that a problem of all markers is about. */
export const watched = (s: State): readonly string[] => {
  const p = s.selected.length ? null : currentProblem(s);
  return p && ofWhole(p) ? p.tracks : s.selected;
};
export const currentProblem = (s: State): Problem | null => (s.screen === "tracks" && s.problems?.problems.find((p) => p.id === s.problem)) || null;
