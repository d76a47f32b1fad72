/**
 * The one table of commands: their keys, their words, when they can be done and what they would do now. Keys, help,
 * palette, foot and tests all read it.
 */
import { DETECT_COMMANDS, DIGITISE_COMMANDS, imageUp } from "./imageCommands";
import { SESSION_COMMANDS, sessionUp } from "./sessionCommands";
import { UM2AS_COMMANDS } from "./um2asCommands";
import { many, mm, percent, wayOf } from "../model/format";
import { sameGap, stepGap } from "../model/gaps";
import { rowOrder, zoomed, type Span } from "../model/lanes";
import { computedNames, shownPaths } from "../model/paths";
import { dropOf, keepOf, proposed, wayOf as wayTo } from "../model/problems";
import * as acts from "../state/acts";
import { nameTrack, nextTrack, settle } from "../state/labels";
import { askNames, goTo, runTrial, writePdf } from "../state/load";
import { print } from "../state/print";
import { backToMenu, menuUp, useMenu } from "../state/um2as";
import type { Problem } from "../api/types";
import { currentProblem, get, keep, ofFile, playhead, running, SCREENS, set, TITLES, type Screen, type State } from "../state/store";

export type Group = "Cameras" | "Detection" | "Digitising" | "Time" | "Problems" | "Names" | "Gaps and places" | "View" | "Go to" | "Trial";

export interface Command {
  id: string;
  /** As `chord` writes them: Ctrl+Shift+Z, Shift+N, N, ], Space. */
  keys: readonly string[];
  title: string;
  group: Group;
  /** Where it can be done; on every screen of a trial where it is not said. */
  screens?: readonly Screen[];
  /** Whether it can be done now. */
  when?: (s: State) => boolean;
  /** Done where a trial cannot be shown; of all others that have screens, those of a trial need it there. */
  unshown?: boolean;
  /** Whether it belongs to what is looked at; the foot offers it there alone. */
  fits?: (s: State) => boolean;
  /** What it would do now, in words, for the foot; the title where absent. */
  hint?: (s: State) => string;
  /** Written at the foot, the lower the earlier. */
  foot?: number;
  run: () => void;
}

const EDITOR: readonly Screen[] = ["tracks", "gaps"];
const PLAYED: readonly Screen[] = [...EDITOR, "labels", "angles"];
/** Where what is signed is seen. */
const SHOWN: readonly Screen[] = [...PLAYED, "report", "history"];
const hasTrial = (s: State): boolean => s.header !== null;
const recorded = (s: State): boolean => s.id !== null && !ofFile(s);
const onProblem = (s: State): boolean => s.screen === "tracks" && currentProblem(s) !== null;
const selected = (s: State): boolean => s.selected.length > 0;
/** Values are said of markers; a track without a name is another one in the next run. */
/** Whether there may be a report: of a session's trial. */
const reported = (s: State): boolean => s.header?.session_id != null;
const marker = (s: State): boolean => selected(s) && !s.selected[0]!.startsWith("*");
/** Nothing, or a problem of these kinds, is looked at. */
const free = (s: State, ...kinds: Problem["kind"][]): boolean => kinds.includes(currentProblem(s)?.kind ?? kinds[0]!);
const marked = (s: State): string => (s.first === null ? "from here on" : s.last === null ? `from frame ${s.first} on` : "in the marked stretch");
/** Whether there is a gap to go to. */
const otherGap = (s: State): boolean => (s.gaps?.gaps ?? []).some((g) => !s.gap || !sameGap(g, s.gap));
const flip = (key: "lines" | "images" | "follow" | "alone" | "bands" | "computed") => (): void => set((s) => ({ [key]: !s[key] }));
const go = (screen: Screen) => (): void => goTo(screen);
const jumpTo = (where: (s: State) => number | null | undefined) => (): void => {
  const frame = where(get());
  if (frame != null) playhead.pause(), playhead.go(frame);
};

