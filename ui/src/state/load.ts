/** Getting what a screen shows, and going from one to another. The place is kept in the fragment of the address. */
import * as api from "../api/client";
import type { Act, ActDone, Gaps, TrialHeader } from "../api/types";
import { changedPaths, mergePaths } from "../model/paths";
import { answered, unanswered } from "./again";
import { asking } from "./newest";
import { loadDetect } from "./detect";
import { loadDigitise } from "./digitise";
import { arriveAtSession, cameraAddress, fetchAngles, sessionOf } from "./sessions";
import { arriveAtMenu, held, menuAddress } from "./um2as";
import { marked } from "../model/finish";
import { get, OF_TRIAL, playhead, SCREENS, set, type Screen } from "./store";

/** With chosen fills, so that what is drawn is what a run would write. */
const VIEW = "filled";
/** Screens that show images, of trials that were not run yet too. */
const BEFORE_RUN: readonly Screen[] = ["detect", "digitise"];
/** ms after which what was still being computed is asked for again; chosen. */
const AGAIN_MS = 400;
/** ms in which a page is drawn that is seen at all; chosen. */
const DRAWN_MS = 200;
/** Frames of detections that are fetched at a time, so many before the one that is looked at; chosen: 60 markers in 8
 * cameras are 1 MB. */
const AHEAD = 240, BEFORE = 60;

/** Do it; what is refused is said, and null is given. */
export async function tried<T>(work: () => Promise<T>): Promise<T | null> {
  set((s) => ({ busy: s.busy + 1 }));
  try {
    const got = await work();
    answered();
    return got;
  } catch (error) {
    say("refused", error instanceof Error ? error.message : String(error));
    unanswered(error, again);
    return null;
  } finally {
    set((s) => ({ busy: s.busy - 1 }));
  }
}

let standings = 0;

/** Whether a screen of a trial can be shown; why it cannot stands where it would be, for the screen that was asked about last. */
export async function ready(id: string, screen: "trial" | "detect" | "digitise"): Promise<boolean> {
  const standing = ++standings, stands = await tried(() => api.standing(id, screen));
  if (stands && standing === standings && get().id === id) set({ unshown: stands.ready ? "" : (stands.words ?? ""), runs: stands.runs !== false });
  return stands?.ready === true;
}

export const say = (kind: "done" | "refused" | "news", words: string): void => set({ note: { kind, words, at: Date.now() } });

export function goTo(screen: Screen, id: string | null = get().id): void {
  if (screen === "cameras" && sessionOf()) return void (location.hash = cameraAddress(sessionOf()!));
  if (screen === "home" && held()) return say("news", "UM²AS is left from the top of its menu: Escape goes one level up.");
  if (screen === "um2as" && sessionOf()) return void (location.hash = menuAddress(sessionOf()!));
  const target = screen === "new" ? "#/new" : screen === "home" || !id ? "#/" : `#/trial/${encodeURIComponent(id)}/${screen}`;
  if (location.hash === target) void arrive();
  else location.hash = target;
}

/** A gap that is looked at marks its frames on Gaps alone: elsewhere what is said of marked frames would be of those. */
export function leaveGap(): void {
  const { first, last, gap } = get();
  if (gap) set({ gap: null, candidates: null, ...(marked(first, last, gap)[0] === null ? { first: null, last: null } : {}) });
}

/** Show what the address says. */
export async function arrive(): Promise<void> {
  const here = location.hash, [, , id, name] = here.split("/"), screen = SCREENS.find((one) => one === name) ?? "tracks";
  set({ dialog: null, note: null, unshown: "" });
  if (await arriveAtMenu(here.split("/"))) return;
  if (await arriveAtSession(location.hash.split("/")[1], id)) return;
  if (!id) {
    set({ screen: "home" });
    return fetchHome();
  }
  const trial = decodeURIComponent(id);
  if (screen !== "gaps") leaveGap();
  if (get().id !== trial || (!get().header && !BEFORE_RUN.includes(screen))) {
    set({ ...OF_TRIAL, id: trial, screen });
    if (!BEFORE_RUN.includes(screen)) await openTrial(trial);
    if (location.hash !== here) return; // somebody went on while it was opened
  }
  set({ screen });
  if (!get().header && !get().home) void fetchHome(); // which tells whose session a trial is that was not run
  await fresh();
}

