/** The trial in three dimensions. `set` a trial, `show` a frame, `dispose`. One WebGL context; nothing of React. */
import {
  Color, Mesh, MeshBasicMaterial, PerspectiveCamera, Scene as Graph, SphereGeometry, Vector3, WebGLRenderer,
  BufferGeometry, Float32BufferAttribute, LineBasicMaterial, LineSegments, type Group,
} from "three";
import type { TrialHeader } from "../api/types";
import { withoutSubject } from "../model/names";
import { nearestSample, type Path, type PathSet } from "../model/paths";
import { MOST_NAMED, Names, wouldBe } from "./names";
import { Orbit, type Side } from "./orbit";
import { byOrigin, fit, palette, SANS, type Palette } from "./palette";
import { Balls } from "./balls";
import { clear, room, standing, uprightOf } from "./room";
import { soon } from "./soon";
import { Trails, type Trail } from "./trails";

/** What is shown besides the markers. */
export interface Shown {
  selected: readonly string[];
  alone: boolean;
  ellipsoids: boolean;
  /** What the proposal would give, drawn beside what is. */
  instead: readonly Path[];
}

/** √ of the 95 % point of χ² with three degrees of freedom; and how much larger an ellipsoid is drawn, which is said. */
export const ELLIPSOID = 2.7955, LARGER = 10;
/** px about a marker in which a click means it; chosen. */
const NEAR_PX = 12;
/** s of trail before and after the frame; chosen. */
const BACK_S = 0.8, AHEAD_S = 0.4;
/** mm from which a trial is seen at most at first, and share of the picture that holds it; chosen: names stand beside. */
const FARTHEST_MM = 12000, WITHIN = 0.88;

/** mm from which two markers are looked at, and how many times as far as they are from their middle, so that all are seen; chosen. */
const NEAR_MM = 1300, WIDE = 3.6;

export class Scene {
  readonly orbit: Orbit;
  onPick: (name: string | null, more: boolean) => void = () => {};
  private readonly graph = new Graph();
  private readonly camera = new PerspectiveCamera(35, 1, 10, 60000);
  private readonly renderer: WebGLRenderer;
  private readonly trails = new Trails();
  private readonly balls = new Balls(this.graph);
  private readonly cloud: Mesh;
  private readonly bones = new LineSegments(new BufferGeometry(), new LineBasicMaterial());
  private still: Group | null = null;
  private header: TrialHeader | null = null;
  private paths: PathSet | null = null;
  private links: [Path, Path][] = [];
  private shown: Shown = { selected: [], alone: false, ellipsoids: true, instead: [] };
  private colours: Palette = palette();
  private framed = "";
  private made = "";
  /** The frame that was drawn before its picture of the screen, null where anything changed since. */
  private ahead: number | null = null;
  private readonly spot = new Vector3();

  constructor(private readonly canvas: HTMLCanvasElement, private readonly over: HTMLCanvasElement, private readonly ask: () => void) {
    const smooth = new URLSearchParams(location.search).get("aa") !== "0";
    this.renderer = new WebGLRenderer({ canvas, antialias: smooth, powerPreference: "high-performance", preserveDrawingBuffer: !smooth });
    this.cloud = new Mesh(new SphereGeometry(1, 20, 14), new MeshBasicMaterial({ wireframe: true, transparent: true, opacity: 0.55 }));
    this.cloud.matrixAutoUpdate = false;
    this.bones.frustumCulled = false;
    this.graph.add(this.trails.lines, this.bones, this.cloud);
    this.orbit = new Orbit(this.camera, over, this.redraw, (x, y, more) => this.onPick(this.pick(x, y), more));
  }

  /** Another trial, or the same with other paths. */
  set(header: TrialHeader, paths: PathSet): void {
    this.header = header;
    this.paths = paths;
    this.furnish(header, paths);
    const pairs = (header.marker_set?.links ?? []).map(({ a, b }) => [paths.byName.get(a), paths.byName.get(b)]);
    this.links = pairs.filter((pair): pair is [Path, Path] => !!pair[0] && !!pair[1]);
    (this.bones.material as LineBasicMaterial).color.set(this.colours.faint);
    this.bones.geometry.setAttribute("position", new Float32BufferAttribute(new Float32Array(6 * Math.max(1, this.links.length)), 3));
    this.redraw();
    if (this.last >= 0) soon(this, () => this.drawAhead());
  }

