/**
 * One image of a camera, as large as its place or larger, with what is drawn over it. A click is a pixel of the image;
 * the wheel makes it larger about the cursor, dragging moves it. Pixel (0, 0) is the centre of the top-left one.
 */
import { fit, SANS } from "./palette";

/** From image px to px of the screen; a line of a field is `tall` times as high as wide. */
export interface Scale { x: number; y: number; by: number; tall: number }
export interface Box { x: number; y: number; width: number; height: number }
export type Over = (c: CanvasRenderingContext2D, to: (u: number, v: number) => [number, number], scale: Scale, redraw: () => void) => void;

/** Times that an image is enlarged at most, by a step of the wheel; px that a drag is longer than a click; images that are
 * kept. Chosen. */
const MOST = 24, STEP = 1.25, SLACK = 4, KEPT = 40;

const bitmaps = new Map<string, Promise<ImageBitmap>>();

/** The image at an address; asked for once. */
export function bitmapAt(address: string): Promise<ImageBitmap> {
  const known = bitmaps.get(address);
  if (known) return known;
  const made = fetch(address).then(async (answer) => {
    if (!answer.ok) throw new Error(`The image cannot be had (${answer.status}).`);
    return createImageBitmap(await answer.blob());
  });
  bitmaps.set(address, made);
  made.catch(() => bitmaps.delete(address));
  for (const old of bitmaps.keys()) {
    if (bitmaps.size <= KEPT) break;
    bitmaps.delete(old);
  }
  return made;
}

export class Picture {
  onClick: (u: number, v: number) => void = () => {};
  onMove: (u: number, v: number) => void = () => {};
  /** Dragging draws a rectangle instead of moving the image. */
  onBox: ((box: Box) => void) | null = null;
  over: Over = () => {};
  bitmap: ImageBitmap | null = null;
  private readonly canvas = document.createElement("canvas");
  private readonly watch: ResizeObserver;
  private wanted = "";
  private tall = 1;
  private zoom = 1;
  private middle: [number, number] | null = null;
  private drag: { x: number; y: number; at: [number, number]; middle: [number, number]; moved: boolean } | null = null;
  private box: Box | null = null;
  private waiting = 0;

  constructor(private readonly element: HTMLElement, label: string) {
    this.canvas.setAttribute("role", "img");
    this.canvas.setAttribute("aria-label", label);
    element.append(this.canvas);
    this.watch = new ResizeObserver(() => this.redraw());
    this.watch.observe(element);
    this.canvas.addEventListener("wheel", this.wheel, { passive: false });
    this.canvas.addEventListener("pointerdown", this.down);
    this.canvas.addEventListener("pointermove", this.move);
    this.canvas.addEventListener("pointerup", this.up);
    this.canvas.addEventListener("dblclick", () => this.whole());
  }

  /** Show an image; what was there stays until it has come. */
  async show(address: string, tall: number): Promise<void> {
    this.wanted = address;
    this.tall = tall;
    const bitmap = await bitmapAt(address);
    if (this.wanted !== address) return;
    this.bitmap = bitmap;
    this.element.dataset.shown = address;
    this.redraw();
  }

  /** All of it. */
  whole(): void {
    this.zoom = 1;
    this.middle = null;
    this.redraw();
  }

  /** Enlarge about the cursor's pixel, or the middle. */
  larger(by: number, about: [number, number] | null = null): void {
    const s = this.scale(), at = about ?? this.pixel(this.element.clientWidth / 2, this.element.clientHeight / 2, s);
    const zoom = Math.min(MOST, Math.max(1, this.zoom * by)), middle = this.middle ?? this.centre();
    const share = this.zoom / zoom;
    this.middle = [at[0] + (middle[0] - at[0]) * share, at[1] + (middle[1] - at[1]) * share];
    this.zoom = zoom;
    if (zoom === 1) this.middle = null;
    this.redraw();
  }

  /** Where a pixel is on the screen, from the corner of the element. */
  place(u: number, v: number): [number, number] {
    const s = this.scale();
    return [s.x + (u + 0.5) * s.by, s.y + (v + 0.5) * s.by * s.tall];
  }

  redraw(): void {
    if (!this.waiting) this.waiting = requestAnimationFrame(this.draw);
  }

  dispose(): void {
    this.watch.disconnect();
    this.canvas.remove();
    cancelAnimationFrame(this.waiting);
  }

