/** Images of markers in all cameras, over a stretch of frames. */
import type { DetectionsHeader } from "../api/types";

export interface Detected {
  readonly first: number;
  readonly last: number;
  readonly cameras: readonly string[];
  /** Where the detections of camera c in frame f begin: start[c × frames + f − first]; one more at the end. */
  readonly start: Uint32Array;
  readonly uv: Float32Array;
  readonly track: Int32Array;
  readonly validity: Uint8Array;
}

export function decodeDetections(header: DetectionsHeader, body: ArrayBuffer): Detected {
  const n = header.last - header.first + 1, cells = header.cameras.length * n, d = header.detections;
  const counts = new Uint32Array(body, 0, cells), start = new Uint32Array(cells + 1);
  for (let i = 0; i < cells; i++) start[i + 1] = start[i]! + counts[i]!;
  const at = 4 * cells;
  return {
    first: header.first, last: header.last, cameras: header.cameras, start,
    uv: new Float32Array(body, at, 2 * d), track: new Int32Array(body, at + 8 * d, d), validity: new Uint8Array(body, at + 12 * d, d),
  };
}

/** From where to where the detections of a camera in a frame are; nothing outside. */
export function detectedIn(all: Detected, camera: number, frame: number): [number, number] {
  if (frame < all.first || frame > all.last || camera < 0) return [0, 0];
  const cell = camera * (all.last - all.first + 1) + frame - all.first;
  return [all.start[cell]!, all.start[cell + 1]!];
}
