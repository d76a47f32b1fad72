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

/** First and last frame that are shown; null: all of them. */
export type Span = readonly [number, number] | null;

/** How much the wheel zooms: e to the power of its px times this; chosen. */
export const WHEEL = 0.0015;

/** Frames that are shown at least; chosen: so that single ones can be told. */
const LEAST_FRAMES = 10;

/** What is shown `by` times as wide, a frame staying where it is; null where that is all of the trial. */
export function zoomed(span: Span, frame: number, by: number, [low, high]: readonly [number, number]): Span {
  const [first, last] = span ?? [low, high], all = high - low, wide = Math.max(Math.min(LEAST_FRAMES, all), Math.round((last - first) * by));
  if (wide >= all) return null;
  const share = last > first ? (Math.min(last, Math.max(first, frame)) - first) / (last - first) : 0.5;
  return moved([0, wide], frame - share * wide, [low, high]);
}

/** What is shown, beginning at another frame, within the trial. */
export function moved([first, last]: readonly [number, number], at: number, [low, high]: readonly [number, number]): readonly [number, number] {
  const wide = last - first, from = Math.min(high - wide, Math.max(low, Math.round(at)));
  return [from, from + wide];
}

/** What is shown once a frame must be: the next page where it has left it, as playing does, else about it. */
export function showing(span: Span, frame: number, all: readonly [number, number]): Span {
  if (!span || (frame >= span[0] && frame <= span[1])) return span;
  const wide = span[1] - span[0], next = frame > span[1] && frame - span[1] < wide;
  return moved(span, next ? frame : frame - wide / 2, all);
}
