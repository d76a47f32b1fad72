/** Tracks and their names, in the order in which they are asked about. */
import { frames } from "./format";
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

/** A choice of the list of names: what it is called, and what is known of it. */
export interface NameChoice { id: string; words: string; beside: string }

/** All markers that there are names for: of the marker set, of the file by which names are proposed, and those that are there. */
export const knownNames = (header: TrialHeader | null, labels: Labels | null): string[] => {
  const there = header?.tracks.filter((t) => t.named && !t.computed).map((t) => t.name) ?? [];
  return [...new Set([...(header?.marker_set?.names ?? []), ...(labels?.known ?? []), ...there])];
};

/** What a track may be called: what is proposed first, then what else it may be, names that no track has, and the others. */
export function nameChoices(header: TrialHeader | null, labels: Labels | null, track: string): NameChoice[] {
  const has = new Map(header?.tracks.filter((t) => t.named && !t.computed && t.samples > 0).map((t) => [t.name, t]));
  const proposal = labels?.proposals.find((p) => p.track === track), best = proposal?.name, next = proposal?.runner_up;
  const rank = (name: string): number => (name === best ? 0 : name === next ? 1 : has.has(name) ? 3 : 2);
  const beside = (name: string): string => {
    const other = has.get(name), taken = other ? `has ${frames(other.first ?? 0, other.last ?? 0)}` : "free";
    return name === best ? `proposed, ${taken}` : name === next ? `else, ${taken}` : taken;
  };
  return knownNames(header, labels).filter((name) => name !== track).map((name) => ({ id: name, words: name, beside: beside(name) })).sort((a, b) => rank(a.id) - rank(b.id));
}

/** Those that somebody should be asked about. */
export const asked = (rows: readonly Proposal[]): Proposal[] => rows.filter((p) => rank(p) < 3);

/** Names that are said of many, at most; chosen. */
const SAID = 4;
/** What becomes of markers without a partner where sides are exchanged; empty where there are none. */
export function keptNames(alone: readonly string[]): string {
  if (!alone.length) return "";
  const said = alone.length > SAID ? `${alone.slice(0, SAID).join(", ")} and ${alone.length - SAID} more` : alone.join(", ");
  return alone.length === 1 ? `${said} has no partner here and keeps its name` : `${said} have no partner here and keep their names`;
}
