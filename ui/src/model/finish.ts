/** Where a trial is cut when it is finished. */
import type { GapRow, TrialHeader } from "../api/types";

/** A marked stretch: null where it goes on to the end. */
type Marked = readonly [number | null, number | null];

/** First and last frame of each named marker that is seen. */
export const ends = (header: TrialHeader | null): { name: string; first: number; last: number }[] =>
  (header?.tracks ?? []).flatMap((t) => (t.named && !t.computed && t.first != null && t.last != null ? [{ name: t.name, first: t.first, last: t.last }] : []));

/** The stretch that a person marked; that of a gap marks itself when it is looked at, and is none. */
export const marked = (first: number | null, last: number | null, gap: GapRow | null): Marked => (gap && gap.first === first && gap.last === last ? [null, null] : [first, last]);

/** Where the trial begins and ends: the marked stretch, else what all markers have, else all of it. */
export function usual(header: TrialHeader, own: Marked): [number, number] {
  const all = ends(header), whole: [number, number] = [header.first_frame, header.first_frame + header.n_frames - 1];
  const first = Math.max(...all.map((t) => t.first)), last = Math.min(...all.map((t) => t.last));
  const [a, b] = all.length && first <= last ? [first, last] : whole;
  return [own[0] ?? a, own[1] ?? b];
}
