/** What stands still in the view: the floor, the control volume, the cameras. */
import { BufferGeometry, Color, Float32BufferAttribute, Group, LineBasicMaterial, LineSegments, Matrix3, Quaternion, Vector3 } from "three";
import type { CameraRow, TrialHeader } from "../api/types";
import type { Palette } from "./palette";

/** mm of a camera's pyramid, and between lines of the floor; chosen. */
const CAMERA_MM = 260, FLOOR_MM = 500;

function segments(points: number[], colour: string): LineSegments {
  const geometry = new BufferGeometry().setAttribute("position", new Float32BufferAttribute(points, 3));
  return new LineSegments(geometry, new LineBasicMaterial({ color: new Color(colour) }));
}

/** The pyramid of a camera: from its centre to the corners of its image. */
export function pyramid(camera: CameraRow): number[] {
  const c = new Vector3(...camera.centre), back = new Matrix3().set(...camera.R[0], ...camera.R[1], ...camera.R[2]).transpose();
  const corner = (u: number, v: number): Vector3 =>
    new Vector3((u - camera.K[0][2]) / camera.K[0][0], (v - camera.K[1][2]) / camera.K[1][1], 1).multiplyScalar(CAMERA_MM).applyMatrix3(back).add(c);
  const w = camera.width || 2 * camera.K[0][2], h = camera.height || 2 * camera.K[1][2];
  const corners = [corner(0, 0), corner(w, 0), corner(w, h), corner(0, h)];
  return corners.flatMap((a, i) => [...c.toArray(), ...a.toArray(), ...a.toArray(), ...corners[(i + 1) % 4]!.toArray()]);
}

export function box([low, high]: readonly [readonly number[], readonly number[]]): number[] {
  const at = (i: number): number[] => [0, 1, 2].map((k) => (i >> k) & 1 ? high[k]! : low[k]!);
  const edges = [0, 1, 2].flatMap((k) => [0, 1, 2, 3, 4, 5, 6, 7].filter((i) => !((i >> k) & 1)).map((i) => [i, i | (1 << k)] as const));
  return edges.flatMap(([a, b]) => [...at(a), ...at(b)]);
}

/** Lines of the floor under a box of places. */
export function floor(low: readonly number[], high: readonly number[], z: number): number[] {
  const from = (k: number): number => Math.floor(low[k]! / FLOOR_MM - 1) * FLOOR_MM;
  const to = (k: number): number => Math.min(Math.ceil(high[k]! / FLOOR_MM + 1) * FLOOR_MM, from(k) + 100 * FLOOR_MM);
  const lines: number[] = [];
  for (let x = from(0); x <= to(0); x += FLOOR_MM) lines.push(x, from(1), z, x, to(1), z);
  for (let y = from(1); y <= to(1); y += FLOOR_MM) lines.push(from(0), y, z, to(0), y, z);
  return lines;
}

/** From a world with Z up to one in which another axis goes up: (x, y, z) is (x, z, −y) where that is Y. */
export const uprightOf = (up: readonly [number, number, number]): Quaternion => new Quaternion().setFromUnitVectors(new Vector3(0, 0, 1), new Vector3(...up));

/** Two corners of a box of the world, as it would be with Z up. */
export function standing(low: readonly number[], high: readonly number[], upright: Quaternion): [number[], number[]] {
  const back = upright.clone().invert(), turned = (at: readonly number[]): number[] => new Vector3(at[0], at[1], at[2]).applyQuaternion(back).toArray();
  const a = turned(low), b = turned(high);
  return [a.map((v, k) => Math.min(v, b[k]!)), a.map((v, k) => Math.max(v, b[k]!))];
}

/** The room of a trial whose markers move between two corners, mm. */
export function room(header: TrialHeader, low: readonly number[], high: readonly number[], palette: Palette): Group {
  const group = new Group(), upright = uprightOf(header.up), [from, to] = standing(low, high, upright);
  const ground = segments(floor(from, to, from[2]! > -200 && from[2]! < 600 ? 0 : from[2]!), palette.line); // another world has its floor elsewhere
  ground.quaternion.copy(upright);
  group.add(ground);
  if (header.volume) group.add(segments(box(header.volume), palette.faint));
  if (header.cameras.length) group.add(segments(header.cameras.flatMap(pyramid), palette.faint));
  return group;
}

/** Give back what the room holds on the graphics card. */
export function clear(group: Group): void {
  for (const child of group.children) {
    if (!(child instanceof LineSegments)) continue;
    child.geometry.dispose();
    (child.material as LineBasicMaterial).dispose();
  }
  group.clear();
}