  private readonly draw = (): void => {
    this.waiting = 0;
    const { clientWidth: w, clientHeight: h } = this.element, ratio = fit(this.canvas, w, h), c = this.canvas.getContext("2d")!;
    c.setTransform(ratio, 0, 0, ratio, 0, 0);
    c.clearRect(0, 0, w, h);
    if (!this.bitmap) return;
    const s = this.scale();
    c.imageSmoothingEnabled = s.by < 2;
    c.drawImage(this.bitmap, s.x, s.y, this.bitmap.width * s.by, this.bitmap.height * s.by * s.tall);
    c.font = SANS;
    this.over(c, (u, v) => [s.x + (u + 0.5) * s.by, s.y + (v + 0.5) * s.by * s.tall], s, () => this.redraw());
    if (!this.box) return;
    const [x, y] = this.place(this.box.x - 0.5, this.box.y - 0.5);
    c.strokeStyle = "#fff";
    c.setLineDash([4, 3]);
    c.strokeRect(x, y, this.box.width * s.by, this.box.height * s.by * s.tall);
    c.setLineDash([]);
  };

  private centre(): [number, number] {
    return [(this.bitmap?.width ?? 1) / 2 - 0.5, (this.bitmap?.height ?? 1) / 2 - 0.5];
  }

  private scale(): Scale {
    const { clientWidth: w, clientHeight: h } = this.element, b = this.bitmap, width = b?.width ?? 1, height = (b?.height ?? 1) * this.tall;
    const by = Math.min(w / width, h / height) * this.zoom, [u, v] = this.middle ?? this.centre();
    return { by, tall: this.tall, x: w / 2 - (u + 0.5) * by, y: h / 2 - (v + 0.5) * by * this.tall };
  }

  private pixel(x: number, y: number, s = this.scale()): [number, number] {
    return [(x - s.x) / s.by - 0.5, (y - s.y) / (s.by * s.tall) - 0.5];
  }

  private at(e: PointerEvent | WheelEvent): [number, number] {
    const box = this.canvas.getBoundingClientRect();
    return this.pixel(e.clientX - box.left, e.clientY - box.top);
  }

  private readonly wheel = (e: WheelEvent): void => {
    e.preventDefault();
    this.larger(e.deltaY < 0 ? STEP : 1 / STEP, this.at(e));
  };

  private readonly down = (e: PointerEvent): void => {
    if (e.button !== 0) return;
    this.canvas.setPointerCapture(e.pointerId);
    this.drag = { x: e.clientX, y: e.clientY, at: this.at(e), middle: this.middle ?? this.centre(), moved: false };
  };

  private readonly move = (e: PointerEvent): void => {
    this.onMove(...this.at(e));
    const drag = this.drag;
    if (!drag) return;
    if (Math.hypot(e.clientX - drag.x, e.clientY - drag.y) > SLACK) drag.moved = true;
    if (!drag.moved) return;
    if (this.onBox) this.box = boxOf(drag.at, this.at(e));
    else if (this.zoom > 1) {
      const s = this.scale();
      this.middle = [drag.middle[0] - (e.clientX - drag.x) / s.by, drag.middle[1] - (e.clientY - drag.y) / (s.by * s.tall)];
    }
    this.redraw();
  };

  private readonly up = (e: PointerEvent): void => {
    const drag = this.drag, box = this.box;
    this.drag = null;
    this.box = null;
    if (!drag) return;
    if (box && this.onBox) this.onBox(box), this.redraw();
    else if (!drag.moved && this.bitmap) this.onClick(...this.at(e));
  };
}

/** Whole pixels between two corners, both included. */
function boxOf(a: readonly [number, number], b: readonly [number, number]): Box {
  const x = Math.round(Math.min(a[0], b[0])), y = Math.round(Math.min(a[1], b[1]));
  return { x, y, width: Math.round(Math.max(a[0], b[0])) - x + 1, height: Math.round(Math.max(a[1], b[1])) - y + 1 };
}

/** A cross of two colours, which is seen on black and on white. */
export function plus(c: CanvasRenderingContext2D, [x, y]: readonly [number, number], r: number, colour: string, gap = 0): void {
  for (const [ink, width] of [["#000", 3.6], [colour, 1.6]] as const) {
    c.strokeStyle = ink;
    c.lineWidth = width;
    c.beginPath();
    for (const [dx, dy] of [[1, 0], [-1, 0], [0, 1], [0, -1]] as const) c.moveTo(x + gap * dx, y + gap * dy), c.lineTo(x + r * dx, y + r * dy);
    c.stroke();
  }
}

/** Words on an image. */
export function label(c: CanvasRenderingContext2D, x: number, y: number, words: string, colour: string): void {
  const width = c.measureText(words).width;
  c.fillStyle = "rgb(0 0 0 / 66%)";
  c.fillRect(x - 2, y - 10, width + 4, 14);
  c.fillStyle = colour;
  c.fillText(words, x, y + 1);
}
