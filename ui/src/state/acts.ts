/** What a person does to a trial. Acts are sent one after another, each on the head that the one before gave. */
import * as api from "../api/client";
import type { Act, ActDone, GapCandidates, GapRow, Problem, Problems, SmoothingFunction } from "../api/types";
import { many, percent, wayOf as called } from "../model/format";
import { keptNames } from "../model/labels";
import { inTable, sameGap } from "../model/gaps";
import { actOf, dropOf, keepOf, nextAfter, ofWhole, proposed, stepProblem, unlikely, wayOf, worthALook } from "../model/problems";
import { unanswered } from "./again";
import { askedUntilThere, drawInstead } from "./instead";
import { asking } from "./newest";
import { again, fetchChanged, fresh, refreshProblems, say, take, takeChanged } from "./load";
import { currentProblem, get, playhead, set, still, useStore, type State } from "./store";

/** s before and after a problem that playing goes round in; the design's. */
const ROUND_S = 0.4;
/** s of curves beside a problem at least, and of a problem that is shown as a whole at most; chosen. */
const BESIDE_S = 1.2, WHOLE_S = 12;

let queue: Promise<unknown> = Promise.resolve();
/** When all that was said is answered. */
export const quiet = (): Promise<unknown> => queue;
/** The last look for problems: no act waits for it. */
let looking: Promise<void> = Promise.resolve();

/** Say an act. Gives what it did, null where it was refused. */
export function act(what: Act, words = ""): Promise<ActDone | null> {
  const next = queue.then(() => send(what, words));
  queue = next.catch(() => null);
  return next;
}

async function send(what: Act, words: string): Promise<ActDone | null> {
  const { id, header, why } = get();
  if (!id || !header) return null;
  set((s) => ({ busy: s.busy + 1 }));
  try {
    const done = await api.act(id, header.head, what, why);
    if (get().id !== id) return null;
    if (!get().paths) return await again(), null; // the trial was left, and is being opened anew
    if (!takeChanged(done)) await fetchChanged(done.changed, done.removed);
    take(done.header, what);
    set({ instead: null, detected: null, why: "", join: null, savedAt: new Date().toISOString() });
    said(done, words); // all of it in one tick, so that the page is drawn once
    looking = refreshProblems();
    await fresh();
    return done;
  } catch (error) {
    await refused(error);
    return null;
  } finally {
    set((s) => ({ busy: s.busy - 1 }));
    playhead.draw();
  }
}

function said(done: ActDone, words: string): void {
  const other = done.outcomes.filter((one) => one.outcome !== "held"), all = other.length === done.outcomes.length;
  const lost = other.find((one) => one.outcome !== "moot") ?? (all ? other[0] : undefined); // one part had nothing to do
  const what = words || done.outcomes.map((one) => one.words).join("; ") || "Done";
  if (lost) say("news", `${what}: ${lost.outcome}${lost.reason ? `, ${lost.reason}` : ""}.`);
  else say("done", `${what}.`);
}

async function refused(error: unknown): Promise<void> {
  if (error instanceof api.Refused && error.status === 409) {
    await again();
    say("refused", "The trial had gone on in another window; it is shown as it is now, and what you just did was not done. Do it again if it is still right.");
  } else say("refused", error instanceof Error ? error.message : String(error));
  unanswered(error, again); // it may have been written all the same
}

export const undo = (): Promise<unknown> => act({ kind: "undo" }, "Undone");
/** Make the tracks again with what was said as facts: takes as long as tracking does. */
export const trackAgain = (): Promise<unknown> => {
  say("news", "Tracked again, with what was said as facts …");
  return act({ kind: "track_again" }, "Tracked again");
};
export const redo = (): Promise<unknown> => act({ kind: "redo" }, "Done again");

/** Look at a problem: its frames go round, its markers are selected, both ways are drawn. */
export function lookAt(problem: Problem): void {
  const rate = get().header?.rate ?? 100, round = Math.round(ROUND_S * rate);
  playhead.pause();
  playhead.loop = [Math.max(playhead.first, problem.frame - round), Math.min(playhead.last, problem.frame + round)];
  const there = ofWhole(problem) ? [] : problem.tracks.filter((name) => get().paths?.byName.has(name));
  set((s) => ({ problem: problem.id, selected: there, instead: null, first: null, last: null, window: windowOf(problem, rate), focused: s.focused + 1, join: null, follow: true }));
  playhead.go(problem.frame);
  if (!still() && (problem.kind === "swap" || problem.kind === "sides")) playhead.play();
  void drawInstead(problem);
}

