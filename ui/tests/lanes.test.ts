import { describe, expect, it } from "vitest";
import { fitting } from "../src/model/format";
import { frameAt, moved, painted, pieces, placeOf, rowOrder, showing, zoomed } from "../src/model/lanes";
import { HEADER, path, set } from "./support";

describe("pieces of a lane", () => {
  it("cover the whole width, one after the other", () => {
    const all = pieces(Uint8Array.from([1, 1, 0, 2, 2, 3]), 60);
    expect(all.map((p) => [p.x, p.width, p.origin])).toEqual([[0, 20, 1], [20, 10, 0], [30, 20, 2], [50, 10, 3]]);
  });

  it("show a gap of one frame in a hundred thousand, and paint it last", () => {
    const origin = new Uint8Array(100_000).fill(1);
    origin[50_000] = 0;
    const gap = painted(pieces(origin, 1000)).at(-1)!;
    expect(gap.origin).toBe(0);
    expect(gap.width).toBeGreaterThanOrEqual(1);
  });
});

describe("places and frames", () => {
  it("are each other's inverse", () => {
    for (const frame of [11, 12, 500, 1010]) expect(frameAt(placeOf(frame, 777, 11, 1000), 777, 11, 1000)).toBe(frame);
  });

  it("stay within the trial", () => {
    expect(frameAt(-50, 100, 11, 6)).toBe(11);
    expect(frameAt(900, 100, 11, 6)).toBe(16);
  });
});

it("rows are in the order of the marker set, then other names, then tracks without one", () => {
  const paths = set(["*3", "RKNE", "extra", "LKNE"].map((name) => path(name, [1, 1, 1, 1, 1, 1])));
  expect(rowOrder(HEADER, paths)).toEqual(["LKNE", "RKNE", "extra", "*3"]);
});

it("rows of names without a sample come last, and a marker of the set keeps its place", () => {
  const paths = set(["probe", "*3", "RKNE", "extra", "LKNE"].map((name) => path(name, [1, 1, 1, 1, 1, 1])));
  const tracks = ["probe", "*3", "RKNE", "extra", "LKNE"].map((name) => ({ ...HEADER.tracks[0]!, name, samples: name === "probe" || name === "RKNE" ? 0 : 6 }));
  expect(rowOrder({ ...HEADER, tracks }, paths)).toEqual(["LKNE", "RKNE", "extra", "*3", "probe"]);
});

describe("names of rows", () => {
  const width = (words: string): number => 5 * words.length;

  it("are whole where there is room", () => expect(fitting("r head backb", 60, width)).toBe("r head backb"));
  it("lose no more of their middle than they must", () => {
    expect(fitting("right head back b", 60, width)).toBe("right h…ck b");
    expect(fitting("right head back b", 1, width)).toBe("r…ck b");
  });
});

describe("a part of the time", () => {
  const all = [1, 1000] as const;

  it("keeps the frame under the pointer where it is, and stays within the trial", () => {
    const closer = zoomed(null, 250, 0.5, all)!;
    for (const [span, by] of [[closer, 0.5], [closer, 1.5]] as const) {
      const next = zoomed(span, 250, by, all)!, place = ([a, b]: readonly [number, number]): number => (250 - a) / (b - a);
      expect(place(next)).toBeCloseTo(place(span), 2);
    }
    expect(zoomed(null, 1000, 0.25, all)).toEqual([750, 1000]);
    expect(zoomed(null, 1, 0.25, all)).toEqual([1, 251]);
  });

  it("is all of it where it would be more, and never less than single frames", () => {
    expect(zoomed([400, 600], 500, 100, all)).toBeNull();
    let span = zoomed(null, 500, 0.01, all);
    for (let k = 0; k < 20; k++) span = zoomed(span, 500, 0.5, all);
    expect(span![1] - span![0]).toBe(10);
    expect(zoomed(null, 2, 0.5, [1, 4])).toBeNull();
  });

  it("goes on with the frame: by pages where time goes on, about it where it leaps", () => {
    expect(showing([100, 200], 150, all)).toEqual([100, 200]);
    expect(showing([100, 200], 201, all)).toEqual([201, 301]);
    expect(showing([100, 200], 950, all)).toEqual([900, 1000]);
    expect(showing([100, 200], 40, all)).toEqual([1, 101]);
    expect(moved([100, 200], -50, all)).toEqual([1, 101]);
    expect(showing(null, 40, all)).toBeNull();
  });
});
