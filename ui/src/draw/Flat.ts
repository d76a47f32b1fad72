/** Lines and dots in space on a plain canvas, turned with the mouse: for what is small and needs no graphics card. */
import { PerspectiveCamera, Vector3 } from "three";
import { Orbit } from "./orbit";
import { fit, palette, type Palette } from "./palette";
import { uprightOf } from "./room";

export type Place = readonly [number, number, number];
export interface Line { a: Place; b: Place; colour: string; width?: number }
export interface Dot { at: Place; colour: string; size: number; words?: string }

export class Flat {
  readonly orbit: Orbit;
  private readonly camera = new PerspectiveCamera(35, 1, 10, 60000);
  private readonly spot = new Vector3();
  private lines: readonly Line[] = [];
  private dots: readonly Dot[] = [];
  private waiting = 0;
  private readonly watch: ResizeObserver;

  constructor(private readonly canvas: HTMLCanvasElement) {
    this.orbit = new Orbit(this.camera, canvas, () => this.draw(), () => {});
    this.watch = new ResizeObserver(() => this.draw());
    this.watch.observe(canvas);
  }

  show(lines: readonly Line[], dots: readonly Dot[]): void {
    [this.lines, this.dots] = [lines, dots];
    this.draw();
  }

  /** Look at all between two corners, with this axis of the world up. */
  frame(low: Place, high: Place, up: Place = [0, 0, 1]): void {
    this.orbit.upright.copy(uprightOf(up));
    const size = Math.hypot(high[0] - low[0], high[1] - low[1], high[2] - low[2]) || 1000;
    this.orbit.look((low[0] + high[0]) / 2, (low[1] + high[1]) / 2, (low[2] + high[2]) / 2, size * 1.35);
  }

  dispose(): void {
    cancelAnimationFrame(this.waiting);
    this.watch.disconnect();
    this.orbit.dispose();
  }

  draw(): void {
    if (!this.waiting) this.waiting = requestAnimationFrame(() => ((this.waiting = 0), this.paint(palette())));
  }

  private at(place: Place): [number, number, number] | null {
    this.spot.set(...(place as [number, number, number]));
    const deep = this.spot.distanceTo(this.camera.position);
    this.spot.project(this.camera);
    if (!(this.spot.z < 1)) return null;
    return [((this.spot.x + 1) / 2) * this.canvas.clientWidth, ((1 - this.spot.y) / 2) * this.canvas.clientHeight, deep];
  }

  private paint(p: Palette): void {
    const width = this.canvas.clientWidth, height = this.canvas.clientHeight, scale = fit(this.canvas, width, height), c = this.canvas.getContext("2d")!;
    this.camera.aspect = width / Math.max(1, height);
    this.orbit.place();
    c.setTransform(scale, 0, 0, scale, 0, 0);
    c.fillStyle = p.view;
    c.fillRect(0, 0, width, height);
    for (const { a, b, colour, width: w } of this.lines) {
      const from = this.at(a), to = this.at(b);
      if (!from || !to) continue;
      c.strokeStyle = colour;
      c.lineWidth = w ?? 1;
      c.beginPath();
      c.moveTo(from[0], from[1]);
      c.lineTo(to[0], to[1]);
      c.stroke();
    }
    const seen = this.dots.flatMap((dot) => { const at = this.at(dot.at); return at ? [{ dot, at }] : []; }).sort((x, y) => y.at[2] - x.at[2]);
    c.font = "12px sans-serif";
    for (const { dot, at } of seen) {
      c.fillStyle = dot.colour;
      c.beginPath();
      c.arc(at[0], at[1], dot.size, 0, 7);
      c.fill();
      if (!dot.words) continue;
      c.lineWidth = 3;
      c.strokeStyle = p.view;
      c.strokeText(dot.words, at[0] + 8, at[1] - 6);
      c.fillStyle = p.ink;
      c.fillText(dot.words, at[0] + 8, at[1] - 6);
    }
  }
}