/** Frames that the curves show: a problem and as much of its markers as it is long, but of a very long one its beginning. */
export function windowOf({ first, last, frame }: Problem, rate: number): [number, number] {
  const from = Math.min(first, frame), to = last - from <= WHOLE_S * rate ? last : frame + 4 * BESIDE_S * rate;
  const beside = Math.round(Math.max(BESIDE_S * rate, (to - from) / 2));
  return [Math.max(playhead.first, from - beside), Math.min(playhead.last, Math.round(Math.min(last, to)) + beside)];
}

/** The problems that are gone through: those worth a look, and all others where they are shown. */
export const walked = (s: State): Problem[] => [...worthALook(s.problems, s.later), ...(s.unlikely ? unlikely(s.problems, s.later) : [])];

export function step(by: 1 | -1): void {
  const s = get();
  if (!s.problems) return soon(by);
  const next = stepProblem(walked(s), s.problem, by), rest = s.problems.problems.length;
  if (next) lookAt(next);
  else say("news", rest ? `Nothing is left that is worth a look; ${many(rest, "problem")} below 5 % can be shown under the list.` : "There is nothing to look at.");
}

/** The step that was asked for before the problems were there. */
function soon(by: 1 | -1): void {
  say("news", "The problems are still being looked for …");
  const off = useStore.subscribe((now) => {
    if (!now.problems) return;
    off();
    step(by);
  });
}

/** Take an alternative of the problem that is looked at; then the next one comes by itself. */
export async function choose(problem: Problem, key: string): Promise<void> {
  const taken = problem.alternatives.find((a) => a.key === key);
  if (!taken) return;
  if (taken.action === "wait") return putOff(); // nothing is said: it stays in the list
  const before = walked(get());
  const done = await act(actOf(problem, taken), taken.action === "note" ? "Noted; the trial stays as it is" : `Taken: ${taken.words}`);
  if (!done || get().problem !== problem.id) return;
  set((s) => ({ problems: s.problems && without(s.problems, problem) })); // no key is for it now
  const at = atOnce(before, problem, done);
  if (at) lookAt(at);
  await looked();
  const now = walked(get()), seen = at?.id ?? problem.id;
  if (get().problem !== seen || (at && now.some((p) => p.id === seen))) return; // the person went on, or is where they should be
  const next = nextAfter(before, problem.id, now);
  if (next) lookAt(next);
  else finishLooking();
}

/** The newest look for problems is done: one that an edit came before is answered at once, with nothing. */
async function looked(): Promise<void> {
  for (let last = null as Promise<void> | null; last !== looking; ) await (last = looking);
}

/** The next problem of whose tracks nothing was changed: it is there without being looked for. Those before it, which may be no more, come last. */
function atOnce(before: readonly Problem[], settled: Problem, { changed, removed }: ActDone): Problem | null {
  const other = new Set([...changed, ...removed]), stands = (p: Problem): boolean => p.kind !== "edit" && !p.tracks.some((name) => other.has(name));
  return nextAfter(before, settled.id, walked(get()).filter(stands));
}

/** The problems but for one. */
function without(all: Problems, one: Problem): Problems {
  const at = all.problems.findIndex((p) => p.id === one.id);
  return at < 0 ? all : { ...all, problems: all.problems.filter((p) => p.id !== one.id), worth_looking: all.worth_looking - (at < all.worth_looking ? 1 : 0) };
}

function finishLooking(): void {
  playhead.loop = null;
  set({ problem: null, instead: null, window: null });
}

export function acceptProposal(): void {
  const p = currentProblem(get());
  const taken = p && proposed(p);
  if (p && taken) void choose(p, taken.key);
}

export function takeNumber(n: number): void {
  const p = currentProblem(get()), taken = p?.alternatives[n - 1];
  if (p && taken) void choose(p, taken.key);
}

export function rightAsIs(): void {
  const p = currentProblem(get());
  const keep = p && keepOf(p);
  if (p && keep) void choose(p, keep.key);
}

export function putOff(): void {
  const p = currentProblem(get());
  if (!p) return;
  set((s) => ({ later: [...s.later, p.id] }));
  step(1);
}

/** The marked stretch, as acts have it: null follows the path as far as it goes. */
export const stretch = (): { first: number | null; last: number | null } => ({ first: get().first, last: get().last });

export async function claim(name: string | null, track = get().selected[0]): Promise<ActDone | null> {
  return track ? act({ kind: "claim", track, name, ...stretch(), at: playhead.frame }, name ? `${track} is ${name}` : track.startsWith("*") ? `${track} is no marker` : `${track} has no name here`) : null;
}

