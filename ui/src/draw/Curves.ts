/** X, Y, Z and speed over time with their 95 % bands. `set` what is drawn, `show` a frame, `dispose`. */
import uPlot from "uplot";
import "uplot/dist/uPlot.min.css";
import { count } from "../model/format";
import { WHEEL } from "../model/lanes";
import { hasSd, speed, type Path } from "../model/paths";
import { palette, type Palette } from "./palette";
import { soon } from "./soon";

/** A path in a colour; dashed where it is a possibility. `at` is its first frame where it is only a piece. */
export interface Curve { path: Path; colour: string; dashed?: boolean; band?: boolean; at?: number }

export interface CurveView {
  curves: readonly Curve[];
  /** First frame of the paths, Hz. */
  firstFrame: number;
  rate: number;
  /** Frames that are shown. */
  window: readonly [number, number];
  marked: readonly [number | null, number | null];
  bands: boolean;
  /** Below the places. */
  fourth: "speed" | "residual";
}

/** Standard deviations of a band that holds 95 % on one axis. */
const BAND = 1.96;
/** px: widths of a curve and of a dashed one; and of one with more frames than the plot has px, as then most of a wide line is
 * joins of pieces below a pixel: 2760 points took 5.9 ms to draw at 1.4 px, 0.2 ms at 1 px. Chosen. */
const WIDE = 1.4, DASHED = 1.6, DENSE = 1;
/** px, of a sample with none beside it, of which a line draws nothing. */
const DOT = 5;
/** Frames between two marks of the axis. */
const STEPS = [1, 10, 100, 1000, 10_000, 100_000].flatMap((n) => [n, 2 * n, 5 * n]);
const TITLES = ["X mm", "Y mm", "Z mm"] as const;

export class Curves {
  onFrame: (frame: number) => void = () => {};
  onStretch: (first: number, last: number) => void = () => {};
  /** So many times as many frames about one. */
  onZoom: (frame: number, by: number) => void = () => {};
  private plots: uPlot[] = [];
  /** What the plots were made for: others than their values. */
  private made = "";
  private readonly lines: HTMLElement[] = [];
  private view: CurveView | null = null;
  private frame = 0;
  private readonly watch: ResizeObserver;
  private waiting = 0;
  /** px, null where it may have changed: asking for it has all of the page laid out before its time. */
  private size: readonly [number, number] | null = null;

  constructor(private readonly element: HTMLElement) {
    this.watch = new ResizeObserver(() => ((this.size = null), this.later()));
    this.watch.observe(element);
  }

  set(view: CurveView): void {
    this.view = view;
    soon(this, () => this.build());
  }

  show(frame: number): void {
    this.frame = frame;
    for (const [i, plot] of this.plots.entries()) {
      const x = plot.valToPos(frame, "x"), line = this.lines[i]!;
      const hidden = !(x >= 0 && x <= plot.over.clientWidth);
      line.style.visibility = hidden ? "hidden" : "visible";
      if (!hidden) line.style.transform = `translateX(${x.toFixed(1)}px)`;
    }
  }

  dispose(): void {
    this.watch.disconnect();
    cancelAnimationFrame(this.waiting);
    this.clear();
  }

  private later(): void {
    if (!this.waiting) this.waiting = requestAnimationFrame(() => ((this.waiting = 0), this.build()));
  }

  private frames: number[] = [];

  /** The frames of a window, made once for it. */
  private framesOf([first, last]: readonly [number, number]): number[] {
    const { frames } = this;
    if (frames[0] !== first || frames.at(-1) !== last) this.frames = Array.from({ length: last - first + 1 }, (_, i) => first + i);
    return this.frames;
  }

  private clear(): void {
    for (const plot of this.plots) plot.destroy();
    this.plots = [];
    this.lines.length = 0;
    this.made = "";
    this.element.replaceChildren();
  }

  private build(): void {
    const view = this.view, [width, height] = (this.size ??= [this.element.clientWidth, this.element.clientHeight]);
    if (!view || !view.curves.length || width < 80 || height < 60) return this.clear();
    const p = palette(), each = Math.floor(height / 4), frames = this.framesOf(view.window);
    const made = JSON.stringify([width, height, p, view.window, view.bands, view.fourth, view.marked, view.curves.map((curve) => [curve.colour, curve.dashed, banded(curve, view, 0)])]);
    if (made !== this.made) {
      this.clear();
      for (let k = 0; k < 4; k++) this.add(view, p, frames, k, width, k === 3 ? height - 3 * each : each);
      this.made = made;
    } else for (const [k, plot] of this.plots.entries()) plot.setData(dataOf(view, frames, k)); // an edit changes values alone
    this.show(this.frame);
  }