  /** Draw at once what an edit gave: the graphics process then draws while curves and lanes are drawn here. */
  private drawAhead(): void {
    const frame = this.last + this.paths!.firstFrame;
    this.show(frame);
    const gl = this.renderer.getContext() as WebGL2RenderingContext;
    gl.deleteSync(gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0)); // else they are kept back until the picture is asked for
    gl.flush();
    this.ahead = frame;
  }

  private readonly redraw = (): void => {
    this.ahead = null;
    this.ask();
  };

  /** The room of a trial: made for its paths as they are first seen, and anew in other colours; an edit leaves it as it stands. */
  private furnish(header: TrialHeader, paths: PathSet): void {
    const colours = palette(), made = [header.id, ...Object.values(colours)].join(" ");
    if (this.made === made) return;
    const [low, high] = reach(paths);
    this.made = made;
    this.colours = colours;
    this.orbit.upright.copy(uprightOf(header.up));
    this.graph.background = new Color(colours.view);
    if (this.still) this.graph.remove(this.still), clear(this.still);
    this.graph.add((this.still = room(header, low, high, colours)));
    if (this.framed !== header.id) this.frameAll(low, high), (this.framed = header.id);
  }

  with(shown: Partial<Shown>): void {
    this.shown = { ...this.shown, ...shown };
    this.redraw();
  }

  side(side: Side): void {
    this.orbit.side(side);
  }

  /** Look at some markers where they are in a frame; turned so that two of them are farthest apart on the screen. */
  focus(names: readonly string[], frame: number): void {
    const places = names.map((name) => this.near(name, frame)).filter((p): p is Vector3 => p !== null);
    if (!places.length) return;
    const middle = places.reduce((sum, p) => sum.add(p), new Vector3()).divideScalar(places.length);
    if (places.length > 1) {
      const along = places[0]!.sub(places[1]!).applyQuaternion(this.orbit.upright.clone().invert()), flat = Math.hypot(along.x, along.y);
      if (flat > 1) this.orbit.azimuth = Math.atan2(along.y, along.x) + Math.PI / 2;
      this.orbit.elevation = 0.25;
    }
    const wide = Math.max(...places.map((place) => place.distanceTo(middle)));
    this.orbit.look(middle.x, middle.y, middle.z, Math.max(NEAR_MM, WIDE * wide));
  }

  show(frame: number): void {
    const { paths, header, ahead } = this;
    this.ahead = null;
    if (!paths || !header || frame === ahead) return;
    this.size();
    const index = frame - paths.firstFrame, { selected, alone, instead } = this.shown, some = new Set(selected);
    const drawn = [...paths.byName.values()].filter((path) => !alone || !some.size || some.has(path.name));
    const trails: Trail[] = drawn.map((path) => ({ path, strong: some.has(path.name), colour: instead.length && some.has(path.name) ? this.colours.a : undefined }));
    trails.push(...instead.map((path) => ({ path, colour: this.colours.b, dashed: true, strong: true })));
    this.trails.show(trails, index, Math.round(BACK_S * header.rate), Math.round(AHEAD_S * header.rate), this.colours);
    this.placeBalls(drawn, index, some);
    this.placeBones(index, alone && some.size > 0);
    this.placeCloud(selected, index);
    this.orbit.place();
    this.renderer.render(this.graph, this.camera);
    this.write(drawn, index, some);
  }

  /** The marker nearest to a place on the canvas in px, where one is near. */
  pick(x: number, y: number): string | null {
    let best: string | null = null, least = NEAR_PX;
    for (const path of this.paths?.byName.values() ?? []) {
      const seen = this.onScreen(path, this.last);
      const off = seen ? Math.hypot(seen[0] - x, seen[1] - y) : Infinity;
      if (off < least) [best, least] = [path.name, off];
    }
    return best;
  }

  dispose(): void {
    this.orbit.dispose();
    this.trails.dispose();
    this.cloud.geometry.dispose();
    (this.cloud.material as MeshBasicMaterial).dispose();
    this.bones.geometry.dispose();
    (this.bones.material as LineBasicMaterial).dispose();
    this.balls.dispose();
    if (this.still) clear(this.still);
    this.renderer.dispose();
  }

  /** Index of the frame that was drawn last, −1 before the first. */
  private last = -1;

  private size(): void {
    const width = this.canvas.clientWidth, height = this.canvas.clientHeight;
    fit(this.over, width, height);
    const scale = Math.min(window.devicePixelRatio || 1, 2);
    if (this.canvas.width !== Math.floor(width * scale) || this.canvas.height !== Math.floor(height * scale)) {
      this.renderer.setPixelRatio(scale);
      this.renderer.setSize(width, height, false);
      this.camera.aspect = width / Math.max(1, height);
    }
  }

  private placeBalls(drawn: readonly Path[], index: number, some: ReadonlySet<string>): void {
    const balls = this.balls, origins = byOrigin(this.colours), both = [...drawn, ...this.shown.instead];
    balls.begin(both.length);
    for (const [i, path] of both.entries()) {
      const { xyz, origin } = path;
      if (!origin[index]) continue;
      const instead = i >= drawn.length, strong = instead || some.has(path.name), size = strong ? 1.5 : 1;
      const own = instead ? this.colours.b : strong ? (this.shown.instead.length ? this.colours.a : this.colours.select) : path.name.startsWith("*") ? this.colours.faint : origins[origin[index]!]!;
      balls.put(xyz[3 * index]!, xyz[3 * index + 1]!, xyz[3 * index + 2]!, size, own);
    }
    balls.end();
  }

  private placeBones(index: number, none: boolean): void {
    const attribute = this.bones.geometry.getAttribute("position"), to = attribute?.array as Float32Array | undefined;
    let k = 0;
    for (const [a, b] of none || !to ? [] : this.links) {
      if (!a.origin[index] || !b.origin[index]) continue;
      for (let j = 0; j < 3; j++) {
        to![6 * k + j] = a.xyz[3 * index + j]!;
        to![6 * k + 3 + j] = b.xyz[3 * index + j]!;
      }
      k++;
    }
    this.bones.geometry.setDrawRange(0, 2 * k);
    if (attribute) attribute.needsUpdate = true;
  }

  /** The ellipsoid that holds the marker with 95 %: the unit sphere by the root of its covariance, else by its sd. */
  private placeCloud(selected: readonly string[], index: number): void {
    const path = selected.length ? this.paths!.byName.get(selected[0]!) : undefined;
    const sd = path?.sd[index] ?? NaN;
    this.cloud.visible = this.shown.ellipsoids && !!path?.origin[index] && sd > 0;
    if (!this.cloud.visible || !path) return;
    const k = ELLIPSOID * LARGER, [x, y, z] = path.xyz.subarray(3 * index, 3 * index + 3) as unknown as number[];
    const L = path.cov ? root(path.cov, 6 * index) : [sd, 0, sd, 0, 0, sd];
    const [a, b, c, d, e, f] = L.map((v) => v * k) as [number, number, number, number, number, number];
    this.cloud.matrix.set(a, 0, 0, x!, b, c, 0, y!, d, e, f, z!, 0, 0, 0, 1);
    this.cloud.matrixWorldNeedsUpdate = true;
    (this.cloud.material as MeshBasicMaterial).color.set(this.colours.select);
  }

  /** Where a marker is in a frame, or in the nearest one that has it. */
  private near(name: string, frame: number): Vector3 | null {
    const path = this.paths?.byName.get(name), i = path ? nearestSample(path, frame - this.paths!.firstFrame) : null;
    return path && i !== null ? new Vector3(path.xyz[3 * i], path.xyz[3 * i + 1], path.xyz[3 * i + 2]) : null;
  }

  private onScreen(path: Path, index: number): [number, number] | null {
    if (!path.origin[index]) return null;
    this.spot.set(path.xyz[3 * index]!, path.xyz[3 * index + 1]!, path.xyz[3 * index + 2]!).project(this.camera);
    if (this.spot.z > 1) return null;
    return [((this.spot.x + 1) / 2) * this.over.clientWidth, ((1 - this.spot.y) / 2) * this.over.clientHeight];
  }

  /** Names beside the markers, and A and B beside what is and what would be. */
  private write(drawn: readonly Path[], index: number, some: ReadonlySet<string>): void {
    this.last = index;
    const c = this.over.getContext("2d")!, scale = this.over.width / Math.max(1, this.over.clientWidth);
    c.setTransform(scale, 0, 0, scale, 0, 0);
    c.clearRect(0, 0, this.over.clientWidth, this.over.clientHeight);
    c.font = SANS;
    const names = new Names(c, this.colours.view), two = this.shown.instead.length > 0, { ink, faint } = this.colours;
    for (const path of drawn) {
      const at = some.has(path.name) ? this.onScreen(path, index) : null;
      if (at) ring(c, at, two ? this.colours.a : this.colours.select), names.write(two ? `A ${path.name}` : path.name, at, ink, true);
    }
    for (const path of this.shown.instead) {
      const at = this.onScreen(path, index);
      if (at) ring(c, at, this.colours.b, true);
      if (at && this.shown.instead.length <= MOST_NAMED) names.write(wouldBe(path.name), at, ink, true);
    }
    for (const path of drawn) {
      const at = some.has(path.name) ? null : this.onScreen(path, index);
      if (at) names.write(withoutSubject(this.header, path.name), at, faint);
    }
  }

  private frameAll(low: readonly number[], high: readonly number[]): void {
    const size = Math.hypot(...low.map((v, k) => high[k]! - v)) || 1000, [x, y, z] = low.map((v, k) => (v + high[k]!) / 2) as [number, number, number];
    const [from, to] = standing(low, high, this.orbit.upright);
    this.size();
    this.orbit.azimuth = to[0]! - from[0]! > to[1]! - from[1]! ? -1.1 : 0.45;
    let away = 0.5 * size;
    do this.orbit.look(x, y, z, (away *= 1.05)), this.orbit.place();
    while (away < FARTHEST_MM && !this.holds(low, high));
  }

  /** Whether the picture holds the corners of a box. */
  private holds(low: readonly number[], high: readonly number[]): boolean {
    for (let n = 0; n < 8; n++) {
      const [x, y, z] = [0, 1, 2].map((k) => (n & (1 << k) ? high : low)[k]!) as [number, number, number];
      this.spot.set(x, y, z).project(this.camera);
      if (Math.max(Math.abs(this.spot.x), Math.abs(this.spot.y)) > WITHIN) return false;
    }
    return true;
  }
}