/** What Delete does: the marked samples, else the way that the problem offers, else the track as a whole; null: nothing. */
export function dropping(s: State): { words: string; run: () => Promise<unknown> } | null {
  const p = currentProblem(s), drop = p && dropOf(p), name = s.selected[0], { first, last } = s;
  const own = first !== null || last !== null || (name !== undefined && !p?.tracks.includes(name)); // the person's choice
  if (p && drop && !own) return { words: drop.words, run: () => choose(p, drop.key) };
  if (!name) return null;
  if (first === null || last === null || name.startsWith("*")) return { words: `${name} is no marker${first === null && last === null ? "" : " in the marked stretch"}`, run: () => claim(null, name) };
  return { words: `erase the marked samples of ${name}`, run: () => act({ kind: "erase", marker: name, first, last }, `Samples of ${name} erased`) };
}

export function exchange(): void {
  const [a, b] = get().selected, { first, last } = get();
  if (!a || !b) return say("news", "Select two markers first: click one, then the other with Ctrl.");
  void act({ kind: "exchange", a, b, first: first ?? playhead.frame, last }, `${a} and ${b} exchanged from frame ${first ?? playhead.frame} on`);
}

export function exchangeSides(): void {
  const alone = keptNames(get().header?.one_sided ?? []);
  void act({ kind: "sides", ...stretch() }, `Left and right exchanged${alone && `; ${alone}`}`);
}

/** Cut here: from this frame on is one stretch, to be named or taken away. */
export function cut(): void {
  const track = get().header?.tracks.find((t) => t.name === get().selected[0]);
  if (!track) return say("news", "Select a marker first.");
  set({ first: playhead.frame, last: null });
  say("news", `${track.name} is marked from frame ${playhead.frame} on: L names that piece, U takes its name away, Del says it is no marker`);
}

/** How two pieces go together, before one name is given to both. */
export async function askJoin(track: string, name: string): Promise<void> {
  const id = get().id, last = asking("join");
  set({ join: null });
  if (!id || !get().paths?.byName.has(name) || name === track) return;
  try {
    const shown = await api.preview(id, { kind: "claim", track, name, ...stretch(), at: playhead.frame });
    if (shown?.join && last()) set({ join: { track, name, join: shown.join } });
  } catch {
    // the act itself will say why it cannot be
  }
}

export function gapHere(): GapRow | null {
  const { gap, selected, paths } = get(), name = selected[0], path = name ? paths?.byName.get(name) : undefined;
  if (get().screen === "gaps" && gap) return gap;
  if (!path || !paths || !name) return null;
  let a = playhead.frame - paths.firstFrame, b = a;
  if (path.origin[a] === 1 || path.origin[a] === 3) return null;
  while (a > 0 && path.origin[a - 1] === path.origin[b]) a--;
  while (b + 1 < paths.frames && path.origin[b + 1] === path.origin[a]) b++;
  return { marker: name, first: a + paths.firstFrame, last: b + paths.firstFrame, frames: b - a + 1, method: null, expected_mm: null, others: [], cameras_alone: [], state: "open", choice: null, words: "" };
}

/** Fill the gap that the problem is about, or leave it open; else the one of the selected marker in this frame. */
export function settleGap(action: "fill" | "leave_open"): void {
  const p = currentProblem(get()), way = wayOf(p, action);
  if (p && way) void choose(p, way.key);
  else void fillGap(action === "fill" ? "best" : "open");
}

export async function fillGap(method = get().method ?? "best"): Promise<void> {
  const gap = gapHere();
  if (!gap) return say("news", "There is no gap of the selected marker in this frame.");
  const rows = tabled(get());
  const words = method === "open" ? `${gap.marker} is left open` : `${gap.marker}: ${many(gap.frames, "frame")} filled by ${called(method)}`;
  const done = await act({ kind: "gap", marker: gap.marker, first: gap.first, last: gap.last, method: sayable(method) }, words);
  if (done) nextUndecided(rows, gap);
}

/** The gaps in the order in which the table shows them. */
export const tabled = (s: State): readonly GapRow[] => inTable(s.gaps?.gaps ?? [], s.gapOrder);

/** Look at the first gap after one, as they stood, for which nobody has said anything yet. */
function nextUndecided(rows: readonly GapRow[], after: GapRow): void {
  if (get().screen !== "gaps") return;
  const left = get().gaps?.gaps ?? [], at = rows.findIndex((g) => sameGap(g, after));
  const next = [...rows.slice(at + 1), ...rows.slice(0, Math.max(0, at))].map((g) => left.find((l) => sameGap(l, g) && undecided(l))).find(Boolean);
  if (next) void lookAtGap(next);
}