export async function fetchHome(): Promise<void> {
  const last = asking("home"), home = await tried(api.home);
  if (home && last()) set({ home });
}

/** The report as a PDF, which the browser then keeps. */
export async function writePdf(): Promise<void> {
  const { id, header } = get();
  say("news", "The PDF is being made …");
  const file = id && (await tried(() => api.reportPdf(id)));
  if (!file) return;
  const link = Object.assign(document.createElement("a"), { href: URL.createObjectURL(file), download: `${header?.name ?? "report"}.pdf` });
  link.click();
  URL.revokeObjectURL(link.href);
  say("done", `${link.download} is among the downloads.`);
}

/** Run the trial that is looked at; how it goes on is told by itself. */
export async function runTrial(): Promise<void> {
  const { id } = get();
  if (id && (await tried(() => api.run(id)))) say("news", "The trial is being run.");
}

async function openTrial(id: string): Promise<void> {
  const last = asking("trial");
  if (!(await ready(id, "trial"))) return;
  const [header, paths] = (await tried(() => Promise.all([api.trial(id), api.paths(id, VIEW)]))) ?? [];
  if (!header || !paths || get().id !== id || (!last() && get().paths)) return; // what was asked for since may fail
  playhead.set(header.first_frame, header.n_frames, header.rate);
  heads.add(header.head);
  set({ header, paths, savedAt: header.last?.at ?? null });
  if (paths.pending) askAgain(id, [...paths.byName.keys()]);
  await refreshProblems();
}

/** What the screen that is on shows besides the trial itself. */
export async function fresh(): Promise<void> {
  const { id, screen, header } = get();
  if (!id || (!header && !BEFORE_RUN.includes(screen))) return; // it cannot be shown, and why was said
  if (screen === "angles") return fetchAngles();
  const last = asking(screen), mine = (): boolean => get().id === id && last();
  if (screen === "detect") await loadDetect(id);
  else if (screen === "digitise") await loadDigitise(id);
  else if (screen === "gaps") {
    const gaps = await tried(() => api.gaps(id));
    if (gaps && mine()) takeGaps(gaps, id, mine);
  } else if (screen === "labels") {
    const labels = await tried(() => api.labels(id));
    if (labels && mine()) set({ labels });
  } else if (screen === "history") {
    const history = await tried(() => api.history(id));
    if (history && mine()) set({ history });
  }
}

/** Names for a file without a session, by what lies beside it. */
export async function askNames(): Promise<void> {
  const { id } = get();
  if (!id) return;
  say("news", "Names are looked for in what lies beside the file …");
  const last = asking("labels"), labels = await tried(() => api.labels(id, true));
  if (!labels || get().id !== id) return;
  if (last()) set({ labels });
  else await fresh(); // tracks were named meanwhile: the names are known now, but not for which tracks
  if (labels.proposals.length) say("done", `Names for ${labels.proposals.length} tracks are proposed by ${labels.by}.`);
  else say("news", labels.words ?? "");
}

/** The table of gaps; asked for again while some are judged. */
function takeGaps(gaps: Gaps, id: string, mine: () => boolean): void {
  set((s) => ({ gaps, gap: gaps.gaps.find((g) => g.marker === s.gap?.marker && g.first === s.gap.first) ?? null, limit: s.gaps ? s.limit : gaps.limit_mm }));
  const more = async (): Promise<void> => {
    const found = mine() && get().screen === "gaps" ? await tried(() => api.gaps(id)) : null;
    if (found && mine()) takeGaps(found, id, mine);
  };
  if (gaps.pending) setTimeout(() => void more(), AGAIN_MS);
}

let looks = 0;

/** When what is now to be shown is on the screen: what is asked for then takes no time from drawing it. A window that is
 * not seen draws nothing. */
const drawn = (): Promise<unknown> => new Promise((done) => (requestAnimationFrame(() => setTimeout(done, 0)), setTimeout(done, DRAWN_MS)));

/** Look for the problems anew; what an older look finds counts no longer. */
export async function refreshProblems(): Promise<void> {
  const id = get().id, look = ++looks;
  const problems = id && (await tried(() => drawn().then(() => (look === looks ? api.problems(id) : null))));
  if (problems && look === looks && get().id === id) set({ problems });
}

/** Screens that are of no trial. */
const OF_NONE: readonly Screen[] = ["home", "new", "cameras", "um2as"];