  private add(view: CurveView, p: Palette, frames: number[], k: number, width: number, height: number): void {
    const series: uPlot.Series[] = [{}], bands: uPlot.Band[] = [], wide = frames.length > width ? DENSE : WIDE;
    for (const curve of view.curves) {
      if (banded(curve, view, k)) {
        const i = series.length;
        series.push({ stroke: "transparent", width: 0, points: { show: false } }, { stroke: "transparent", width: 0, points: { show: false } });
        bands.push({ series: [i + 1, i], fill: `${curve.colour}30` });
      }
      series.push({ stroke: curve.colour, width: curve.dashed ? DASHED : wide, dash: curve.dashed ? [5, 4] : undefined, points: { show: false, size: DOT, fill: curve.colour, filter: (u, i) => alone(u.data[i]!) }, spanGaps: false, pxAlign: 0 });
    }
    const title = k < 3 ? TITLES[k]! : view.fourth === "speed" ? "speed m/s" : "residual mm";
    const axis = { stroke: p.faint, grid: { stroke: p.line, width: 1 }, ticks: { show: false }, font: "10px sans-serif" };
    const plot = new uPlot(
      {
        width, height, series, bands, legend: { show: false }, padding: [6, 16, k === 3 ? 0 : 6, 0],
        cursor: { drag: { x: false, y: false }, y: false, points: { show: false } },
        scales: { x: { time: false, range: [view.window[0], Math.max(view.window[1], view.window[0] + 1)] }, y: { range: lastingRange() } },
        axes: [{ ...axis, show: k === 3, size: 20, gap: 2, incrs: STEPS, values: (_, at) => at.map(String) }, { ...axis, size: 50, gap: 3, values: (_, at) => at.map(axisMark), label: title, labelSize: 14, labelFont: "10px sans-serif", space: 22 }],
        hooks: { drawClear: [(u): void => shade(u, view.marked, p)] },
      },
      dataOf(view, frames, k), this.element,
    );
    const line = document.createElement("div");
    line.className = "curve-line";
    plot.over.append(line);
    plot.over.addEventListener("pointerdown", (e) => this.down(e, plot));
    plot.over.addEventListener("wheel", (e) => this.wheel(e, plot), { passive: false });
    this.plots.push(plot);
    this.lines.push(line);
  }

  private down(event: PointerEvent, plot: uPlot): void {
    const over = plot.over, left = over.getBoundingClientRect().left;
    const at = (e: PointerEvent): number => Math.round(plot.posToVal(e.clientX - left, "x"));
    const from = at(event);
    over.setPointerCapture(event.pointerId);
    if (!event.shiftKey) this.onFrame(from);
    const move = (e: PointerEvent): void => {
      if (event.shiftKey) this.onStretch(Math.min(from, at(e)), Math.max(from, at(e)));
      else this.onFrame(at(e));
    };
    over.addEventListener("pointermove", move);
    over.addEventListener("pointerup", () => over.removeEventListener("pointermove", move), { once: true });
  }

  private wheel(event: WheelEvent, plot: uPlot): void {
    event.preventDefault();
    const middle = plot.posToVal(event.offsetX, "x"), by = Math.exp(event.deltaY * WHEEL);
    this.onZoom(middle, by);
  }
}

/** A number at an axis, as numbers are written everywhere else. */
const axisMark = (n: number): string => count(Number(n.toFixed(6)));

type Column = (number | null)[];

/** The range of an axis by its values; where there are none, as it was: an axis that goes and comes has all laid out anew. */
function lastingRange(): uPlot.Range.Function {
  let last: uPlot.Range.MinMax = [null, null];
  return (_, low, high) => (low == null || high == null ? last : (last = uPlot.rangeNum(low, high, 0.1, true)));
}

/** Whether a curve has its 95 % band in a plot. */
const banded = (curve: Curve, view: CurveView, k: number): boolean => k < 3 && view.bands && curve.band !== false && hasSd(curve.path);

/** The places of values with none on either side, of which a line draws nothing; null where there are none. */
export function alone(values: ArrayLike<number | null | undefined>): number[] | null {
  const found: number[] = [];
  for (let i = 0; i < values.length; i++) if (values[i] != null && values[i - 1] == null && values[i + 1] == null) found.push(i);
  return found.length ? found : null;
}

/** The columns of a plot, in the order of its series. */
function dataOf(view: CurveView, frames: number[], k: number): uPlot.AlignedData {
  const data: uPlot.AlignedData = [frames];
  for (const curve of view.curves) {
    const { values, low, high } = columns(curve, view, k);
    if (low && high) data.push(low, high);
    data.push(values);
  }
  return data;
}

/** What one plot shows of a path: axis k, or the fourth. */
function columns(curve: Curve, view: CurveView, k: number): { values: Column; low?: Column; high?: Column } {
  const { path, at } = curve;
  const start = at ?? view.firstFrame, n = view.window[1] - view.window[0] + 1, values: Column = new Array<number | null>(n);
  const from = k < 3 ? path.xyz : view.fourth === "speed" ? speed(path, view.rate) : path.residual, [step, first, by] = k < 3 ? [3, k, 1] : [1, 0, view.fourth === "speed" ? 1000 : 1];
  for (let f = view.window[0], j = 0; f <= view.window[1]; f++, j++) {
    const i = f - start, value = path.origin[i] ? (from?.[step * i + first] ?? NaN) / by : NaN; // none before the first or behind the last
    values[j] = Number.isFinite(value) ? value : null;
  }
  return banded(curve, view, k) ? { values, ...bandOf(curve, view, k, values) } : { values };
}

/** Where 95 % lie about the values of axis k. */
function bandOf({ path, at }: Curve, view: CurveView, k: number, values: Column): { low: Column; high: Column } {
  const start = at ?? view.firstFrame, diagonal = [0, 3, 5][k]!;
  const off = values.map((value, j) => {
    const i = view.window[0] + j - start, sd = path.cov ? Math.sqrt(path.cov[6 * i + diagonal]!) : path.sd[i]!;
    return value !== null && sd > 0 ? BAND * sd : null;
  });
  return { low: values.map((value, j) => (off[j] === null ? null : value! - off[j]!)), high: values.map((value, j) => (off[j] === null ? null : value! + off[j]!)) };
}

/** The marked stretch behind the curves. */
function shade(u: uPlot, [first, last]: CurveView["marked"], p: Palette): void {
  if (first === null && last === null) return;
  const { left, top, width, height } = u.bbox;
  const clamp = (x: number): number => Math.min(left + width, Math.max(left, x));
  const a = first === null ? left : clamp(u.valToPos(first, "x", true)), b = last === null ? left + width : clamp(u.valToPos(last, "x", true));
  u.ctx.fillStyle = `${p.select}12`;
  u.ctx.fillRect(a, top, Math.max(1, b - a), height);
}