/** A method as it can be said; a mean of several, which only filling itself makes, is the best there is. */
const sayable = (method: string | null | undefined): string => (method === "open" || get().header?.methods.includes(method ?? "") ? method! : "best");

/** Whether nobody has said yet what becomes of a gap. */
export const undecided = (g: GapRow): boolean => g.choice == null;

export const acceptable = (): GapRow[] => (get().gaps?.gaps ?? []).filter((g) => undecided(g) && g.method != null && g.expected_mm != null && g.expected_mm <= get().limit);

/** All gaps whose expected error is below the limit, in one act. */
export async function fillAll(): Promise<void> {
  const some = acceptable();
  if (!some.length) return void say("news", `No undecided gap has an expected error below ${get().limit} mm.`);
  const acts = some.map((g) => ({ kind: "gap" as const, marker: g.marker, first: g.first, last: g.last, method: sayable(g.method) }));
  const rows = tabled(get()), done = await act({ kind: "several", acts }, `${many(some.length, "gap")} filled, each by the method that was proposed for it`);
  if (done && get().gap) nextUndecided(rows, get().gap!);
}

export async function lookAtGap(gap: GapRow): Promise<void> {
  const id = get().id, beside = Math.max(20, gap.frames);
  const chosen = gap.choice == null || gap.choice === "open" ? null : gap.choice;
  set((s) => ({ gap, selected: [gap.marker], method: chosen ?? gap.method, picked: chosen !== null, candidates: null, first: gap.first, last: gap.last, window: [Math.max(playhead.first, gap.first - beside), Math.min(playhead.last, gap.last + beside)], focused: s.focused + 1, follow: true }));
  playhead.pause();
  playhead.loop = [Math.max(playhead.first, gap.first - beside), Math.min(playhead.last, gap.last + beside)];
  playhead.go(Math.round((gap.first + gap.last) / 2));
  const still = (): boolean => get().id === id && get().gap !== null && sameGap(get().gap!, gap);
  if (id) await askedUntilThere(id, gap.marker, gap.first, still, (candidates) => set((s) => ({ candidates, method: s.picked ? s.method : bestOf(candidates) ?? s.method })));
}

/** What would fill it best as far as is known; the best of the first answer until all ways were tried. */
const bestOf = (of: GapCandidates): string | null => of.best ?? of.candidates[0]?.method ?? null;

export function nextMethod(by = 1): void {
  const all = get().candidates?.candidates ?? [];
  if (!all.length) return;
  const at = all.findIndex((c) => c.method === get().method);
  set({ method: all[(at + by + all.length) % all.length]!.method, picked: true });
}

/** Names that automatic labelling is sure enough of, for tracks that have none. */
export function sureLabels(limit: number): { track: string; name: string }[] {
  return (get().labels?.proposals ?? []).flatMap((p) => (p.name && p.track.startsWith("*") && p.probability >= limit ? [{ track: p.track, name: p.name }] : []));
}

export function acceptLabels(limit: number): void {
  const some = sureLabels(limit);
  if (!some.length) return say("news", `No track without a name has one proposed with ${percent(limit)} or more.`);
  void act({ kind: "several", acts: some.map((one) => ({ kind: "claim" as const, ...one })) }, `${some.length} tracks named`);
}

export function putHere(xyz: [number, number, number] | null): void {
  const { selected, clicks } = get(), marker = selected[0];
  if (!marker) return say("news", "Select the marker that is to be put here first.");
  const where = xyz ? { xyz } : { clicks: [...(clicks ?? [])] };
  void act({ kind: "put", marker, frame: playhead.frame, ...where }, `${marker} put in frame ${playhead.frame}`).then((done) => done && set({ clicks: null }));
}

/** Ask by which function and below what; the stretch is the marked one. */
export function smooth(): void {
  const { selected, first, last } = get();
  if (!selected[0] || first === null || last === null) return say("news", "Select a marker and mark a stretch with [ and ] first.");
  set({ dialog: "smooth" });
}

export function smoothBy(way: SmoothingFunction, cutoff_hz: number): void {
  const { selected, first, last } = get(), marker = selected[0];
  if (!marker || first === null || last === null) return;
  void act({ kind: "smooth", marker, first, last, cutoff_hz, function: way }, `${marker} smoothed below ${cutoff_hz} Hz in frames ${first}–${last}`);
}
