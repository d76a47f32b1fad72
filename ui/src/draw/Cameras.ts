/**
 * All cameras side by side on one frame: their images, what was detected, where the markers should be seen, and the
 * lines on which other cameras may see them. What lies over an image is always of the image's own frame. Where one looks
 * closer than the small images show, and stays in a frame, the camera's own pixels come.
 */
import { aheadAddress, mosaicAddress, partAddress } from "../api/client";
import type { CameraRow, TrialHeader } from "../api/types";
import { epipolarLine, project } from "../model/camera";
import { detectedIn, type Detected } from "../model/detections";
import type { Path, PathSet } from "../model/paths";
import { MOST_NAMED, wouldBe } from "./names";
import { fit } from "./palette";

export interface Click { camera: string; u: number; v: number }
export interface CameraView {
  selected: readonly string[];
  lines: boolean;
  images: boolean;
  /** Tiles are centred on the selected marker and this much larger. */
  follow: boolean;
  /** In this order; others after them. */
  order: readonly string[];
  clicks: readonly Click[];
  instead: readonly Path[];
  residuals: boolean;
}

/** Times larger when a marker is followed; px in which a click means a detection; images that are kept. Chosen. */
const FOLLOW = 5, NEAR_PX = 10, KEPT = 48;
/** Steps of the keys, whose images are fetched before they are asked for; so many at a time. */
const STEPS = [1, 2, 10, -1, -10, 3] as const, AT_ONCE = 2;
/** ms in a frame before a camera's own pixels are asked for, which come in steps of so many px; chosen. */
const REST_MS = 150, STEP_PX = 16;

/** `part` of the image in its own pixels; `wanted`: the address of that which should be there. */
interface Tile { camera: CameraRow; index: number; box: HTMLElement; canvas: HTMLCanvasElement; zoom: number; u: number; v: number; wanted: string; part: { address: string; bitmap: ImageBitmap } | null }
/** From image px to px of the tile. */
interface Fit { scale: number; x: number; y: number }

export class Cameras {
  onPick: (name: string, more: boolean) => void = () => {};
  onClick: (click: Click) => boolean = () => false;
  /** Asks for the detections about a frame. */
  wanted: (frame: number) => void = () => {};
  private tiles: Tile[] = [];
  private header: TrialHeader | null = null;
  private paths: PathSet | null = null;
  private detected: Detected | null = null;
  private view: CameraView = { selected: [], lines: true, images: true, follow: false, order: [], clicks: [], instead: [], residuals: false };
  private readonly bitmaps = new Map<number, ImageBitmap | null>();
  private large: string | null = null;
  private shownFrame = 0;
  /** Which way one goes through time; frames that are fetched before they are asked for. */
  private way = 1;
  private readonly ahead = new Set<number>();
  private readonly watch: ResizeObserver;

  constructor(private readonly element: HTMLElement, private readonly redraw: () => void) {
    this.watch = new ResizeObserver(redraw);
    this.watch.observe(element);
  }

  set(header: TrialHeader, paths: PathSet): void {
    if (this.header?.id !== header.id || this.header.mosaic?.images !== header.mosaic?.images) this.forget();
    const same = this.header?.id === header.id && this.tiles.length === header.cameras.length;
    this.header = header;
    this.paths = paths;
    if (!same) this.build(header);
    this.redraw();
  }

  with(view: Partial<CameraView>): void {
    this.view = { ...this.view, ...view };
    const place = new Map(this.view.order.map((name, i) => [name, i]));
    for (const tile of this.tiles) tile.box.style.order = String(place.get(tile.camera.name) ?? 100 + tile.index);
    this.redraw();
  }

  detections(detected: Detected | null): void {
    this.detected = detected;
    this.redraw();
  }

  show(frame: number): void {
    if (!this.header || !this.paths) return;
    if (this.header.has_detections && (!this.detected || frame < this.detected.first || frame > this.detected.last)) this.wanted(frame);
    if (frame !== this.shownFrame) this.way = frame < this.shownFrame ? -1 : 1;
    this.shownFrame = frame;
    const bitmap = this.header.mosaic && this.view.images ? this.bitmap(frame) : null;
    if (bitmap) this.lookAhead();
    this.element.dataset.frame = String(frame);
    this.element.dataset.images = bitmap ? String(frame) : "";
    for (const tile of this.tiles) if (tile.box.offsetParent) this.draw(tile, frame, bitmap ?? null);
  }

  dispose(): void {
    this.watch.disconnect();
    this.forget();
    this.element.replaceChildren();
  }

  private forget(): void {
    for (const bitmap of this.bitmaps.values()) bitmap?.close();
    this.bitmaps.clear();
    this.detected = null;
  }