/** The server is there again, or a request was lost on its way: what is shown is asked for anew. */
export async function again(): Promise<void> {
  const { screen, header } = get(), whole = header && !OF_NONE.includes(screen);
  set((s) => ({ returns: s.returns + 1 }));
  await (whole ? refetch() : arrive());
}

/** The trial as it is now on the server, where the journal has gone on without this page. */
export async function refetch(): Promise<void> {
  const id = get().id;
  if (!id) return;
  const last = asking("trial"), got = await tried(() => Promise.all([api.trial(id), api.paths(id, VIEW)]));
  if (!got || get().id !== id || !last()) return;
  if (got[0].head !== got[1].head) return refetch(); // the journal went on between the two answers
  take(got[0]);
  set({ paths: got[1], detected: null, instead: null });
  if (got[1].pending) askAgain(id, [...got[1].byName.keys()]);
  await Promise.all([refreshProblems(), fresh()]);
}

/** Heads that the journal had as this page has shown it. */
const heads = new Set<string>();
export const wasShown = (head: string): boolean => heads.has(head);

/** The header after an act; the selection loses what is there no more, and goes with a track that was named as a whole. */
export function take(header: TrialHeader, said?: Act): void {
  asking("trial"); // what was asked for before is older
  heads.add(header.head);
  const samples = new Map(header.tracks.map((track) => [track.name, track.samples]));
  const now = (name: string): string => (said?.kind === "claim" && said.name && said.track === name && !samples.get(name) ? said.name : name);
  set((s) => ({ header, savedAt: header.last?.at ?? s.savedAt, selected: [...new Set(s.selected.map(now))].filter((name) => samples.has(name)) }));
}

/** The paths that an act brought with its answer; whether it brought them, for what is shown. */
export function takeChanged({ paths, removed, head }: ActDone): boolean {
  const { paths: whole, header } = get();
  if (!paths || !whole || whole.pending || whole.head !== header?.head) return false;
  set({ paths: mergePaths(whole, { ...changedPaths(whole, paths), head }, removed) });
  return true;
}

export async function fetchChanged(changed: readonly string[], removed: readonly string[]): Promise<void> {
  const { id, paths } = get();
  if (!id || !paths) return;
  const some = changed.length ? await api.paths(id, VIEW, changed) : { ...paths, byName: new Map() };
  if (get().id !== id) return;
  set((s) => ({ paths: mergePaths(s.paths ?? some, some, removed) }));
  if (changed.length && some.pending) askAgain(id, changed);
}

/** Markers whose fills were not there yet, of which trial; and whether they are about to be asked for. */
let unfilled: { id: string; markers: ReadonlySet<string> } = { id: "", markers: new Set() }, waiting = false;

/** Fetch markers again whose fills were not there yet, until they are. */
function askAgain(id: string, markers: readonly string[]): void {
  unfilled = { id, markers: new Set([...(unfilled.id === id ? unfilled.markers : []), ...markers]) };
  if (!waiting) setTimeout(() => void fetchUnfilled(), AGAIN_MS);
  waiting = true;
}

async function fetchUnfilled(): Promise<void> {
  const { id, markers } = unfilled, there = [...markers].filter((name) => get().paths?.byName.has(name));
  waiting = false;
  unfilled = { id: "", markers: new Set() };
  if (get().id !== id || !there.length) return;
  const some = await tried(() => api.paths(id, VIEW, there));
  if (get().id !== id || !some) return;
  if (some.head !== get().header?.head) return askAgain(id, there); // something was said meanwhile
  set((s) => ({ paths: mergePaths(s.paths ?? some, some, []) }));
  if (some.pending) askAgain(id, there);
}

let looking: readonly [number, number] | null = null;

/** The detections about a frame; asked for once. */
export async function wantDetections(frame: number): Promise<void> {
  const { id, header } = get();
  if (!id || !header || (looking && frame >= looking[0] && frame <= looking[1])) return;
  const first = Math.max(header.first_frame, frame - BEFORE), last = Math.min(header.first_frame + header.n_frames - 1, first + AHEAD);
  looking = [first, last];
  let late = false;
  try {
    const detected = await api.detections(id, first, last);
    late = get().id === id && get().header !== header; // something was said meanwhile: they are other markers' now
    if (get().id === id && !late) set({ detected });
  } catch {
    // the frame is drawn without them, and they are asked for again with the next frame
  } finally {
    looking = null;
  }
  if (late) await wantDetections(playhead.frame);
}
