/** What a way to settle a problem would give is drawn as it is pointed at. */
import { beforeEach, expect, it, vi } from "vitest";
import type { GapCandidates, Problem } from "../src/api/types";
import { about, ofWhole } from "../src/model/problems";
import { lookAt, windowOf } from "../src/state/acts";
import { drawInstead } from "../src/state/instead";
import { get, playhead, set, useStore, watched } from "../src/state/store";
import { alternative, HEADER, path, problem, PROBLEMS, set as paths } from "./support";

const candidates: GapCandidates = vi.hoisted(() => ({
  marker: "LKNE", first: 13, last: 13, head: "", pending: false, best: "cubic",
  candidates: [{ method: "linear", expected_mm: 1, xyz: [[2, 20, 7]], sd: null }, { method: "cubic", expected_mm: 2, xyz: [[2, 20, 9]], sd: null }],
}));
vi.mock("../src/api/client", async (real) => ({ ...(await real<object>()), gap: (_id: string, marker: string) => Promise.resolve({ ...candidates, marker }) }));
vi.stubGlobal("requestAnimationFrame", () => 1);
vi.stubGlobal("location", { search: "?still", hash: "" });

const way = (method: string) => ({ ...alternative("fill"), key: `fill-${method}`, words: `fill by ${method}` });
const gap = (...tracks: string[]): Problem => problem("g", { kind: "gap", tracks, first: 13, last: 13, frame: 13, alternatives: [way("best"), way("linear"), alternative("leave_open")] });
const soon = (): Promise<unknown> => new Promise((done) => setTimeout(done, 5));

beforeEach(() => {
  const open = (name: string) => path(name, [1, 1, 0, 1, 1, 1]);
  set({ ...useStore.getInitialState(), screen: "tracks", id: "t", header: HEADER, paths: paths(["LKNE", "RKNE", "A", "B", "C"].map(open)) });
  playhead.set(11, 6, 100);
});

it("draws a fill on Tracks too, joined to the samples beside it, and another as that is pointed at", async () => {
  const one = gap("LKNE");
  set({ problems: { ...PROBLEMS, problems: [one] } });
  lookAt(one);
  await soon();
  const z = (): number[] => [...get().instead!.paths[0]!.xyz].filter((_, k) => k % 3 === 2);
  expect([get().instead!.key, z()]).toEqual(["fill-best", [NaN, 0, 9, 0, NaN, NaN]]);
  await drawInstead(one, "fill-linear");
  expect([get().instead!.key, z()]).toEqual(["fill-linear", [NaN, 0, 7, 0, NaN, NaN]]);
  await drawInstead(one, "leave_open");
  expect(get().instead!.key).toBe("fill-linear");
});

it("looks at gaps of many markers in the same frames as one, and draws the fills of those that curves show", async () => {
  const one = gap("LKNE", "RKNE", "A", "B", "C");
  set({ problems: { ...PROBLEMS, problems: [one] } });
  lookAt(one);
  await soon();
  expect([get().selected, watched(get()), about(one), ofWhole(one)]).toEqual([[], one.tracks, "5 markers", true]);
  expect(get().instead!.paths.map((p) => p.name).sort()).toEqual(["A", "B", "LKNE", "RKNE"]);
  expect([about(gap("A", "B")), ofWhole(gap("A", "B"))]).toEqual(["A, B", false]);
});

it("shows as much of a marker beside a long gap as the gap is long", () => {
  playhead.set(1, 2000, 100);
  expect(windowOf(problem("p", { first: 500, last: 510, frame: 500 }), 100)).toEqual([380, 630]);
  expect(windowOf(problem("p", { first: 500, last: 1300, frame: 500 }), 100)).toEqual([100, 1700]);
  expect(windowOf(problem("p", { first: 1, last: 1900, frame: 1 }), 100)).toEqual([1, 721]);
});
