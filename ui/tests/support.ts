import type { Action, Alternative, Problem, Problems, TrialHeader } from "../src/api/types";
import type { Path, PathSet } from "../src/model/paths";

export const HEADER = {
  id: "t", name: "walk01", session: null, rate: 100, first_frame: 11, n_frames: 6,
  tracks: ["*3", "RKNE", "extra", "LKNE"].map((name) => ({ name, named: !name.startsWith("*"), first: 11, last: 16, samples: 6, probability: null, runner_up: null })),
  cameras: [], volume: null, up: [0, 0, 1], marker_set: { name: "", names: ["LKNE", "RKNE"], places: {}, faces: {}, meaning: {}, links: [] }, pairs: [["LKNE", "RKNE"]], one_sided: [],
  events: [], trim: [11, 16], named_only: false, head: "", edits: 0, undo: 1, redo: null, version: "", by: "", has_images: false, has_detections: false, mosaic: null, methods: [], last: null, stale: "",
} as unknown as TrialHeader;

export function alternative(action: Action, says = true): Alternative {
  return { key: action, action, words: action, consequence: "", probability: 0.5, cost: 1, jump_mm: null, images: null, act: says ? { kind: "alternative", problem: "p", key: action } : null };
}

export function problem(id: string, some: Partial<Problem> = {}): Problem {
  return {
    id, kind: "swap", words: "", tracks: ["LKNE", "*3"], first: 12, last: 13, frame: 12, wrong: 0.5, at_stake: 10, cost_mm: 20, images: [],
    cost: 100, alternatives: [{ ...alternative("exchange"), words: "Exchange them" }, alternative("keep")],
    ...some,
  };
}

export const PROBLEMS = { problems: [problem("p1"), problem("p2")], errors: 1, errors_left: 0.2, worth_looking: 2, head: "" } as Problems;

/** A path whose sample i is at (i, 10 i, 0), missing where its origin is 0. */
export function path(name: string, origin: number[]): Path {
  const xyz = Float32Array.from(origin.flatMap((o, i) => (o ? [i, 10 * i, 0] : [NaN, NaN, NaN])));
  return { name, xyz, sd: Float32Array.from(origin.map((o) => (o ? 1 : NaN))), origin: Uint8Array.from(origin) };
}

export const set = (paths: readonly Path[]): PathSet => ({ firstFrame: 11, frames: 6, head: "", pending: false, byName: new Map(paths.map((p) => [p.name, p])) });