  /** The mosaic of a frame, asked for where it is not there; the last used ones are kept. */
  private bitmap(frame: number): ImageBitmap | null {
    const known = this.bitmaps.get(frame);
    this.bitmaps.delete(frame);
    this.bitmaps.set(frame, known ?? null);
    if (known === undefined) void this.fetch(frame, mosaicAddress);
    for (const [old, bitmap] of this.bitmaps) {
      if (this.bitmaps.size <= KEPT) break;
      if (old !== frame) bitmap?.close(), this.bitmaps.delete(old);
    }
    return known ?? null;
  }

  /** The images that the next key would show, before it is pressed. */
  private lookAhead(): void {
    const { first_frame: first, n_frames: n } = this.header!;
    for (const step of STEPS) {
      const frame = this.shownFrame + this.way * step;
      if (this.ahead.size >= AT_ONCE) return;
      if (frame < first || frame >= first + n || this.bitmaps.has(frame)) continue;
      this.bitmaps.set(frame, null);
      this.ahead.add(frame);
      void this.fetch(frame, aheadAddress).then((there) => setTimeout(() => {
        this.ahead.delete(frame);
        if (this.bitmaps.get(this.shownFrame)) this.lookAhead();
      }, there ? 0 : REST_MS));
    }
  }

  /** Whether the server had it. What was not made yet ahead of time is asked for anew where it is looked at by now. */
  private async fetch(frame: number, address: typeof mosaicAddress): Promise<boolean> {
    try {
      const { id, mosaic } = this.header!, answer = await fetch(address(id, frame, mosaic!.images));
      if (answer.ok && answer.status !== 204) {
        const bitmap = await createImageBitmap(await answer.blob());
        const others = this.header?.id !== id || this.header.mosaic?.images !== mosaic!.images;
        if (others || !this.bitmaps.has(frame)) return bitmap.close(), false;
        this.bitmaps.set(frame, bitmap);
      } else if (answer.status === 204) this.bitmaps.delete(frame);
      if (frame === this.shownFrame) this.redraw();
      return answer.status === 200;
    } catch {
      this.bitmaps.delete(frame); // asked for again when it is next shown
      return false;
    }
  }

  private build(header: TrialHeader): void {
    this.tiles = header.cameras.map((camera, index) => {
      const box = document.createElement("div"), canvas = document.createElement("canvas"), name = document.createElement("span");
      box.className = "camera-tile";
      name.textContent = camera.name;
      canvas.setAttribute("role", "img");
      canvas.setAttribute("aria-label", `Image of ${camera.name}`);
      box.append(canvas, name);
      const tile: Tile = { camera, index, box, canvas, zoom: 1, u: camera.width / 2, v: camera.height / 2, wanted: "", part: null };
      canvas.addEventListener("click", (e) => this.clicked(tile, e));
      canvas.addEventListener("dblclick", () => this.enlarge(camera.name));
      canvas.addEventListener("wheel", (e) => this.wheel(tile, e), { passive: false });
      return tile;
    });
    this.element.replaceChildren(...this.tiles.map((tile) => tile.box));
    this.enlarge(null);
  }

  /** One camera alone, or all again. */
  enlarge(name: string | null): void {
    this.large = this.large === name ? null : name;
    this.element.dataset.large = this.large ? "yes" : "";
    for (const tile of this.tiles) tile.box.hidden = this.large !== null && tile.camera.name !== this.large;
    this.redraw();
  }

  private fitOf(tile: Tile, width: number, height: number, frame: number): Fit {
    const { camera } = tile, own = Math.min(width / (camera.width || 1), height / (camera.height || 1));
    const at = this.view.follow ? (this.seen(camera, this.view.selected[0], frame) ?? this.place(camera, this.view.instead[0], frame)) : null;
    const scale = own * (at ? FOLLOW : tile.zoom), [u, v] = at ?? (tile.zoom > 1 ? [tile.u, tile.v] : [camera.width / 2, camera.height / 2]);
    return { scale, x: width / 2 - (u + 0.5) * scale, y: height / 2 - (v + 0.5) * scale };
  }

  private seen(camera: CameraRow, name: string | undefined, frame: number): [number, number] | null {
    return this.place(camera, name ? this.paths!.byName.get(name) : undefined, frame);
  }

  private place(camera: CameraRow, path: Path | undefined, frame: number): [number, number] | null {
    const i = frame - this.paths!.firstFrame;
    return path?.origin[i] ? project(camera, path.xyz[3 * i]!, path.xyz[3 * i + 1]!, path.xyz[3 * i + 2]!) : null;
  }