/** The Cholesky root (l11 l21 l22 l31 l32 l33) of a covariance (xx xy xz yy yz zz) at an offset. */
function root(cov: Float32Array, at: number): number[] {
  const [xx, xy, xz, yy, yz, zz] = cov.subarray(at, at + 6) as unknown as [number, number, number, number, number, number];
  const a = Math.sqrt(Math.max(xx, 1e-9)), b = xy / a, d = xz / a, c = Math.sqrt(Math.max(yy - b * b, 1e-9)), e = (yz - b * d) / c;
  return [a, b, c, d, e, Math.sqrt(Math.max(zz - d * d - e * e, 1e-9))];
}

/** Lowest and highest coordinates of all paths, without the wildest hundredth of them. */
function reach(paths: PathSet): [number[], number[]] {
  const values: number[][] = [[], [], []], step = Math.max(1, Math.floor((paths.frames * paths.byName.size) / 6000));
  let k = 0;
  for (const { xyz, origin } of paths.byName.values())
    for (let i = 0; i < origin.length; i++) if (origin[i] && k++ % step === 0) for (let j = 0; j < 3; j++) values[j]!.push(xyz[3 * i + j]!);
  const sorted = values.map((v) => v.sort((a, b) => a - b));
  const at = (v: number[], share: number): number => v[Math.floor(share * (v.length - 1))] ?? 0;
  return [sorted.map((v) => at(v, 0.01)), sorted.map((v) => at(v, 0.99))];
}

function ring(c: CanvasRenderingContext2D, [x, y]: [number, number], colour: string, dashed = false): void {
  c.strokeStyle = colour;
  c.lineWidth = 2;
  c.setLineDash(dashed ? [3, 3] : []);
  c.beginPath();
  c.arc(x, y, 10, 0, 7);
  c.stroke();
  c.setLineDash([]);
}
