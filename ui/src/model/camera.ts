/**
 * Cameras as the library has them (kinemark/data/rig.py): x_cam = R X + t, lens k1 k2 p1 p2 k3, then K to px.
 * Pixel (0, 0) is the centre of the top-left one.
 */
import type { CameraRow } from "../api/types";

export type Point = [number, number];

function distorted(x: number, y: number, d: CameraRow["distortion"]): Point {
  const [k1, k2, p1, p2, k3] = d, r = x * x + y * y, radial = 1 + r * (k1 + r * (k2 + r * k3));
  return [x * radial + 2 * p1 * x * y + p2 * (r + 2 * x * x), y * radial + p1 * (r + 2 * y * y) + 2 * p2 * x * y];
}

/** Where a place in mm is seen, px; null behind the camera. */
export function project(camera: CameraRow, x: number, y: number, z: number): Point | null {
  const { R, t, K } = camera;
  const depth = R[2][0] * x + R[2][1] * y + R[2][2] * z + t[2];
  if (!(depth > 0)) return null;
  const a = (R[0][0] * x + R[0][1] * y + R[0][2] * z + t[0]) / depth;
  const b = (R[1][0] * x + R[1][1] * y + R[1][2] * z + t[1]) / depth;
  const [u, v] = distorted(a, b, camera.distortion);
  return [K[0][0] * u + K[0][1] * v + K[0][2], K[1][1] * v + K[1][2]];
}

/** Times that the lens is undone, each from the guess before; chosen: 1e-6 px for every lens of a laboratory. */
const UNDO_STEPS = 12;

/** The direction in the world, not of unit length, in which a pixel looks. */
export function ray(camera: CameraRow, u: number, v: number): [number, number, number] {
  const { K, R } = camera;
  const yd = (v - K[1][2]) / K[1][1], xd = (u - K[0][2] - K[0][1] * yd) / K[0][0];
  let x = xd, y = yd;
  for (let i = 0; i < UNDO_STEPS; i++) {
    const [a, b] = distorted(x, y, camera.distortion);
    x += xd - a;
    y += yd - b;
  }
  return [R[0][0] * x + R[1][0] * y + R[2][0], R[0][1] * x + R[1][1] * y + R[2][1], R[0][2] * x + R[1][2] * y + R[2][2]];
}

/** Points of an epipolar line, and the depths in mm that they are spread over; chosen: a room. */
const LINE_POINTS = 48, NEAR_MM = 300, FAR_MM = 15000;

/** Where `other` may see what `camera` sees at a pixel: a polyline in px. */
export function epipolarLine(camera: CameraRow, u: number, v: number, other: CameraRow): Point[] {
  const d = ray(camera, u, v), c = camera.centre, line: Point[] = [];
  for (let i = 0; i < LINE_POINTS; i++) {
    const s = NEAR_MM * (FAR_MM / NEAR_MM) ** (i / (LINE_POINTS - 1));
    const at = project(other, c[0] + s * d[0], c[1] + s * d[1], c[2] + s * d[2]);
    if (at && inside(other, at, other.width)) line.push(at);
  }
  return line;
}

/** Whether a pixel is in the image, or at most so far beside it. */
export const inside = (camera: CameraRow, [u, v]: Point, beside = 0): boolean =>
  u >= -beside && v >= -beside && u < camera.width + beside && v < camera.height + beside;
