/** The list of problems as it is walked through. Its order is the server's: what looking at it saves, and the stop rule. */
import type { Act, Alternative, Problem } from "../api/types";

/** Ways that leave the trial as it is. */
const AS_IT_IS: readonly Alternative["action"][] = ["keep", "wait", "leave_open"];

/** Kinds that are about all markers at once. */
const OF_WHOLE: readonly Problem["kind"][] = ["lost", "repeated", "moved", "shaken"];
/** Markers of which a gap may be a problem by itself; more are looked at together, and none of them is selected. */
const FEW = 3;
export const ofWhole = (p: Problem | null): boolean => p !== null && (OF_WHOLE.includes(p.kind) || (p.kind === "gap" && p.tracks.length > FEW));
/** What it is about, short; names as they are shown. */
export const about = (p: Problem, shown = (name: string): string => name): string =>
  p.kind === "gap" && ofWhole(p) ? `${p.tracks.length} markers` : ofWhole(p) ? "all markers" : p.tracks.slice(0, FEW).map(shown).join(p.kind === "join" ? " → " : p.kind === "swap" ? " ⇄ " : ", ") + (p.tracks.length > FEW ? " …" : "");

/** The order in which problems are shown: as they come, those that were put off after the others. */
export function inOrder(problems: readonly Problem[], later: readonly string[]): Problem[] {
  const off = new Set(later);
  return [...problems.filter((p) => !off.has(p.id)), ...problems.filter((p) => off.has(p.id))];
}

/** Those that are worth a look, the first so many of the server's, in the order in which they are shown. */
export const worthALook = (of: { problems: readonly Problem[]; worth_looking: number } | null, later: readonly string[]): Problem[] => inOrder(of?.problems.slice(0, of.worth_looking) ?? [], later);
/** Those that are not. */
export const unlikely = (of: { problems: readonly Problem[]; worth_looking: number } | null, later: readonly string[]): Problem[] => inOrder(of?.problems.slice(of.worth_looking) ?? [], later);

/** The one after or before `current` in a ring; the first or last where there is none. */
export function stepProblem(all: readonly Problem[], current: string | null, step: 1 | -1): Problem | null {
  if (!all.length) return null;
  const at = all.findIndex((p) => p.id === current);
  if (at < 0) return all[step > 0 ? 0 : all.length - 1]!;
  return all[(at + step + all.length) % all.length]!;
}

/** The one to look at when `done` was settled: the first after it that is still there, else the first of all. */
export function nextAfter(before: readonly Problem[], done: string, now: readonly Problem[]): Problem | null {
  const there = new Map(now.map((p) => [p.id, p])), at = before.findIndex((p) => p.id === done);
  const after = before.slice(at + 1).find((p) => p.id !== done && there.has(p.id));
  return (after && there.get(after.id)) ?? now.find((p) => p.id !== done) ?? null;
}

/** What the program proposes: the first, which costs least. */
export const proposed = (p: Problem): Alternative | null => p.alternatives[0] ?? null;

/** Whether an alternative leaves the trial as it is: drawn as A; all others as B. */
export const asItIs = (a: Alternative): boolean => AS_IT_IS.includes(a.action);

/** Whether taking it changes the trial: only that can be drawn beside what is. */
export const changes = (a: Alternative): boolean => a.act !== null && !asItIs(a) && a.action !== "note";

/** The act of taking an alternative; one that says nothing is a verdict that all is right. */
export const actOf = (p: Problem, taken: Alternative): Act => (taken.act as Act | null) ?? { kind: "review", problem: p.id, right: true };

/** The alternative that says that all is right as it is. */
export const keepOf = (p: Problem): Alternative | null => p.alternatives.find(asItIs) ?? null;

/** The first alternative of a kind. */
export const wayOf = (p: Problem | null, action: Alternative["action"]): Alternative | null => p?.alternatives.find((a) => a.action === action) ?? null;

/** The alternative that makes a track no marker, or takes wrong samples away. */
export const dropOf = (p: Problem): Alternative | null => p.alternatives.find((a) => a.action === "no_marker" || a.action === "erase") ?? null;
