/** Names beside markers in a picture, none over another. */

/** px from a marker to its name, right and left of it; of the name's line above and below it; chosen. */
const ASIDE = 9, ABOVE = -7, BELOW = 16;
/** px: height of a line, and what is kept free beside a name; chosen. */
const LINE = 13, FREE = 3;
/** Lines above and below a marker in which a name that must be read may stand; chosen: markers that lie in one another. */
const LINES = 4;
/** Paths that would be whose names are written, at most; of more the rings alone are drawn. Chosen: what can be read. */
export const MOST_NAMED = 8;
/** What is written beside a path that would be; a piece that would have no name has one of the program's own, which says nothing to people. */
export const wouldBe = (name: string): string => (/^track\d+(_\d+)*$/.test(name) ? "B" : `B ${name}`);
/** Widths of names, measured once. */
const WIDTHS = new Map<string, number>();

export class Names {
  private readonly taken: [number, number, number][] = [];

  constructor(private readonly c: CanvasRenderingContext2D, private readonly ground: string) {}

  /** Beside a marker where nothing is written yet; what must be read is written in any case, other names are left out. */
  write(what: string, [x, y]: readonly [number, number], colour: string, must = false): void {
    const width = this.width(what), right = x + ASIDE, left = x - ASIDE - width;
    const places: [number, number][] = [[right, y + ABOVE]];
    for (let line = 0; must && line < LINES; line++) for (const at of [y + ABOVE - line * LINE, y + BELOW + line * LINE]) places.push([right, at], [left, at]);
    const at = places.find((place) => this.free(place, width)) ?? (must ? places[0]! : null);
    if (!at) return;
    this.taken.push([at[0], at[1], width]);
    this.c.lineWidth = 3;
    this.c.strokeStyle = this.ground;
    this.c.strokeText(what, ...at);
    this.c.fillStyle = colour;
    this.c.fillText(what, ...at);
  }

  private width(what: string): number {
    let width = WIDTHS.get(what);
    if (width === undefined) WIDTHS.set(what, (width = this.c.measureText(what).width));
    return width;
  }

  private free([x, y]: [number, number], width: number): boolean {
    return !this.taken.some(([a, b, w]) => Math.abs(y - b) < LINE && x < a + w + FREE && a < x + width + FREE);
  }
}