  private draw(tile: Tile, frame: number, bitmap: ImageBitmap | null): void {
    const width = tile.box.clientWidth, height = tile.box.clientHeight, scale = fit(tile.canvas, width, height);
    const c = tile.canvas.getContext("2d")!, f = this.fitOf(tile, width, height, frame), { camera } = tile;
    c.setTransform(scale, 0, 0, scale, 0, 0);
    c.fillStyle = "#05080a";
    c.fillRect(0, 0, width, height);
    c.imageSmoothingEnabled = f.scale < 2;
    const place = this.header!.mosaic?.tiles.find((one) => one.camera === camera.name);
    if (bitmap && place) c.drawImage(bitmap, place.x, place.y, place.width, place.height, f.x, f.y, camera.width * f.scale, camera.height * f.scale);
    else c.strokeStyle = "#2a3742", c.strokeRect(f.x, f.y, camera.width * f.scale, camera.height * f.scale);
    if (bitmap && place && f.scale * camera.width > place.width) this.closer(c, tile, f, frame, width, height);
    this.dots(c, tile, f, frame, !!bitmap);
    this.crosses(c, camera, f, frame);
    if (this.view.lines) this.epipolar(c, camera, f, frame);
    for (const click of this.view.clicks) if (click.camera === camera.name) cross(c, f, [click.u, click.v], "#ffd54a", 9);
  }

  /** What is in sight of a tile in the camera's own pixels, once the frame has stayed. */
  private closer(c: CanvasRenderingContext2D, tile: Tile, f: Fit, frame: number, width: number, height: number): void {
    const low = (at: number): number => Math.max(0, Math.floor(-at / f.scale / STEP_PX) * STEP_PX);
    const high = (at: number, size: number, most: number): number => Math.min(most, Math.ceil((size - at) / f.scale / STEP_PX) * STEP_PX);
    const x = low(f.x), y = low(f.y), w = high(f.x, width, tile.camera.width) - x, h = high(f.y, height, tile.camera.height) - y;
    if (w <= 0 || h <= 0) return;
    const address = partAddress(this.header!.id, tile.camera.name, frame, this.header!.mosaic!.images, x, y, w, h), { part } = tile;
    if (part?.address === address) return c.drawImage(part.bitmap, f.x + x * f.scale, f.y + y * f.scale, w * f.scale, h * f.scale);
    if (tile.wanted === address) return;
    tile.wanted = address;
    setTimeout(() => { if (tile.wanted === address) void this.fetchPart(tile, address); }, REST_MS);
  }

  private async fetchPart(tile: Tile, address: string): Promise<void> {
    const answer = await fetch(address).catch(() => null);
    if (!answer?.ok) return;
    const bitmap = await createImageBitmap(await answer.blob());
    tile.part?.bitmap.close();
    tile.part = { address, bitmap };
    tile.box.dataset.part = address;
    this.redraw();
  }

  private dots(c: CanvasRenderingContext2D, tile: Tile, f: Fit, frame: number, images: boolean): void {
    const all = this.detected, names = this.header!.tracks, some = new Set(this.view.selected);
    if (!all) return;
    const [from, to] = detectedIn(all, all.cameras.indexOf(tile.camera.name), frame);
    for (let i = from; i < to; i++) {
      const x = f.x + (all.uv[2 * i]! + 0.5) * f.scale, y = f.y + (all.uv[2 * i + 1]! + 0.5) * f.scale;
      const name = names[all.track[i]!]?.name, own = name !== undefined && some.has(name);
      if (!images) circle(c, x, y, 1.8, "#e8eef2", true);
      circle(c, x, y, own ? 6 : 4, own ? "#ff7ac6" : name === undefined ? "#8b99a5" : "#63b8f0", false, all.validity[i] === 0);
    }
  }

  private crosses(c: CanvasRenderingContext2D, camera: CameraRow, f: Fit, frame: number): void {
    for (const name of this.view.selected) {
      const at = this.seen(camera, name, frame);
      if (at) cross(c, f, at, this.view.instead.length ? "#ff8a45" : "#ff7ac6", 7, name);
    }
    for (const path of this.view.instead) {
      const at = this.place(camera, path, frame);
      if (at) cross(c, f, at, "#36d3a2", 7, this.view.instead.length <= MOST_NAMED ? wouldBe(path.name) : "", true);
    }
  }

