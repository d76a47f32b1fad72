/** Lanes of a whole trial: which pixels of a row each piece of a path takes. */
import type { TrialHeader } from "../api/types";
import { computedNames, runs, type PathSet } from "./paths";

/** A piece of a lane, px from the left; `wide` frames. */
export interface Piece { x: number; width: number; origin: number }

/** The pieces of a path over so many pixels; short ones are at least 1 px wide, so that no gap is overlooked. */
export function pieces(origin: Uint8Array, width: number): Piece[] {
  const scale = width / Math.max(1, origin.length);
  return runs(origin).map(({ start, end, origin: of }) => {
    const x = start * scale;
    return { x, width: Math.max((end - start) * scale, 1), origin: of };
  });
}

/** Long pieces first, so that short ones are painted over them. */
export const painted = (all: readonly Piece[]): Piece[] => [...all].sort((a, b) => b.width - a.width);

/** The rows in their order: markers of the set as it has them, other names, tracks without a name, points that are no markers, then what a file has a name for and no sample of. */
export function rowOrder(header: TrialHeader, paths: PathSet): string[] {
  const places = new Map(header.marker_set?.names.map((name, i) => [name, i]));
  const away = new Set(computedNames(header)), empty = new Set(header.tracks.filter((track) => !track.samples).map((track) => track.name));
  const of = (name: string): number => places.get(name) ?? (empty.has(name) ? 4e6 : away.has(name) ? 3e6 : name.startsWith("*") ? 2e6 : 1e6);
  const index = new Map(header.tracks.map((track, i) => [track.name, i]));
  return [...paths.byName.keys()].sort((a, b) => of(a) - of(b) || (index.get(a) ?? 0) - (index.get(b) ?? 0));
}

/** The frame at a place in px. */
export const frameAt = (x: number, width: number, first: number, frames: number): number =>
  first + Math.min(frames - 1, Math.max(0, Math.floor((x / Math.max(1, width)) * frames)));

/** The place in px of the middle of a frame. */
export const placeOf = (frame: number, width: number, first: number, frames: number): number =>
  ((frame - first + 0.5) / Math.max(1, frames)) * width;
