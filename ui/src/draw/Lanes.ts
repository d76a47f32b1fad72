/** The whole trial as lanes, a row a marker: measured, filled, edited, missing. Painted once; the playhead moves over it. */
import type { Problem, TrialHeader } from "../api/types";
import { fitting } from "../model/format";
import { withoutSubject } from "../model/names";
import { frameAt, painted, pieces, placeOf, rowOrder } from "../model/lanes";
import { EDITED, FILLED, MEASURED, MISSING, type PathSet } from "../model/paths";
import { byOrigin, fit, palette, type Palette } from "./palette";
import { soon } from "./soon";

/** px: of a row, of the strip of problems and events above. */
const ROW = 9, HEAD = 14;
/** px of the names left of the rows, at least and at most; left of a name. Chosen: the longest of usual names fit. */
const LEAST = 62, MOST = 104, INSET = 4;

/** Opacity of lanes that are not selected; chosen. */
const QUIET = 0.62;

export interface LaneMarks { selected: readonly string[]; first: number | null; last: number | null; problem: string | null }

export class Lanes {
  onFrame: (frame: number) => void = () => {};
  onSelect: (name: string, more: boolean) => void = () => {};
  onStretch: (first: number, last: number) => void = () => {};
  onProblem: (id: string) => void = () => {};
  private readonly canvas = document.createElement("canvas");
  private readonly head = document.createElement("canvas");
  private readonly line = document.createElement("div");
  private readonly scroll = document.createElement("div");
  private readonly watch: ResizeObserver;
  private header: TrialHeader | null = null;
  private paths: PathSet | null = null;
  private problems: readonly Problem[] = [];
  private worth = 0;
  private marks: LaneMarks = { selected: [], first: null, last: null, problem: null };
  private rows: string[] = [];
  /** What is written of each row, and px that the names take. */
  private words = new Map<string, string>();
  private names = LEAST;
  private frame = 1;
  private waiting = 0;
  private hatch: { of: Palette; pattern: CanvasPattern | string } | null = null;

  constructor(private readonly element: HTMLElement) {
    this.scroll.className = "lanes-scroll";
    this.line.className = "lanes-line";
    for (const canvas of [this.head, this.canvas]) canvas.setAttribute("aria-hidden", "true");
    this.scroll.tabIndex = 0;
    this.scroll.setAttribute("aria-label", "Lanes of all markers, scrolls");
    this.scroll.setAttribute("role", "region");
    this.scroll.append(this.canvas);
    element.append(this.head, this.scroll, this.line);
    this.watch = new ResizeObserver(() => ((this.wide = 0), this.later()));
    this.watch.observe(element);
    this.watch.observe(this.scroll); // its bar comes and goes
    this.canvas.addEventListener("pointerdown", this.down);
    this.head.addEventListener("pointerdown", this.down);
  }

  /** `worth`: how many of the problems, from the first, are worth a look. */
  set(header: TrialHeader, paths: PathSet, problems: readonly Problem[], worth: number): void {
    if (header !== this.header || paths !== this.paths) this.order(header, paths);
    Object.assign(this, { header, paths, problems, worth });
    soon(this, () => this.paint());
  }

  /** The rows, and their names as far as there is room for them. */
  private order(header: TrialHeader, paths: PathSet): void {
    const c = this.canvas.getContext("2d")!, whole = new Map<string, string>();
    c.font = font();
    const width = (words: string): number => c.measureText(words).width;
    this.rows = rowOrder(header, paths);
    for (const name of this.rows) whole.set(name, withoutSubject(header, name));
    this.names = Math.ceil(Math.min(MOST, Math.max(LEAST, ...[...whole.values()].map((words) => width(words) + 2 * INSET))));
    this.words = new Map([...whole].map(([name, words]) => [name, fitting(words, this.names - 2 * INSET, width)]));
  }

  mark(marks: LaneMarks): void {
    const moved = marks.selected[0] !== this.marks.selected[0];
    this.marks = marks;
    if (moved && marks.selected[0]) this.reveal(marks.selected[0]);
    soon(this, () => this.paint());
  }

  show(frame: number): void {
    this.frame = frame;
    if (!this.paths) return;
    const x = this.names + placeOf(frame, this.width, this.paths.firstFrame, this.paths.frames);
    this.line.style.transform = `translateX(${x.toFixed(1)}px)`;
  }

  dispose(): void {
    this.watch.disconnect();
    cancelAnimationFrame(this.waiting);
    this.element.replaceChildren();
  }

  /** px of the scrolled part, 0 where it may have changed: asking for it has all of the page laid out before its time. */
  private wide = 0;

  private get width(): number {
    return Math.max(1, (this.wide ||= this.scroll.clientWidth) - this.names);
  }

  private reveal(name: string): void {
    const top = this.rows.indexOf(name) * ROW;
    if (top < this.scroll.scrollTop || top + ROW > this.scroll.scrollTop + this.scroll.clientHeight) this.scroll.scrollTop = Math.max(0, top - 2 * ROW);
  }

  private later(): void {
    if (!this.waiting) this.waiting = requestAnimationFrame(() => ((this.waiting = 0), this.paint()));
  }

  private paint(): void {
    const { paths, header } = this;
    if (!paths || !header) return;
    const p = palette(), width = this.width, whole = width + this.names, height = Math.max(1, this.rows.length * ROW);
    lay(this.canvas, { height });
    lay(this.head, { height: HEAD, width: whole });
    const scale = fit(this.canvas, whole, height), c = this.canvas.getContext("2d")!;
    c.setTransform(scale, 0, 0, scale, 0, 0);
    c.clearRect(0, 0, whole, height);
    c.font = font();
    c.textBaseline = "middle";
    const hatch = (this.hatch = this.hatch?.of === p ? this.hatch : { of: p, pattern: hatching(c, p) }).pattern, some = new Set(this.marks.selected);
    for (const [i, name] of this.rows.entries()) this.row(c, p, hatch, name, i * ROW, width, some.has(name));
    this.stretch(c, p, width, height);
    this.strip(p, width, whole);
    this.show(this.frame);
  }