  /** Lines of what the other cameras see of the selected marker, or of what was clicked in them. */
  private epipolar(c: CanvasRenderingContext2D, camera: CameraRow, f: Fit, frame: number): void {
    const seen: Click[] = [...this.view.clicks];
    if (!seen.length && this.detected) {
      const name = this.view.selected[0], track = this.header!.tracks.findIndex((one) => one.name === name);
      for (const [k, other] of this.detected.cameras.entries()) {
        const [from, to] = detectedIn(this.detected, k, frame);
        for (let i = from; i < to; i++) if (track >= 0 && this.detected.track[i] === track) seen.push({ camera: other, u: this.detected.uv[2 * i]!, v: this.detected.uv[2 * i + 1]! });
      }
    }
    c.strokeStyle = "#ffd54a";
    c.globalAlpha = this.view.clicks.length ? 0.9 : 0.45;
    c.lineWidth = 1;
    for (const click of seen) {
      const from = this.header!.cameras.find((one) => one.name === click.camera);
      if (!from || from === camera) continue;
      c.beginPath();
      for (const [u, v] of epipolarLine(from, click.u, click.v, camera)) c.lineTo(f.x + (u + 0.5) * f.scale, f.y + (v + 0.5) * f.scale);
      c.stroke();
    }
    c.globalAlpha = 1;
  }

  private clicked(tile: Tile, event: MouseEvent): void {
    const f = this.fitOf(tile, tile.box.clientWidth, tile.box.clientHeight, this.shownFrame);
    const u = (event.offsetX - f.x) / f.scale - 0.5, v = (event.offsetY - f.y) / f.scale - 0.5;
    const near = this.near(tile.camera.name, u, v, NEAR_PX / f.scale);
    if (this.onClick({ camera: tile.camera.name, u: near?.u ?? u, v: near?.v ?? v })) return;
    const name = near && this.header!.tracks[near.track]?.name;
    if (name) this.onPick(name, event.ctrlKey || event.shiftKey);
  }

  /** The detection nearest to a pixel: what was clicked is meant to a hundredth of a pixel. */
  private near(camera: string, u: number, v: number, most: number): { u: number; v: number; track: number } | null {
    const all = this.detected;
    if (!all) return null;
    const [from, to] = detectedIn(all, all.cameras.indexOf(camera), this.shownFrame);
    let best = -1, least = most;
    for (let i = from; i < to; i++) {
      const off = Math.hypot(all.uv[2 * i]! - u, all.uv[2 * i + 1]! - v);
      if (off < least) [best, least] = [i, off];
    }
    return best < 0 ? null : { u: all.uv[2 * best]!, v: all.uv[2 * best + 1]!, track: all.track[best]! };
  }

  private wheel(tile: Tile, event: WheelEvent): void {
    event.preventDefault();
    const f = this.fitOf(tile, tile.box.clientWidth, tile.box.clientHeight, this.shownFrame);
    const u = (event.offsetX - f.x) / f.scale - 0.5, v = (event.offsetY - f.y) / f.scale - 0.5;
    const zoom = Math.min(40, Math.max(1, tile.zoom * Math.exp(-event.deltaY * 0.002)));
    const stay = 1 - tile.zoom / zoom; // the pixel under the pointer stays there
    if (tile.zoom === 1) [tile.u, tile.v] = [tile.camera.width / 2, tile.camera.height / 2];
    Object.assign(tile, { u: tile.u + (u - tile.u) * stay, v: tile.v + (v - tile.v) * stay, zoom });
    this.redraw();
  }
}

function circle(c: CanvasRenderingContext2D, x: number, y: number, r: number, colour: string, full: boolean, dashed = false): void {
  c.beginPath();
  c.arc(x, y, r, 0, 7);
  c.setLineDash(dashed ? [2, 2] : []);
  if (full) (c.fillStyle = colour), c.fill();
  else (c.strokeStyle = colour), (c.lineWidth = 1.2), c.stroke();
  c.setLineDash([]);
}

function cross(c: CanvasRenderingContext2D, f: Fit, [u, v]: readonly [number, number], colour: string, r: number, name = "", dashed = false): void {
  const x = f.x + (u + 0.5) * f.scale, y = f.y + (v + 0.5) * f.scale;
  c.strokeStyle = colour;
  c.lineWidth = 1.4;
  c.setLineDash(dashed ? [3, 2] : []);
  c.beginPath();
  c.moveTo(x - r, y), c.lineTo(x + r, y), c.moveTo(x, y - r), c.lineTo(x, y + r);
  c.stroke();
  c.setLineDash([]);
  if (!name) return;
  c.font = "11px sans-serif";
  c.fillStyle = colour;
  const most = c.canvas.clientWidth - c.measureText(name).width - 2; // so that no name is cut off by the image's edge
  c.fillText(name, Math.max(2, Math.min(x + r + 1, most)), y + (dashed ? 12 : -3)); // one way above, the other below
}
