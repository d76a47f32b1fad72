import { describe, expect, it } from "vitest";
import { decodeDetections, detectedIn } from "../src/model/detections";
import { besideCurves, changedPaths, decodePaths, exchanged, gapsOf, jump, leftOpen, mergePaths, runs, speed, straightAcross, whole } from "../src/model/paths";
import { path, set } from "./support";
import type { GapRow } from "../src/api/types";

function body(...parts: (Float32Array | Uint8Array | Uint32Array | Int32Array)[]): ArrayBuffer {
  const bytes = parts.flatMap((p) => [...new Uint8Array(p.buffer, p.byteOffset, p.byteLength)]);
  return Uint8Array.from(bytes).buffer;
}

describe("paths as they come", () => {
  const header = { view: "edited" as const, names: ["A", "B"], first_frame: 5, n_frames: 3, columns: ["xyz", "sd", "origin", "residual"] as const, head: "h", pending: false };
  const xyz = Float32Array.from({ length: 18 }, (_, i) => i), sd = Float32Array.from([1, 2, 3, 4, 5, 6]), origin = Uint8Array.from([1, 0, 1, 1, 1, 2]);
  const residual = Float32Array.from([6, 5, 4, 3, 2, 1]);

  it("are read column by column, also where floats follow bytes", () => {
    const got = decodePaths({ ...header, columns: [...header.columns] }, body(xyz, sd, origin, residual)), b = got.byName.get("B")!;
    expect([...b.xyz]).toEqual([9, 10, 11, 12, 13, 14, 15, 16, 17]);
    expect([...b.sd]).toEqual([4, 5, 6]);
    expect([...b.origin]).toEqual([1, 1, 2]);
    expect([...b.residual!]).toEqual([3, 2, 1]);
  });

  it("are refused where bytes are missing", () => {
    expect(() => decodePaths({ ...header, columns: [...header.columns] }, body(xyz, sd))).toThrow(/wanted/);
  });
});

describe("a set of paths", () => {
  it("shares what an edit did not change", () => {
    const a = path("A", [1, 1, 1, 1, 1, 1]), b = path("B", [1, 1, 1, 1, 1, 1]), now = mergePaths(set([a, b]), set([path("A", [1, 0, 1, 1, 1, 1])]), ["gone"]);
    expect(now.byName.get("B")).toBe(b);
    expect(now.byName.get("A")).not.toBe(a);
  });

  it("takes what an act changed: samples laid over others, the same ones under another name, and new ones", () => {
    const text = (...values: (Float32Array | Uint8Array)[]): string => btoa(String.fromCharCode(...new Uint8Array(body(...values))));
    const a = path("A", [1, 1, 1, 1, 1, 1]), whole = { ...set([a, path("B", [1, 1, 0, 0, 1, 1])]), firstFrame: 11 }, nothing = { xyz: "", sd: "", origin: "" };
    const renamed = changedPaths(whole, { names: ["C"], bases: ["A"], first_frame: 11, n_frames: 0, ...nothing }).byName.get("C")!;
    expect([renamed.name, renamed.xyz, renamed.origin]).toEqual(["C", a.xyz, a.origin]);
    expect(renamed.xyz).toBe(a.xyz);
    const two = { xyz: text(Float32Array.from({ length: 12 }, (_, i) => i)), sd: text(Float32Array.from([1, 2, 3, 4])), origin: text(Uint8Array.from([3, 0, 2, 2])) };
    const laid = changedPaths(whole, { names: ["A", "D"], bases: ["A", ""], first_frame: 13, n_frames: 2, ...two }).byName;
    expect([...laid.get("A")!.origin]).toEqual([1, 1, 3, 0, 1, 1]);
    expect([...laid.get("A")!.xyz.subarray(3, 12)]).toEqual([...a.xyz.subarray(3, 6), 0, 1, 2, 3, 4, 5]);
    expect([...laid.get("D")!.origin]).toEqual([0, 0, 2, 2, 0, 0]);
    expect([...a.origin]).toEqual([1, 1, 1, 1, 1, 1]);
  });

  it("exchanged twice is as it was", () => {
    const a = path("A", [1, 1, 1, 1, 1, 1]), b = path("B", [0, 2, 2, 2, 2, 0]), [c, d] = exchanged(...exchanged(a, b, 2, 5), 2, 5);
    expect([...c.origin]).toEqual([...a.origin]);
    expect([...d.xyz]).toEqual([...b.xyz]);
  });
});