/** The event before or after the frame that is shown. */
function event(step: 1 | -1): number | undefined {
  const { header } = get();
  const all = (header?.events ?? []).map((e) => Math.round(1 + e.time_s * (header?.rate ?? 1))).sort((a, b) => a - b);
  return step > 0 ? all.find((f) => f > playhead.frame) : all.findLast((f) => f < playhead.frame);
}

function nextMarker(step: 1 | -1): void {
  const { header, paths, computed } = get(), shown = shownPaths(header, paths, computed), names = header && shown ? rowOrder(header, shown) : [], at = names.indexOf(get().selected[0] ?? "");
  if (names.length) set({ selected: [names[(at + step + names.length) % names.length]!], instead: null });
}

function taken(n: number): Command {
  return {
    id: `take-${n}`, keys: [String(n)], title: `Take alternative ${n}`, group: "Problems", screens: ["tracks"],
    when: (s) => (currentProblem(s)?.alternatives.length ?? 0) >= n, foot: n === 1 ? undefined : 10 + n,
    fits: (s) => currentProblem(s)!.alternatives[n - 1]!.action !== "keep", // Y stands for it
    hint: (s) => currentProblem(s)?.alternatives[n - 1]?.words ?? "", run: () => acts.takeNumber(n),
  };
}

function layout(n: 1 | 2 | 3 | 4, title: string): Command {
  return { id: `layout-${n}`, keys: [`Shift+${n}`], title, group: "View", screens: ["tracks"], run: () => (keep("layout", String(n)), set({ layout: n })) };
}

/** The second of two that are selected: the next one, or the one before. */
function nextBeside(step: 1 | -1): void {
  const { header, paths, computed, selected } = get(), shown = shownPaths(header, paths, computed), first = selected[0];
  const names = header && shown ? rowOrder(header, shown).filter((name) => name !== first) : [], at = names.indexOf(selected[1] ?? "");
  if (first && names.length) set({ selected: [first, names[at < 0 ? (step > 0 ? 0 : names.length - 1) : (at + step + names.length) % names.length]!] });
}

/** How many times as many frames one press of a key shows; as in most editors. */
const CLOSER = 2;

/** So many times as many frames about the one that is shown. */
function closer(by: number): void {
  const all = [playhead.first, playhead.last] as const, about = (span: Span): Span => zoomed(span, playhead.frame, by, all);
  set(({ span, window }) => ({ span: about(span), window: about(window) }));
}

const SIDES = 4;

