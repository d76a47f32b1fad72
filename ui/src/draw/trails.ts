/** Pieces of paths before and after the frame that is shown, in one buffer of lines that is written anew each frame. */
import { BufferAttribute, BufferGeometry, Color, DynamicDrawUsage, LineBasicMaterial, LineSegments, SRGBColorSpace } from "three";
import type { Path } from "../model/paths";
import { byOrigin, rgb, type Palette } from "./palette";

/** A path that is drawn, in its own colour where it has one, else by origin; dashed where it is a possibility. */
export interface Trail { path: Path; colour?: string; dashed?: boolean; strong?: boolean }

/** Frames of a dash, and of the dash with the space behind it; chosen. */
const DASH = 3, PERIOD = 6;

/** Light of a value from 0 to 1 of the screen's, as buffers of colours have it: else a trail would fade to white. Looked up,
 * as it is asked for 20 000 times a picture. */
const FINE = 1024, LIGHT = Float32Array.from({ length: FINE + 1 }, (_, i) => new Color().setRGB(i / FINE, 0, 0, SRGBColorSpace).r);

export class Trails {
  readonly lines: LineSegments;
  private place = new Float32Array(0);
  private colour = new Float32Array(0);
  private readonly geometry = new BufferGeometry();
  private readonly material = new LineBasicMaterial({ vertexColors: true });

  constructor() {
    this.lines = new LineSegments(this.geometry, this.material);
    this.lines.frustumCulled = false;
  }

  dispose(): void {
    this.geometry.dispose();
    this.material.dispose();
  }

  /** Lines of all trails from index − back to index + ahead; they fade towards the view's colour. */
  show(trails: readonly Trail[], index: number, back: number, ahead: number, palette: Palette): void {
    this.room(trails.length * (back + ahead));
    const ground = rgb(palette.view), origins = byOrigin(palette).map(rgb);
    let k = 0;
    for (const { path, colour, dashed, strong } of trails) {
      const own = colour ? rgb(colour) : null, { xyz, origin } = path, n = origin.length;
      const from = Math.max(1, index - back + 1), to = Math.min(n - 1, index + ahead);
      for (let i = from; i <= to; i++) {
        if (!origin[i] || !origin[i - 1] || (dashed && i % PERIOD >= DASH)) continue;
        const far = i > index ? (i - index) / (ahead + 1) : (index - i) / (back + 1);
        const fade = (i > index ? 0.35 : 1) * (strong ? 1 - 0.4 * far : 0.75 * (1 - far));
        const c = own ?? origins[origin[i]!]!, at = 6 * k++;
        for (let j = 0; j < 6; j++) this.place[at + j] = xyz[3 * i - 3 + j]!;
        for (let j = 0; j < 3; j++) this.colour[at + j] = this.colour[at + 3 + j] = LIGHT[Math.round(FINE * (ground[j]! + fade * (c[j]! - ground[j]!)))]!;
      }
    }
    this.geometry.setDrawRange(0, 2 * k);
    for (const name of ["position", "color"] as const) {
      const attribute = this.geometry.getAttribute(name) as BufferAttribute;
      attribute.clearUpdateRanges();
      attribute.addUpdateRange(0, 6 * k);
      attribute.needsUpdate = true;
    }
  }

  private room(segments: number): void {
    if (6 * segments <= this.place.length && this.place.length) return;
    const size = 6 * Math.max(segments, 64);
    this.place = new Float32Array(size);
    this.colour = new Float32Array(size);
    this.geometry.setAttribute("position", new BufferAttribute(this.place, 3).setUsage(DynamicDrawUsage));
    this.geometry.setAttribute("color", new BufferAttribute(this.colour, 3).setUsage(DynamicDrawUsage));
  }
}
