/** The order in which problems are worth a look, and what is left when one stops. */
import type { Act, Alternative, Problem } from "../api/types";

/** What is expected to be lost by not looking: probability × samples × mm. A gap is certain. */
export const expectedCost = (p: Problem): number => (p.wrong ?? 1) * p.at_stake * (p.cost_mm ?? 1);

/** Least probability of an error that is worth a look; as the server's stop rule has it. */
export const WORTH = 0.05;

/** Edits that no longer hold come first, then by expected cost; equal ones by their frame. */
export function orderProblems(problems: readonly Problem[]): Problem[] {
  const lost = (p: Problem): number => (p.kind === "orphan" ? 2 : p.kind === "thin" ? 1 : 0);
  return [...problems].sort((a, b) => lost(b) - lost(a) || expectedCost(b) - expectedCost(a) || a.first - b.first);
}

/** The one after or before `current` in a ring; the first or last where there is none. */
export function stepProblem(all: readonly Problem[], current: string | null, step: 1 | -1): Problem | null {
  if (!all.length) return null;
  const at = all.findIndex((p) => p.id === current);
  if (at < 0) return all[step > 0 ? 0 : all.length - 1]!;
  return all[(at + step + all.length) % all.length]!;
}

/** What the program proposes: the first alternative. */
export const proposed = (p: Problem): Alternative | null => p.alternatives[0] ?? null;

/** The act of taking an alternative; one that changes nothing is a verdict that all is right. */
export const actOf = (p: Problem, taken: Alternative): Act =>
  (taken.act as Act | null) ?? { kind: "review", problem: p.id, right: true };

/** The act of an alternative that makes a track no marker, or takes wrong samples away. */
export const dropOf = (p: Problem): Alternative | null =>
  p.alternatives.find((a) => (a.act?.kind === "claim" && a.act.name === null) || a.act?.kind === "erase") ?? null;