it("draws beside the curves of many markers what would be of those that are shown", () => {
  const names = ["A", "B", "C", "D", "E"], instead = names.map((name) => path(name, [1]));
  expect(besideCurves(instead, names).map((p) => p.name)).toEqual(["A", "B", "C", "D"]);
  expect(besideCurves(instead, ["A"])).toBe(instead);
});

it("runs follow one another and cover all frames", () => {
  const all = runs(Uint8Array.from([1, 1, 0, 0, 2]));
  expect(all).toEqual([{ start: 0, end: 2, origin: 1 }, { start: 2, end: 4, origin: 0 }, { start: 4, end: 5, origin: 2 }]);
});

it("speed and jumps are those of the samples, and nothing beside a gap", () => {
  const p = path("A", [1, 1, 1, 0, 1, 1]), step = Math.hypot(1, 10);
  expect(speed(p, 100)[1]).toBeCloseTo(100 * step, 3);
  expect(speed(p, 100)[2]).toBeNaN();
  expect(jump(p, 1)).toBeCloseTo(step, 4);
  expect(jump(p, 4)).toBeNaN();
});

it("detections are found by camera and frame", () => {
  const counts = Uint32Array.from([1, 0, 2, 1]), uv = Float32Array.from([1, 2, 3, 4, 5, 6, 7, 8]), track = Int32Array.from([0, 1, -1, 2]), validity = Uint8Array.from([0, 0, 1, 0]);
  const all = decodeDetections({ cameras: ["a", "b"], first: 7, last: 8, detections: 4, head: "" }, body(counts, uv, track, validity));
  expect(detectedIn(all, 0, 7)).toEqual([0, 1]);
  expect(detectedIn(all, 0, 8)).toEqual([1, 1]);
  expect(detectedIn(all, 1, 7)).toEqual([1, 3]);
  expect(detectedIn(all, 1, 9)).toEqual([0, 0]);
  expect(all.track[2]).toBe(-1);
});

describe("gaps that a file would have", () => {
  it("are those between samples, however they were filled", () => {
    expect(gapsOf([path("A", [0, 1, 0, 0, 1, 0]), path("B", [1, 2, 1, 0, 1, 0]), path("C", [1, 1, 2, 2, 1, 1]), path("D", [0, 0, 0, 0, 0, 0])])).toEqual({ gaps: 2, markers: 2 });
    expect(gapsOf([path("A", [1, 0, 1, 0, 0, 1])])).toEqual({ gaps: 2, markers: 1 });
  });

  it("are none where somebody chose how to fill them, though the fill is not there yet", () => {
    const row = (marker: string, choice: string | null): GapRow => ({ marker, choice }) as GapRow;
    expect(leftOpen([row("A", "quintic"), row("A", null), row("A", "open"), row("B", "best")])).toEqual({ gaps: 2, markers: 1 });
  });
});

describe("a path without some of its samples", () => {
  const own = path("A", [1, 1, 1, 1, 1, 1]), lost = (n: number): ReturnType<typeof path> => path("A", Array<number>(n).fill(0));
  const off = { ...own, xyz: own.xyz.map((v, i) => (i === 7 ? v + 500 : v)) }; // a spike in the third frame

  it("goes straight from the sample before to the one behind", () => {
    const would = whole([lost(2)], 13, set([off]))[0]!, drawn = straightAcross(off, would, 2, 4);
    expect([...drawn.origin]).toEqual([0, 2, 2, 2, 2, 0]);
    expect([...drawn.xyz.subarray(3, 15)]).toEqual([1, 10, 0, 2, 20, 0, 3, 30, 0, 4, 40, 0]);
  });

  it("has no line where nothing is kept on one side, where nothing is lost, or where nothing is known of it", () => {
    const end = whole([lost(2)], 15, set([own]))[0]!, same = path("A", [0, 1, 1, 0, 0, 0]);
    expect(straightAcross(own, end, 4, 6)).toBe(end);
    expect(straightAcross(own, same, 1, 3)).toBe(same);
    expect(straightAcross(undefined, same, 1, 3)).toBe(same);
  });

  it("goes across a gap that was beside them", () => {
    const gappy = path("A", [1, 1, 0, 1, 1, 1]), would = whole([lost(1)], 12, set([gappy]))[0]!;
    expect([...straightAcross(gappy, would, 1, 2).origin]).toEqual([2, 2, 2, 2, 0, 0]);
  });
});