export const COMMANDS: readonly Command[] = [
  // Problems
  { id: "accept", keys: ["Enter"], title: "Accept what is proposed", group: "Problems", screens: ["tracks"], when: onProblem, foot: 1, hint: (s) => proposed(currentProblem(s)!)?.words ?? "accept", run: acts.acceptProposal },
  { id: "next", keys: ["N"], title: "Next problem", group: "Problems", screens: ["tracks"], when: hasTrial, foot: 2, hint: (s) => (currentProblem(s) ? "next problem" : acts.walked(s).length ? (acts.walked(s).length === 1 ? "look at the problem" : `look at the first of ${many(acts.walked(s).length, "problem")}`) : !s.problems ? "problems are being looked for …" : s.problems.problems.length ? "nothing is left that is worth a look" : "no problem is left"), run: () => acts.step(1) },
  { id: "previous", keys: ["Shift+N"], title: "Previous problem", group: "Problems", screens: ["tracks"], when: hasTrial, run: () => acts.step(-1) },
  { id: "unlikely", keys: ["Shift+U"], title: "Show problems that are not worth a look, or hide them", group: "Problems", screens: ["tracks"], when: (s) => (s.problems?.problems.length ?? 0) > (s.problems?.worth_looking ?? 0), run: () => set((s) => ({ unlikely: !s.unlikely })) },
  ...[1, 2, 3, 4, 5].map(taken),
  { id: "right", keys: ["Y"], title: "It is right as it is", group: "Problems", screens: ["tracks"], when: (s) => onProblem(s) && keepOf(currentProblem(s)!) !== null, fits: (s) => wayTo(currentProblem(s), "keep") !== null && proposed(currentProblem(s)!)?.action !== "keep", foot: 20, hint: (s) => keepOf(currentProblem(s)!)!.words, run: acts.rightAsIs },
  { id: "later", keys: ["-"], title: "Later", group: "Problems", screens: ["tracks"], when: onProblem, foot: 22, hint: () => "later", run: acts.putOff },
  { id: "drop", keys: ["Delete"], title: "It is not a marker; erase the marked samples", group: "Problems", screens: ["tracks", "labels", "gaps"], when: (s) => acts.dropping(s) !== null, fits: (s) => s.screen !== "gaps" && (!onProblem(s) || s.first !== null || s.last !== null || dropOf(currentProblem(s)!) !== null), foot: 24, hint: (s) => acts.dropping(s)!.words, run: () => settled(() => acts.dropping(get())?.run()) },
  // Names
  { id: "exchange", keys: ["X"], title: "Exchange two markers from here on, or in the marked stretch", group: "Names", screens: ["tracks"], when: (s) => s.selected.length > 1 && s.selected.slice(0, 2).some((name) => !name.startsWith("*")), fits: (s) => free(s, "swap"), foot: 26, hint: (s) => `exchange ${s.selected[0]} and ${s.selected[1]} ${marked(s)}`, run: acts.exchange },
  { id: "cut", keys: ["C"], title: "Cut here: mark from this frame to the end", group: "Names", screens: ["tracks"], when: selected, run: acts.cut },
  { id: "name", keys: ["L"], title: "Name the selected track", group: "Names", screens: ["tracks", "labels", "gaps"], when: selected, foot: 28, hint: (s) => `name ${s.selected[0]}`, run: () => set({ dialog: "name" }) },
  { id: "unname", keys: ["U"], title: "Take the name away", group: "Names", screens: ["tracks", "labels"], when: selected, run: () => settled(() => acts.claim(null)) },
  { id: "sides", keys: ["Shift+X"], title: "Exchange left and right", group: "Names", screens: ["tracks", "labels"], when: (s) => (s.header?.pairs.length ?? 0) > 0, run: acts.exchangeSides },
  { id: "labels-accept", keys: ["Shift+Enter"], title: "Accept all names above the limit", group: "Names", screens: ["labels"], fits: (s) => !s.labels || acts.sureLabels(LABEL_LIMIT).length > 0, foot: 1, hint: (s) => `name ${many(acts.sureLabels(LABEL_LIMIT).length, "track")} proposed with ${percent(LABEL_LIMIT)} or more${s.labels ? "" : " …"}`, run: () => acts.acceptLabels(LABEL_LIMIT) },
  { id: "labels-ask", keys: ["A"], title: "Propose names by what lies beside the file", group: "Names", screens: ["labels"], when: (s) => s.labels?.can_ask === true, fits: (s) => !s.labels!.by, foot: 1, hint: () => "propose names", run: () => void askNames() },
  { id: "label-take", keys: ["Enter"], title: "Accept the name that is proposed", group: "Names", screens: ["labels"], when: (s) => proposalOf(s) !== null, foot: 2, hint: (s) => `${s.track} is ${proposalOf(s)!.name} (${percent(proposalOf(s)!.probability)})`, run: () => { const p = proposalOf(get()); if (p?.name) void nameTrack(p.name, p.track); } },
  { id: "label-next", keys: ["N"], title: "Next track to be asked about", group: "Names", screens: ["labels"], foot: 3, hint: () => "next track", run: () => nextTrack(1) },
  { id: "label-previous", keys: ["Shift+N"], title: "Previous track to be asked about", group: "Names", screens: ["labels"], run: () => nextTrack(-1) },
  // Gaps and places
  { id: "fill", keys: ["G"], title: "Fill the gap here", group: "Gaps and places", screens: ["tracks"], when: marker, hint: (s) => wayTo(currentProblem(s), "fill")?.words ?? "fill the gap here", run: () => acts.settleGap("fill") },
  { id: "gap-fill", keys: ["Enter", "G"], title: "Fill the gap by the method shown", group: "Gaps and places", screens: ["gaps"], when: (s) => s.gap !== null, foot: 1, hint: (s) => `fill ${s.gap!.marker}, ${many(s.gap!.frames, "frame")}, by ${wayOf(s.method ?? "best")}, expected ${mm(errorOf(s))} mm`, run: () => void acts.fillGap() },
  { id: "gap-all", keys: ["Shift+Enter"], title: "Fill all gaps below the limit", group: "Gaps and places", screens: ["gaps"], fits: () => acts.acceptable().length > 0, foot: 2, hint: (s) => `fill ${many(acts.acceptable().length, "gap")} below ${s.limit} mm`, run: () => void acts.fillAll() },
  { id: "method", keys: ["Shift+G"], title: "Next method", group: "Gaps and places", screens: ["gaps"], when: (s) => (s.candidates?.candidates.length ?? 0) > 1, foot: 3, hint: () => "next method", run: () => acts.nextMethod() },
  { id: "open", keys: ["O"], title: "Leave the gap open", group: "Gaps and places", screens: EDITOR, when: (s) => (s.screen === "gaps" ? s.gap !== null : marker(s)), fits: (s) => s.screen === "gaps" || wayTo(currentProblem(s), "leave_open") !== null, foot: 21, hint: () => "leave the gap open", run: () => acts.settleGap("leave_open") },
  { id: "gap-next", keys: ["N"], title: "Next gap", group: "Gaps and places", screens: ["gaps"], fits: otherGap, foot: 4, hint: () => "next gap", run: () => nextGap(1) },
  { id: "gap-previous", keys: ["Shift+N"], title: "Previous gap", group: "Gaps and places", screens: ["gaps"], run: () => nextGap(-1) },
  { id: "put", keys: ["P"], title: "Put a point: by its coordinates, or by clicks in two images", group: "Gaps and places", screens: EDITOR, when: marker, foot: 30, hint: (s) => (s.clicks ? "no longer put" : `put ${s.selected[0]} in this frame`), run: () => set((s) => ({ clicks: s.clicks ? null : [] })) },
  { id: "smooth", keys: ["M"], title: "Smooth the marked stretch …", group: "Gaps and places", screens: EDITOR, when: (s) => marker(s) && s.first !== null && s.last !== null, run: acts.smooth },
  { id: "mark-first", keys: ["["], title: "Mark from here", group: "Gaps and places", screens: EDITOR, hint: () => "mark from here", run: () => set((s) => ({ first: playhead.frame, last: s.last !== null && s.last < playhead.frame ? null : s.last })) },
  { id: "mark-last", keys: ["]"], title: "Mark to here", group: "Gaps and places", screens: EDITOR, hint: () => "mark to here", run: () => set((s) => ({ last: playhead.frame, first: s.first !== null && s.first > playhead.frame ? null : s.first })) },
  { id: "event", keys: ["K"], title: "Add an event here", group: "Gaps and places", screens: EDITOR, run: () => set({ dialog: "event" }) },
  // Time
  { id: "play", keys: ["Space"], title: "Play or pause", group: "Time", screens: [...EDITOR, "labels"], run: () => playhead.toggle() },
  { id: "forward", keys: ["ArrowRight"], title: "1 frame on", group: "Time", screens: PLAYED, run: () => playhead.step(1) },
  { id: "back", keys: ["ArrowLeft"], title: "1 frame back", group: "Time", screens: PLAYED, run: () => playhead.step(-1) },
  { id: "forward-10", keys: ["Shift+ArrowRight"], title: "10 frames on", group: "Time", screens: PLAYED, run: () => playhead.step(10) },
  { id: "back-10", keys: ["Shift+ArrowLeft"], title: "10 frames back", group: "Time", screens: PLAYED, run: () => playhead.step(-10) },
  { id: "event-next", keys: ["Ctrl+ArrowRight"], title: "Next event", group: "Time", screens: PLAYED, run: jumpTo(() => event(1)) },
  { id: "event-back", keys: ["Ctrl+ArrowLeft"], title: "Event before", group: "Time", screens: PLAYED, run: jumpTo(() => event(-1)) },
  { id: "start", keys: ["Home"], title: "First frame", group: "Time", screens: PLAYED, run: jumpTo((s) => s.header?.first_frame) },
  { id: "end", keys: ["End"], title: "Last frame", group: "Time", screens: PLAYED, run: jumpTo(() => playhead.last) },
  { id: "marker-next", keys: ["."], title: "Next marker", group: "Time", screens: EDITOR, run: () => nextMarker(1) },
  { id: "marker-back", keys: [","], title: "Marker before", group: "Time", screens: EDITOR, run: () => nextMarker(-1) },
  { id: "second-next", keys: [">"], title: "Select a second marker: the next", group: "Time", screens: EDITOR, when: selected, run: () => nextBeside(1) },
  { id: "second-back", keys: ["<"], title: "Select a second marker: the one before", group: "Time", screens: EDITOR, when: selected, run: () => nextBeside(-1) },
  // View
  { id: "lines", keys: ["E"], title: "Epipolar lines", group: "View", screens: EDITOR, run: flip("lines") },
  { id: "images", keys: ["I"], title: "Images of the cameras", group: "View", screens: EDITOR, run: flip("images") },
  { id: "follow", keys: ["Z"], title: "Follow the selected marker in the images, larger", group: "View", screens: EDITOR, run: flip("follow") },
  { id: "focus", keys: ["F"], title: "Look at what is selected", group: "View", screens: EDITOR, when: selected, run: () => set((s) => ({ focused: s.focused + 1 })) },
  { id: "alone", keys: ["H"], title: "Hide the others", group: "View", screens: EDITOR, run: flip("alone") },
  { id: "computed", keys: ["J"], title: "Points that are no markers: axes of segments, centres of joints", group: "View", screens: [...EDITOR, "labels", "angles"], when: (s) => computedNames(s.header).length > 0, run: flip("computed") },
  { id: "bands", keys: ["B"], title: "95 % bands and ellipsoids", group: "View", screens: EDITOR, run: flip("bands") },
  { id: "fourth", keys: ["R"], title: "Residual instead of speed", group: "View", screens: EDITOR, run: () => set((s) => ({ fourth: s.fourth === "speed" ? "residual" : "speed" })) },
  { id: "side", keys: ["V"], title: "From the side, the front, above, or between", group: "View", screens: EDITOR, run: () => set((s) => ({ side: (s.side + 1) % SIDES })) },
  { id: "closer", keys: ["Ctrl+ArrowUp", "+"], title: "Closer about this frame, in lanes and curves", group: "View", screens: [...EDITOR, "labels"], run: () => closer(1 / CLOSER) },
  { id: "wider", keys: ["Ctrl+ArrowDown", "_"], title: "Wider about this frame, in lanes and curves", group: "View", screens: [...EDITOR, "labels"], run: () => closer(CLOSER) },
  { id: "whole", keys: ["W"], title: "The whole trial in lanes and curves", group: "View", screens: [...EDITOR, "labels"], run: () => { playhead.loop = null; set({ window: null, span: null }); } },
  layout(1, "Layout: view, cameras, curves and list"), layout(2, "Layout: view and list"), layout(3, "Layout: cameras and list"), layout(4, "Layout: curves and list"),
  // Trial
  { id: "undo", keys: ["Ctrl+Z"], title: "Undo", group: "Trial", when: (s) => s.header?.undo != null, foot: 40, hint: () => "undo", run: () => void acts.undo() },
  { id: "redo", keys: ["Ctrl+Shift+Z", "Ctrl+Y"], title: "Redo", group: "Trial", when: (s) => s.header?.redo != null, run: () => void acts.redo() },
  { id: "why", keys: ["Shift+W"], title: "Why: a note for the next act", group: "Trial", when: hasTrial, run: () => set({ dialog: "why" }) },
  { id: "again", keys: ["Shift+M"], title: "Track again with what was said: a correction mends its neighbourhood", group: "Trial", when: (s) => (s.header?.has_detections ?? false) && (s.header?.edits ?? 0) > 0, run: () => void acts.trackAgain() },
  { id: "finish", keys: ["Shift+F"], title: "Finish: drop the unnamed, trim to common frames, write C3D", group: "Trial", when: hasTrial, run: () => set({ dialog: "finish" }) },
  { id: "sign", keys: ["Shift+S"], title: "Sign the trial as it is", group: "Trial", screens: SHOWN, when: hasTrial, foot: 50, hint: () => "sign the trial", run: () => set({ dialog: "sign" }) },
  { id: "pdf", keys: ["P"], title: "PDF of the report", group: "Trial", screens: ["report"], when: reported, foot: 1, hint: () => "PDF of the report", run: () => void writePdf() },
  { id: "print", keys: ["Shift+P", "Ctrl+P"], title: "Print this page", group: "Trial", foot: 60, hint: (s) => (s.screen === "report" && reported(s) ? "the report alone, to print" : "print this page"), run: print },
  { id: "run", keys: ["Shift+Enter"], title: "Run the trial, so that it can be shown", group: "Trial", screens: SHOWN, unshown: true, when: (s) => s.id !== null && !running(s, s.id) && s.runs && s.unshown !== "", foot: 1, hint: () => "run the trial", run: () => void runTrial() },
  // Go to
  ...SESSION_COMMANDS,
  ...UM2AS_COMMANDS,
  ...DETECT_COMMANDS,
  ...DIGITISE_COMMANDS,
  { id: "detect", keys: ["Alt+Shift+D"], title: "Detect", group: "Go to", when: recorded, run: go("detect") },
  { id: "digitise", keys: ["Alt+Shift+G"], title: "Digitise & verify", group: "Go to", when: recorded, run: go("digitise") },
  { id: "angles", keys: ["Shift+A"], title: "Angles", group: "Go to", when: hasTrial, run: go("angles") },
  { id: "home", keys: ["Alt+Shift+H"], title: "Home", group: "Go to", run: go("home") },
  { id: "tracks", keys: ["Shift+T"], title: "Tracks", group: "Go to", when: hasTrial, run: go("tracks") },
  { id: "labels", keys: ["Shift+L"], title: "Labels", group: "Go to", when: hasTrial, run: go("labels") },
  { id: "gaps", keys: ["Shift+D"], title: "Gaps", group: "Go to", when: hasTrial, run: go("gaps") },
  { id: "report", keys: ["Shift+R"], title: "Report", group: "Go to", when: hasTrial, run: go("report") },
  { id: "history", keys: ["Shift+H"], title: "History", group: "Go to", when: hasTrial, run: go("history") },
  { id: "commands", keys: ["Ctrl+K"], title: "Search for a command", group: "Go to", run: () => set({ dialog: "commands" }) },
  { id: "help", keys: ["?", "F1"], title: "Help: what to do, and all keys", group: "Go to", foot: 90, hint: () => "help", run: () => set({ dialog: "help" }) },
  { id: "up", keys: ["Escape"], title: "One level up", group: "Go to", when: (s) => levelUp(s) !== null, foot: 91, hint: (s) => levelUp(s)!.words, run: () => levelUp(get())?.run() },
];