  private row(c: CanvasRenderingContext2D, p: Palette, hatch: CanvasPattern | string, name: string, y: number, width: number, selected: boolean): void {
    const path = this.paths!.byName.get(name);
    if (!path) return;
    if (selected) (c.fillStyle = p.line), c.fillRect(0, y, this.names + width, ROW);
    c.fillStyle = selected ? p.select : p.faint;
    c.fillText(this.words.get(name) ?? name, INSET, y + ROW / 2 + 0.5);
    const colours = byOrigin(p);
    for (const piece of painted(pieces(path.origin, width))) {
      const x = this.names + piece.x, own = piece.origin;
      c.fillStyle = own === MISSING ? p.view : (colours[own] ?? p.measured);
      c.globalAlpha = own === MEASURED && !selected ? QUIET : 1; // what is as usual stands back
      c.fillRect(x, y + 1, piece.width, ROW - 2);
      c.globalAlpha = 1;
      if (own === MISSING) (c.fillStyle = hatch), c.fillRect(x, y + 1, piece.width, ROW - 2);
      if (own === FILLED) (c.fillStyle = p.view), c.fillRect(x, y + 4, piece.width, 1); // not by colour alone
      if (own === EDITED) (c.fillStyle = p.view), c.fillRect(x, y + 3, piece.width, 1), c.fillRect(x, y + 5, piece.width, 1);
    }
  }

  private stretch(c: CanvasRenderingContext2D, p: Palette, width: number, height: number): void {
    const { first, last } = this.marks, { firstFrame, frames } = this.paths!;
    if (first === null && last === null) return;
    const a = this.names + placeOf(first ?? firstFrame, width, firstFrame, frames), b = this.names + placeOf(last ?? firstFrame + frames - 1, width, firstFrame, frames);
    c.fillStyle = `${p.select}1c`;
    c.fillRect(a, 0, Math.max(1, b - a), height);
    c.fillStyle = p.select;
    c.fillRect(a, 0, 1, height);
    c.fillRect(b, 0, 1, height);
  }

  /** Problems as triangles, events as ticks. */
  private strip(p: Palette, width: number, whole: number): void {
    const { firstFrame, frames } = this.paths!, scale = fit(this.head, whole, HEAD), c = this.head.getContext("2d")!;
    c.setTransform(scale, 0, 0, scale, 0, 0);
    c.clearRect(0, 0, whole, HEAD);
    c.fillStyle = p.faint;
    for (const event of this.header!.events) c.fillRect(this.names + placeOf(1 + event.time_s * this.header!.rate, width, firstFrame, frames), 9, 1, 5);
    for (const [i, problem] of [...this.problems.entries()].reverse()) { // what is worth a look stands over the others
      const x = this.names + placeOf(problem.frame, width, firstFrame, frames), own = problem.id === this.marks.problem;
      c.fillStyle = own ? p.select : i < this.worth ? p.bad : p.faint;
      c.beginPath();
      c.moveTo(x - (own ? 6 : 4), own ? 1 : 3);
      c.lineTo(x + (own ? 6 : 4), own ? 1 : 3);
      c.lineTo(x, 12);
      c.fill();
    }
  }

  private readonly down = (event: PointerEvent): void => {
    if (!this.paths || event.button) return;
    const canvas = event.currentTarget as HTMLCanvasElement, { firstFrame, frames } = this.paths;
    const at = (e: PointerEvent): number => frameAt(e.offsetX - this.names, this.width, firstFrame, frames);
    const from = at(event);
    if (canvas === this.head) {
      const near = this.problems.find((p) => Math.abs(this.names + placeOf(p.frame, this.width, firstFrame, frames) - event.offsetX) < 7);
      if (near) return this.onProblem(near.id);
    } else {
      const name = this.rows[Math.floor(event.offsetY / ROW)];
      if (name) this.onSelect(name, event.ctrlKey || event.metaKey);
      if (event.offsetX < this.names) return;
    }
    canvas.setPointerCapture(event.pointerId);
    if (!event.shiftKey) this.onFrame(from);
    const move = (e: PointerEvent): void => {
      if (e.shiftKey || event.shiftKey) this.onStretch(Math.min(from, at(e)), Math.max(from, at(e)));
      else this.onFrame(at(e));
    };
    canvas.addEventListener("pointermove", move);
    canvas.addEventListener("pointerup", () => canvas.removeEventListener("pointermove", move), { once: true });
  };
}

/** That of the rows' names. */
const font = (): string => `9px ${getComputedStyle(document.body).fontFamily}`;

/** Give an element its size, px, where it has another one: all of the page is laid out anew for it. */
function lay(element: HTMLElement, size: { width?: number; height: number }): void {
  for (const [side, px] of Object.entries(size) as ["width" | "height", number][]) if (element.style[side] !== `${px}px`) element.style[side] = `${px}px`;
}

/** Slanted lines for what is missing, so that it is told by more than its colour. */
function hatching(c: CanvasRenderingContext2D, p: Palette): CanvasPattern | string {
  const tile = document.createElement("canvas");
  tile.width = tile.height = 5;
  const t = tile.getContext("2d")!;
  t.strokeStyle = p.hatch;
  t.lineWidth = 1;
  t.beginPath();
  t.moveTo(0, 5);
  t.lineTo(5, 0);
  t.stroke();
  return c.createPattern(tile, "repeat") ?? p.hatch;
}
