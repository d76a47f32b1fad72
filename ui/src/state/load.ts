/** Getting what a screen shows, and going from one to another. The place is kept in the fragment of the address. */
import * as api from "../api/client";
import type { TrialHeader } from "../api/types";
import { mergePaths } from "../model/paths";
import { orderProblems } from "../model/problems";
import { get, OF_TRIAL, playhead, SCREENS, set, type Screen } from "./store";

/** Frames of detections that are fetched at a time, so many before the one that is looked at; chosen: 60 markers in 8
 * cameras are 1 MB. */
const AHEAD = 240, BEFORE = 60;

/** Do it; what is refused is said, and null is given. */
export async function tried<T>(work: () => Promise<T>): Promise<T | null> {
  set((s) => ({ busy: s.busy + 1 }));
  try {
    return await work();
  } catch (error) {
    say("refused", error instanceof Error ? error.message : String(error));
    return null;
  } finally {
    set((s) => ({ busy: s.busy - 1 }));
  }
}

export const say = (kind: "done" | "refused" | "news", words: string): void => set({ note: { kind, words, at: Date.now() } });

export function goTo(screen: Screen, id: string | null = get().id): void {
  const target = screen === "home" || !id ? "#/" : `#/trial/${encodeURIComponent(id)}/${screen}`;
  if (location.hash === target) void arrive();
  else location.hash = target;
}

/** Show what the address says. */
export async function arrive(): Promise<void> {
  const [, , id, name] = location.hash.split("/"), screen = SCREENS.find((one) => one === name) ?? "tracks";
  set({ dialog: null, note: null });
  if (!id) {
    set({ screen: "home" });
    const home = await tried(api.home);
    if (home) set({ home });
    return;
  }
  const trial = decodeURIComponent(id);
  if (get().id !== trial || !get().header) {
    set({ ...OF_TRIAL, id: trial, screen });
    await openTrial(trial);
  }
  set({ screen });
  await fresh();
}

async function openTrial(id: string): Promise<void> {
  const [header, paths] = (await tried(() => Promise.all([api.trial(id), api.paths(id, "edited")]))) ?? [];
  if (!header || !paths || get().id !== id) return;
  playhead.set(header.first_frame, header.n_frames, header.rate);
  set({ header, paths, savedAt: header.last?.at ?? null });
  await refreshProblems();
}

/** What the screen that is on shows besides the trial itself. */
export async function fresh(): Promise<void> {
  const { id, screen } = get();
  if (!id) return;
  if (screen === "gaps") {
    const gaps = await tried(() => api.gaps(id));
    if (gaps && get().id === id) set((s) => ({ gaps, gap: gaps.gaps.find((g) => g.marker === s.gap?.marker && g.first === s.gap.first) ?? null, limit: s.gaps ? s.limit : gaps.limit_mm }));
  } else if (screen === "labels") {
    const labels = await tried(() => api.labels(id));
    if (labels && get().id === id) set({ labels });
  } else if (screen === "history") {
    const history = await tried(() => api.history(id));
    if (history && get().id === id) set({ history });
  }
}

export async function refreshProblems(): Promise<void> {
  const id = get().id;
  const problems = id && (await tried(() => api.problems(id)));
  if (problems && get().id === id) set({ problems: { ...problems, problems: orderProblems(problems.problems) } });
}

/** The trial as it is now on the server, where the journal has gone on without this page. */
export async function refetch(): Promise<void> {
  const id = get().id;
  if (!id) return;
  const got = await tried(() => Promise.all([api.trial(id), api.paths(id, "edited")]));
  if (!got || get().id !== id) return;
  take(got[0]);
  set({ paths: got[1], detected: null, instead: null });
  await Promise.all([refreshProblems(), fresh()]);
}

/** The header after an act; the selection loses what is there no more. */
export function take(header: TrialHeader): void {
  const names = new Set(header.tracks.map((track) => track.name));
  set((s) => ({ header, savedAt: header.last?.at ?? s.savedAt, selected: s.selected.filter((name) => names.has(name)) }));
}

export async function fetchChanged(changed: readonly string[], removed: readonly string[]): Promise<void> {
  const { id, paths } = get();
  if (!id || !paths) return;
  if (!changed.length) return set({ paths: mergePaths(paths, { ...paths, byName: new Map() }, removed) });
  const some = await api.paths(id, "edited", changed);
  if (get().id === id) set((s) => ({ paths: mergePaths(s.paths ?? some, some, removed) }));
}

let asking: readonly [number, number] | null = null;

/** The detections about a frame; asked for once. */
export async function wantDetections(frame: number): Promise<void> {
  const { id, header } = get();
  if (!id || !header || (asking && frame >= asking[0] && frame <= asking[1])) return;
  const first = Math.max(header.first_frame, frame - BEFORE), last = Math.min(header.first_frame + header.n_frames - 1, first + AHEAD);
  asking = [first, last];
  try {
    const detected = await api.detections(id, first, last);
    if (get().id === id) set({ detected });
  } catch {
    // the frame is drawn without them, and they are asked for again with the next frame
  } finally {
    asking = null;
  }
}