/** Least probability of names that are accepted all at once. */
export const LABEL_LIMIT = 0.99;

const errorOf = (s: State): number | null => s.candidates?.candidates.find((c) => c.method === s.method)?.expected_mm ?? s.gap?.expected_mm ?? null;
const proposalOf = (s: State): { track: string; name: string | null; probability: number } | null => s.labels?.proposals.find((p) => p.track === s.track && p.name !== null && p.track !== p.name) ?? null;

function nextGap(by: 1 | -1): void {
  const next = stepGap(acts.tabled(get()), get().gap, by);
  if (next) void acts.lookAtGap(next);
}

/** Do something to the selected track; on Labels the next that somebody is asked about comes then. */
function settled(work: () => Promise<unknown> | undefined): void {
  const { screen, selected } = get();
  void (screen === "labels" && selected[0] ? settle(selected[0], async () => work()) : work());
}

/** What Escape would do. */
export interface Level { words: string; run: () => void }

/** Escape: what is open closes, then marks, then the selection, then the screen; null on Home, the top. */
function levelUp(s: State): Level | null {
  const { from, level, task } = useMenu.getState();
  const open = imageUp(s) ?? sessionUp(s, from !== "") ?? trialUp(s);
  if (open) return open;
  if (s.screen === "um2as") return { words: task || level ? "one level up" : "leave UM²AS", run: menuUp };
  if (from) return { words: "back to the menu of UM²AS", run: backToMenu };
  if (s.screen === "home") return null;
  const to = s.screen === "tracks" || !s.header ? "home" : "tracks";
  return { words: `to ${TITLES[to]}`, run: go(to) };
}

