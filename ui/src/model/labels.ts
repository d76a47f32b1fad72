/** Tracks and their names, in the order in which they are asked about. */
import type { Labels, Proposal, TrialHeader } from "../api/types";

const rank = (p: Proposal): number => (p.name !== null && p.name !== p.track ? 0 : p.track.startsWith("*") ? 1 : p.state === "unsure" ? 2 : 3);

/** A row for each track that has samples: those with another name proposed, without any, unsure ones; the least probable first. Points that are no markers only where they are asked for. */
export function labelRows(header: TrialHeader, labels: Labels | null, computed = false): Proposal[] {
  const known = new Map(labels?.proposals.map((p) => [p.track, p]));
  const rows = header.tracks
    .filter((t) => t.samples > 0 && (computed || !t.computed))
    .map((t): Proposal => known.get(t.name) ?? { track: t.name, name: t.named ? t.name : null, probability: t.probability ?? NaN, runner_up: t.runner_up ?? null, state: t.named ? "sure" : "unknown" });
  return rows.sort((a, b) => rank(a) - rank(b) || (a.probability || 0) - (b.probability || 0));
}

/** Those that somebody should be asked about. */
export const asked = (rows: readonly Proposal[]): Proposal[] => rows.filter((p) => rank(p) < 3);
