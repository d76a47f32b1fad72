import { describe, expect, it } from "vitest";
import type { CameraRow } from "../src/api/types";
import { epipolarLine, project, ray } from "../src/model/camera";

/** A camera at a place that looks along −X or −Y towards the origin, with a lens. */
function camera(name: string, centre: [number, number, number], R: CameraRow["R"]): CameraRow {
  const t = R.map((row) => -(row[0] * centre[0] + row[1] * centre[1] + row[2] * centre[2])) as [number, number, number];
  return { name, width: 1280, height: 1024, centre, R, t, K: [[900, 0.5, 640], [0, -905, 512], [0, 0, 1]], distortion: [-0.21, 0.06, 0.001, -0.0007, 0.01] };
}
const A = camera("a", [4000, 0, 900], [[0, 1, 0], [0, 0, -1], [-1, 0, 0]]), B = camera("b", [0, 4000, 900], [[-1, 0, 0], [0, 0, -1], [0, -1, 0]]);

describe("a camera with a lens", () => {
  it("looks with its rays where it projects from", () => {
    const place = [120, -260, 700] as const, [u, v] = project(A, ...place)!, d = ray(A, u, v);
    const s = (place[0] - A.centre[0]) / d[0];
    for (const k of [0, 1, 2] as const) expect(A.centre[k] + s * d[k]).toBeCloseTo(place[k], 3);
  });

  it("sees nothing behind itself", () => {
    expect(project(A, 5000, 0, 900)).toBeNull();
  });

  it("draws epipolar lines through the image of the place", () => {
    const place = [120, -260, 700] as const, [u, v] = project(A, ...place)!, at = project(B, ...place)!, line = epipolarLine(A, u, v, B);
    const off = Math.min(...line.slice(1).map((q, i) => distance(at, line[i]!, q)));
    expect(off).toBeLessThan(0.5);
  });
});

/** px of a point to the piece between two others. */
function distance([x, y]: [number, number], [ax, ay]: [number, number], [bx, by]: [number, number]): number {
  const dx = bx - ax, dy = by - ay, s = Math.min(1, Math.max(0, ((x - ax) * dx + (y - ay) * dy) / (dx * dx + dy * dy)));
  return Math.hypot(x - ax - s * dx, y - ay - s * dy);
}
