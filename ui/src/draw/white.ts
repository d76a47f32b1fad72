/** White pixels of an image, as a threshold has them, drawn over it. */
import { bitmapAt, type Scale } from "./Picture";

/** Overlays that are kept; chosen: eight cameras, two frames. */
const KEPT = 16;
const made = new Map<string, HTMLCanvasElement>();
const grey = new Map<string, Promise<ImageData> | ImageData>();

/** Draw them where they are there; else once the image was read. */
export function whitePixels(c: CanvasRenderingContext2D, address: string, threshold: number, inverted: boolean, s: Scale, redraw: () => void): void {
  const data = grey.get(address);
  if (!data) grey.set(address, read(address).then((read) => (grey.set(address, read), trim(grey), redraw(), read)));
  if (!data || data instanceof Promise) return;
  const key = `${address} ${threshold} ${inverted}`, overlay = made.get(key) ?? coloured(data, threshold, inverted);
  made.set(key, overlay);
  trim(made);
  c.imageSmoothingEnabled = false;
  c.drawImage(overlay, s.x, s.y, overlay.width * s.by, overlay.height * s.by * s.tall);
}

async function read(address: string): Promise<ImageData> {
  const bitmap = await bitmapAt(address), canvas = new OffscreenCanvas(bitmap.width, bitmap.height), c = canvas.getContext("2d", { willReadFrequently: true })!;
  c.drawImage(bitmap, 0, 0);
  return c.getImageData(0, 0, bitmap.width, bitmap.height);
}

function coloured(data: ImageData, threshold: number, inverted: boolean): HTMLCanvasElement {
  const canvas = document.createElement("canvas"), out = new ImageData(data.width, data.height), from = data.data, to = new Uint32Array(out.data.buffer);
  for (let i = 0, k = 0; i < to.length; i++, k += 4) if (inverted ? from[k]! < threshold : from[k]! > threshold) to[i] = 0xb0_40_c0_ff; // a b g r
  canvas.width = data.width;
  canvas.height = data.height;
  canvas.getContext("2d")!.putImageData(out, 0, 0);
  return canvas;
}

function trim(map: Map<string, unknown>): void {
  for (const old of map.keys()) {
    if (map.size <= KEPT) return;
    map.delete(old);
  }
}
