/** The table of gaps: which row is which gap, and the order in which they are shown and gone through. */
import type { GapRow } from "../api/types";

/** By which the table is ordered; as the server gives it, by marker and frame as the file has them, where null. */
export type GapColumn = "marker" | "frames" | "expected";
export interface GapOrder { by: GapColumn; down: boolean }

/** Whether two rows are of one gap: rows are made anew with each answer. */
export const sameGap = (a: GapRow, b: GapRow): boolean => a.marker === b.marker && a.first === b.first;

const WORTH: Record<GapColumn, (a: GapRow, b: GapRow) => number> = {
  marker: (a, b) => a.marker.localeCompare(b.marker, undefined, { numeric: true }),
  frames: (a, b) => a.frames - b.frames,
  expected: (a, b) => a.expected_mm! - b.expected_mm!,
};

/** The rows as the table shows them. What nobody can say an error of comes last, whichever way it is ordered. */
export function inTable(rows: readonly GapRow[], order: GapOrder | null): readonly GapRow[] {
  if (!order) return rows;
  const known = (g: GapRow): boolean => order.by !== "expected" || g.expected_mm != null;
  const way = order.down ? -1 : 1, compare = WORTH[order.by];
  return [...rows.filter(known).sort((a, b) => way * compare(a, b)), ...rows.filter((g) => !known(g))];
}

/** What a click on the title of a column makes of the order: by numbers the greatest first, then the other way, then as it was. */
export function nextOrder(order: GapOrder | null, by: GapColumn): GapOrder | null {
  const first = by !== "marker";
  if (order?.by !== by) return { by, down: first };
  return order.down === first ? { by, down: !first } : null;
}

/** The row after or before the one that is looked at, in a ring; the first or last where none is. */
export function stepGap(rows: readonly GapRow[], current: GapRow | null, step: 1 | -1): GapRow | undefined {
  const at = current ? rows.findIndex((g) => sameGap(g, current)) : -1;
  return rows[at < 0 ? (step > 0 ? 0 : rows.length - 1) : (at + step + rows.length) % rows.length];
}
