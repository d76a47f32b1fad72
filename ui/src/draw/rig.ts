/** A calibration in space: cameras, volume, and its standard deviation in mm as colours of dots. */
import { Vector3 } from "three";
import type { CalibrationShown } from "../api/sessions";
import type { Dot, Line, Place } from "./Flat";
import { palette, rgb } from "./palette";
import { box, floor, pyramid, standing, uprightOf } from "./room";

/** Flat numbers, six a segment, as lines. */
const lines = (flat: readonly number[], colour: string, width?: number): Line[] =>
  Array.from({ length: flat.length / 6 }, (_, i) => ({ a: flat.slice(6 * i, 6 * i + 3) as unknown as Place, b: flat.slice(6 * i + 3, 6 * i + 6) as unknown as Place, colour, width }));

/** Good to bad between two colours of the theme. */
export function shade(share: number): string {
  const p = palette(), from = rgb(p.measured), to = rgb(p.a), s = Math.min(1, Math.max(0, share));
  return `rgb(${from.map((v, k) => Math.round(255 * (v + s * (to[k]! - v)))).join(" ")})`;
}

/** mm at which colours begin and end. */
export function span(of: CalibrationShown, lost: string | null): [number, number] {
  const all = [...of.map.sd_mm, ...(lost ? of.map.lost[lost]! : [])].filter((v): v is number => v !== null).sort((a, b) => a - b);
  return [all[Math.floor(0.02 * (all.length - 1))] ?? 0, all[Math.floor(0.98 * (all.length - 1))] ?? 1];
}

export function rigDrawn(of: CalibrationShown, lost: string | null): { lines: Line[]; dots: Dot[]; low: Place; high: Place; up: Place } {
  const p = palette(), [low, high] = of.volume as unknown as [Place, Place], up = [0, 1, 2].map((k) => +(k === of.map.axis)) as unknown as Place, places = [low, high, ...of.cameras.map((c) => c.centre as Place)];
  const ends = (pick: (...v: number[]) => number): Place => [0, 1, 2].map((k) => pick(...places.map((at) => at[k]!))) as unknown as Place;
  const cameras = of.cameras.flatMap((c) => lines(pyramid(c), c.name === lost ? p.bad : p.ink, c.name === lost ? 1 : 1.4));
  const names = of.cameras.map((c): Dot => ({ at: c.centre as Place, colour: c.name === lost ? p.bad : p.ink, size: 3, words: c.name === lost ? `${c.name} lost` : c.name }));
  return {
    lines: [...lines(ground(low, ends(Math.min), ends(Math.max), up), p.line), ...lines(box([low, high]), p.faint), ...cameras],
    dots: [...errors(of, lost), ...names], low: ends(Math.min), high: ends(Math.max), up,
  };
}

/** Lines of the floor that the volume stands on, under all between two corners. */
function ground(volume: Place, low: Place, high: Place, up: Place): number[] {
  const upright = uprightOf(up), [from, to] = standing(low, high, upright), level = new Vector3(...volume).applyQuaternion(upright.clone().invert()).z;
  const flat = floor(from, to, level);
  return Array.from({ length: flat.length / 3 }, (_, i) => new Vector3().fromArray(flat, 3 * i).applyQuaternion(upright).toArray()).flat();
}

function errors(of: CalibrationShown, lost: string | null): Dot[] {
  const { x, y, z, sd_mm, axis, level_mm } = of.map, p = palette(), [least, most] = span(of, lost), axes = [x, y, z];
  const dot = (at: Place, sd: number | null, size: number): Dot => ({ at, colour: sd === null ? p.missing : shade((sd - least) / Math.max(most - least, 1e-9)), size: sd === null ? 1.5 : size });
  if (!lost) return x.flatMap((a, i) => y.flatMap((b, j) => z.map((c, k) => dot([a, b, c], sd_mm[(i * y.length + j) * z.length + k]!, 2.2))));
  const [m, n] = [0, 1, 2].filter((k) => k !== axis) as [number, number];
  return axes[m]!.flatMap((a, i) => axes[n]!.map((b, j) => {
    const at = [0, 0, 0];
    (at[m] = a), (at[n] = b), (at[axis] = level_mm);
    return dot(at as unknown as Place, of.map.lost[lost]![i * axes[n]!.length + j]!, 4);
  }));
}