/** What is open, marked or selected of a trial. */
function trialUp(s: State): Level | null {
  if (!s.header || !["tracks", "labels", "gaps"].includes(s.screen)) return null;
  if (s.clicks) return { words: "no longer put", run: () => set({ clicks: null }) };
  if (s.first !== null || s.last !== null) return { words: "take the marks away", run: () => set({ first: null, last: null }) };
  if (s.screen === "tracks" && s.problem) return { words: "leave the problem", run: leaveIt };
  if (s.screen === "gaps" && s.gap) return { words: "leave the gap", run: leaveIt };
  return s.selected.length ? { words: "select nothing", run: () => set({ selected: [] }) } : null;
}

function leaveIt(): void {
  playhead.loop = null;
  set({ problem: null, instead: null, window: null, gap: null, candidates: null });
}

export const byId = (id: string): Command => COMMANDS.find((c) => c.id === id)!;

/** Whether nothing of the trial is there, so that its keys would do nothing, and one of them may mean another thing. */
const lacking = (s: State): boolean => SHOWN.includes(s.screen) && !hasTrial(s);

/** Whether a command can be done now. */
export const possible = (c: Command, s: State): boolean => (!c.screens || (c.screens.includes(s.screen) && Boolean(c.unshown) === lacking(s))) && (!c.when || c.when(s));

/** What the foot says: the commands that are most likely now, with what they would do. */
export const footLine = (s: State): { key: string; words: string; id: string }[] =>
  COMMANDS.filter((c) => c.foot !== undefined && possible(c, s) && (!c.fits || c.fits(s)))
    .sort((a, b) => a.foot! - b.foot!)
    .map((c) => ({ key: c.keys[0]!, words: c.hint?.(s) ?? c.title.toLowerCase(), id: c.id }));

/** Two commands that one key would mean on one screen; there must be none. */
export function clashes(all: readonly Command[] = COMMANDS): string[] {
  const seen = new Map<string, string>(), found: string[] = [];
  for (const c of all)
    for (const key of c.keys)
      for (const screen of c.screens ?? SCREENS) {
        const at = `${screen}${c.unshown ? " without a trial" : ""} ${key}`, other = seen.get(at);
        if (other) found.push(`${at}: ${other} and ${c.id}`);
        seen.set(at, c.id);
      }
  return found;
}
