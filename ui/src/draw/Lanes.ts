/** The whole trial as lanes, a row a marker: measured, filled, edited, missing. Painted once; the playhead moves over it. */
import type { Problem, TrialHeader } from "../api/types";
import { fitting } from "../model/format";
import { withoutSubject } from "../model/names";
import { frameAt, moved, painted, pieces, placeOf, rowOrder, showing, WHEEL, zoomed, type Span } from "../model/lanes";
import { EDITED, FILLED, MEASURED, MISSING, type PathSet } from "../model/paths";
import { byOrigin, fit, palette, type Palette } from "./palette";
import { soon } from "./soon";

/** px: of a row, of the strip of problems and events above. */
const ROW = 9, HEAD = 14;
/** px of the names left of the rows, at least and at most; left of a name. Chosen: the longest of usual names fit. */
const LEAST = 62, MOST = 104, INSET = 4;

/** Opacity of lanes that are not selected; chosen. */
const QUIET = 0.62;
/** Steps of the wheel that move what is shown by all its width; chosen. */
const STEPS = 10;

/** px: of the bar above that tells which part is shown. */
const PART = 2;

export interface LaneMarks { selected: readonly string[]; first: number | null; last: number | null; problem: string | null; span: Span }

export class Lanes {
  onFrame: (frame: number) => void = () => {};
  onSelect: (name: string, more: boolean) => void = () => {};
  onStretch: (first: number, last: number) => void = () => {};
  onProblem: (id: string) => void = () => {};
  onSpan: (span: Span) => void = () => {};
  private readonly canvas = document.createElement("canvas");
  private readonly head = document.createElement("canvas");
  private readonly line = document.createElement("div");
  private readonly scroll = document.createElement("div");
  private readonly watch: ResizeObserver;
  private header: TrialHeader | null = null;
  private paths: PathSet | null = null;
  private problems: readonly Problem[] = [];
  private worth = 0;
  private marks: LaneMarks = { selected: [], first: null, last: null, problem: null, span: null };
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
    element.addEventListener("wheel", this.wheel, { passive: false });
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
    const went = frame !== this.frame, { span } = this.marks;
    this.frame = frame;
    if (!this.paths) return;
    const now = went ? showing(span, frame, this.all) : span; // who zooms or moves along may leave the frame
    if (now !== span) this.onSpan(now);
    const x = this.x(frame);
    this.line.style.visibility = this.inside(x) ? "visible" : "hidden";
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

  /** First and last frame of the trial. */
  private get all(): readonly [number, number] {
    const { firstFrame, frames } = this.paths!;
    return [firstFrame, firstFrame + frames - 1];
  }

  /** First frame that is shown, and how many are. */
  private get shown(): readonly [number, number] {
    const [first, last] = this.marks.span ?? this.all;
    return [first, last - first + 1];
  }

  /** px of the middle of a frame. */
  private x(frame: number): number {
    return this.names + placeOf(frame, this.width, ...this.shown);
  }

  private inside(x: number): boolean {
    return x >= this.names && x <= this.names + this.width;
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
    const colours = byOrigin(p), [first, frames] = this.shown, from = first - this.paths!.firstFrame;
    for (const piece of painted(pieces(path.origin.subarray(from, from + frames), width))) {
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
    const { first, last } = this.marks, [low, high] = this.all;
    if (first === null && last === null) return;
    const within = (x: number): number => Math.min(this.names + width, Math.max(this.names, x)), a = within(this.x(first ?? low)), b = within(this.x(last ?? high));
    c.fillStyle = `${p.select}1c`;
    c.fillRect(a, 0, Math.max(1, b - a), height);
    c.fillStyle = p.select;
    c.fillRect(a, 0, 1, height);
    c.fillRect(b, 0, 1, height);
  }

  /** Problems as triangles, events as ticks. */
  private strip(p: Palette, width: number, whole: number): void {
    const scale = fit(this.head, whole, HEAD), c = this.head.getContext("2d")!;
    c.setTransform(scale, 0, 0, scale, 0, 0);
    c.clearRect(0, 0, whole, HEAD);
    c.fillStyle = p.faint;
    for (const event of this.header!.events) {
      const x = this.x(1 + event.time_s * this.header!.rate);
      if (this.inside(x)) c.fillRect(x, 9, 1, 5);
    }
    if (this.marks.span) this.part(c, p, width);
    for (const [i, problem] of [...this.problems.entries()].reverse()) { // what is worth a look stands over the others
      const x = this.x(problem.frame), own = problem.id === this.marks.problem;
      if (!this.inside(x)) continue;
      c.fillStyle = own ? p.select : i < this.worth ? p.bad : p.faint;
      c.beginPath();
      c.moveTo(x - (own ? 6 : 4), own ? 1 : 3);
      c.lineTo(x + (own ? 6 : 4), own ? 1 : 3);
      c.lineTo(x, 12);
      c.fill();
    }
  }

  /** Which part of the trial is shown. */
  private part(c: CanvasRenderingContext2D, p: Palette, width: number): void {
    const [low, high] = this.all, [first, frames] = this.shown, scale = width / (high - low + 1);
    c.fillStyle = p.line;
    c.fillRect(this.names, 0, width, PART);
    c.fillStyle = p.select;
    c.fillRect(this.names + (first - low) * scale, 0, Math.max(PART, frames * scale), PART);
    c.fillStyle = p.faint;
  }

  /** Over the strip, with Ctrl, or where no rows are hidden, the wheel zooms; sideways it moves; else rows scroll. */
  private readonly wheel = (event: WheelEvent): void => {
    if (!this.paths) return;
    const { span } = this.marks, aside = event.shiftKey || Math.abs(event.deltaX) > Math.abs(event.deltaY);
    const all = this.scroll.scrollHeight <= this.scroll.clientHeight, zooms = event.ctrlKey || event.metaKey || event.target === this.head || all;
    if (!aside && !zooms) return;
    event.preventDefault();
    const [first, frames] = this.shown, by = event.deltaY || event.deltaX;
    if (!aside) this.onSpan(zoomed(span, frameAt(event.clientX - this.element.getBoundingClientRect().left - this.names, this.width, first, frames), Math.exp(by * WHEEL), this.all));
    else if (span) this.onSpan(moved(span, first + Math.sign(event.deltaX || by) * Math.max(1, frames / STEPS), this.all));
  };

  private readonly down = (event: PointerEvent): void => {
    if (!this.paths || event.button) return;
    const canvas = event.currentTarget as HTMLCanvasElement;
    const at = (e: PointerEvent): number => frameAt(e.offsetX - this.names, this.width, ...this.shown);
    const from = at(event);
    if (canvas === this.head) {
      const near = this.problems.find((p) => Math.abs(this.x(p.frame) - event.offsetX) < 7);
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
