/** Joint angles over time, or over cycles, each in a plot of its own: value, band, normal range, frames in gimbal lock. */
import uPlot from "uplot";
import "uplot/dist/uPlot.min.css";
import { palette } from "./palette";

export interface Row {
  joint: number;
  turn: number;
  title: string;
  x: readonly number[];
  y: ArrayLike<number>;
  /** Half the width of the band; and thin lines beside, as single cycles are. */
  band: ArrayLike<number> | null;
  thin: readonly ArrayLike<number>[];
  normal: readonly [number, number] | null;
  locked: readonly (readonly [number, number])[];
}

/** px, of a plot; the last is higher by its axis; chosen: six on a small screen. */
const HEIGHT = 108, AXIS = 20;
type Column = (number | null)[];
const known = (v: number): number | null => (Number.isFinite(v) ? v : null);
const column = (y: ArrayLike<number>): Column => Array.from(y, known);

export class AngleCurves {
  onPoint: (joint: number, turn: number, x: number) => void = () => {};
  private plots: uPlot[] = [];
  private lines: HTMLElement[] = [];
  private rows: readonly Row[] = [];
  private at: number | null = null;
  private wide = 0;
  private readonly watch: ResizeObserver;

  constructor(private readonly element: HTMLElement) {
    this.watch = new ResizeObserver(() => this.element.clientWidth !== this.wide && this.build());
    this.watch.observe(element);
  }

  set(rows: readonly Row[]): void {
    this.rows = rows;
    this.build();
  }

  /** Where the frame is; null where frames mean nothing. */
  show(x: number | null): void {
    this.at = x;
    for (const [i, plot] of this.plots.entries()) {
      const px = x === null ? NaN : plot.valToPos(x, "x"), seen = px >= 0 && px <= plot.over.clientWidth;
      this.lines[i]!.style.visibility = seen ? "visible" : "hidden";
      if (seen) this.lines[i]!.style.transform = `translateX(${px.toFixed(1)}px)`;
    }
  }

  dispose(): void {
    this.watch.disconnect();
    this.clear();
  }

  private clear(): void {
    for (const plot of this.plots) plot.destroy();
    [this.plots, this.lines] = [[], []];
    this.element.replaceChildren();
  }

  private build(): void {
    this.clear();
    this.wide = this.element.clientWidth;
    if (this.wide > 80) this.rows.forEach((row, i) => this.add(row, i === this.rows.length - 1));
    this.show(this.at);
  }

  private add(row: Row, last: boolean): void {
    const p = palette(), data: uPlot.AlignedData = [[...row.x]], series: uPlot.Series[] = [{}], bands: uPlot.Band[] = [], none = { stroke: "transparent", points: { show: false } };
    for (const y of row.thin) data.push(column(y)), series.push({ stroke: p.faint, width: 0.7, points: { show: false } });
    if (row.band) {
      const low = Array.from(row.y, (v, i) => known(v - row.band![i]!)), high = Array.from(row.y, (v, i) => known(v + row.band![i]!)), i = data.length;
      data.push(low, high), series.push(none, none), bands.push({ series: [i + 1, i], fill: `${p.measured}38` });
    }
    data.push(column(row.y)), series.push({ stroke: p.measured, width: 1.6, points: { show: false }, spanGaps: false });
    const axis = { stroke: p.faint, grid: { stroke: p.line, width: 1 }, ticks: { show: false }, font: "10px sans-serif" };
    const box = document.createElement("figure"), words = document.createElement("figcaption");
    words.textContent = row.title;
    box.className = "angle-plot";
    box.dataset.angle = row.title;
    box.append(words);
    this.element.append(box);
    const plot = new uPlot({
      width: this.wide, height: HEIGHT + (last ? AXIS : 0), series, bands, legend: { show: false }, padding: [4, 8, 0, 0], cursor: { drag: { x: false, y: false }, y: false, points: { show: false } },
      scales: { x: { time: false } }, axes: [{ ...axis, show: last, size: AXIS, gap: 2 }, { ...axis, size: 46, gap: 3, label: "deg", labelSize: 12, labelFont: "10px sans-serif" }],
      hooks: { drawClear: [(u): void => ground(u, row, p.good, p.warn)] },
    }, data, box);
    const line = document.createElement("div");
    line.className = "curve-line";
    plot.over.append(line);
    plot.over.addEventListener("click", (e) => this.onPoint(row.joint, row.turn, plot.posToVal(e.offsetX, "x")));
    this.plots.push(plot);
    this.lines.push(line);
  }
}

/** Normal motion between dashed lines, and frames in gimbal lock. */
function ground(u: uPlot, row: Row, normal: string, lock: string): void {
  const { left, top, width, height } = u.bbox, c = u.ctx;
  c.save();
  c.beginPath();
  c.rect(left, top, width, height);
  c.clip();
  if (row.normal) {
    const [a, b] = row.normal.map((v) => u.valToPos(v, "y", true)) as [number, number];
    c.fillStyle = `${normal}14`;
    c.fillRect(left, b, width, a - b);
    c.strokeStyle = normal;
    c.setLineDash([4, 4]);
    for (const y of [a, b]) c.beginPath(), c.moveTo(left, y), c.lineTo(left + width, y), c.stroke();
  }
  c.fillStyle = `${lock}30`;
  for (const [first, last] of row.locked) {
    const x = u.valToPos(first, "x", true);
    c.fillRect(x, top, Math.max(1, u.valToPos(last, "x", true) - x), height);
  }
  c.restore();
}
