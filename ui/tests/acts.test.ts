/** Acts go out one after another, and none waits for the problems to be looked for. */
import { expect, it, vi } from "vitest";
import type { Act, PathsPart, Problems, TrialHeader } from "../src/api/types";
import { act, choose, lookAt, step } from "../src/state/acts";
import { get, set, useStore, watched } from "../src/state/store";
import { alternative, HEADER, path, problem, PROBLEMS, set as paths } from "./support";

const answer: { paths: PathsPart | null; header?: TrialHeader; outcomes?: object[]; changed?: readonly string[] } = vi.hoisted(() => ({ paths: null }));
const shown: { paths: PathsPart | null } = vi.hoisted(() => ({ paths: null }));
const said: Act[] = [], answers: ((problems: Problems) => void)[] = [];
vi.mock("../src/api/client", async (real) => ({
  ...(await real<object>()),
  act: (_id: string, _head: string, what: Act) => (said.push(what), Promise.resolve({ entry: 1, outcomes: [], head: "", changed: [], removed: [], header: HEADER, ...answer })),
  preview: () => Promise.resolve(shown.paths && { outcomes: [], changed: ["LKNE"], removed: [], paths: shown.paths, join: null }),
  problems: () => new Promise<Problems>((done) => answers.push(done)),
}));
vi.stubGlobal("requestAnimationFrame", (draw: () => void) => (queueMicrotask(draw), 1));
vi.stubGlobal("location", { search: "?still", hash: "" });

/** ms after which the page was drawn, and what was asked for then is under way. */
const DRAWN_MS = 20;
const soon = (): Promise<unknown> => new Promise((done) => setTimeout(done, DRAWN_MS));
const base64Of = (of: ArrayBufferView): string => btoa(String.fromCharCode(...new Uint8Array(of.buffer)));
const show = (): void => {
  said.length = answers.length = 0;
  set({ ...useStore.getInitialState(), screen: "tracks", id: "t", header: HEADER, paths: paths([]), problems: PROBLEMS, problem: "p1" });
};

it("says a second act while the problems after the first are still looked for", async () => {
  show();
  await act({ kind: "finish" });
  await soon();
  await act({ kind: "undo" });
  await soon();
  expect([said.length, answers.length]).toEqual([2, 2]);
});

it("looks once for the problems after acts that are said faster than the page is drawn", async () => {
  show();
  await act({ kind: "finish" });
  await act({ kind: "undo" });
  await soon();
  expect([said.length, answers.length]).toEqual([2, 1]);
});

it("takes the paths that an act brings, and nothing of the others", async () => {
  show();
  const [a, b] = [path("A", [1, 1]), path("B", [1, 1])], xyz = new Float32Array([1, 2, 3, NaN, NaN, NaN]);
  set({ paths: { ...paths([a, b]), frames: 2 } });
  answer.paths = { names: ["A"], first_frame: 11, n_frames: 2, xyz: base64Of(xyz), sd: base64Of(new Float32Array([0.5, NaN])), origin: base64Of(new Uint8Array([3, 0])) };
  await act({ kind: "finish" });
  const now = get().paths!.byName;
  expect(now.get("B")).toBe(b);
  expect([[...now.get("A")!.xyz], [...now.get("A")!.sd], [...now.get("A")!.origin]]).toEqual([[...xyz], [0.5, NaN], [3, 0]]);
  answer.paths = null;
});

it("takes the problems that were looked for last, in whatever order they come", async () => {
  show();
  await act({ kind: "finish" });
  await soon();
  await act({ kind: "undo" });
  await soon();
  answers[1]!({ ...PROBLEMS, head: "new" });
  await soon();
  answers[0]!({ ...PROBLEMS, head: "old" });
  await soon();
  expect(get().problems!.head).toBe("new");
});

it("offers no key for a problem that was settled, and goes to the next when the problems are there", async () => {
  show();
  const taken = choose(PROBLEMS.problems[0]!, "exchange");
  await soon();
  expect(get().problems!.problems.map((p) => p.id)).toEqual(["p2"]);
  answers[0]!({ ...PROBLEMS, problems: [problem("p3"), problem("p2")] });
  await taken;
  expect([said.length, get().problem]).toEqual([1, "p2"]);
});

it("leaves a person who went on where they are", async () => {
  show();
  const taken = choose(PROBLEMS.problems[0]!, "exchange");
  await soon();
  set({ problem: "p2" });
  answers[0]!({ ...PROBLEMS, problems: [problem("p3"), problem("p2")] });
  await taken;
  expect(get().problem).toBe("p2");
});

it("goes with a track that was named as a whole, and stays with one that has samples left", async () => {
  const track = (name: string, samples: number): TrialHeader["tracks"][number] => ({ ...HEADER.tracks[0]!, name, samples });
  for (const left of [0, 5]) {
    show();
    set({ selected: ["OLD", "B"] });
    answer.header = { ...HEADER, tracks: [track("OLD", left), track("NEW", 9), track("B", 9)] };
    await act({ kind: "claim", track: "OLD", name: "NEW" });
    expect(get().selected).toEqual([left ? "OLD" : "NEW", "B"]);
  }
  delete answer.header;
});

it("says of an act what of it does not hold, and not what had nothing to do beside what was done", async () => {
  const one = (outcome: string): object => ({ entry: 1, outcome, reason: "why", words: "Finish", samples: 1, share: 1 });
  for (const [outcomes, kind] of [[["held", "moot"], "done"], [["held", "orphan", "moot"], "news"], [["moot", "moot"], "news"]] as const) {
    show();
    answer.outcomes = outcomes.map(one);
    await act({ kind: "finish" });
    expect(get().note?.kind).toBe(kind);
  }
  delete answer.outcomes;
});

it("goes through what is worth a look, and through the others where they are shown", () => {
  show();
  set({ problems: { ...PROBLEMS, worth_looking: 1 }, problem: "p1" });
  step(1);
  expect(get().problem).toBe("p1");
  set({ unlikely: true });
  step(1);
  expect(get().problem).toBe("p2");
  set({ unlikely: false, problem: null, note: null, problems: { ...PROBLEMS, worth_looking: 0 } });
  step(1);
  expect([get().problem, get().note?.words.includes("2 problems below 5 %")]).toEqual([null, true]);
});

it("counts a settled problem no more while the others are looked for", async () => {
  show();
  const taken = choose(PROBLEMS.problems[0]!, "exchange");
  await soon();
  expect(get().problems!.worth_looking).toBe(1);
  answers[0]!({ ...PROBLEMS, problems: [problem("p2")], worth_looking: 0 });
  await taken;
  expect(get().problem).toBeNull();
});

it("selects nothing on a problem of all markers, shows them, and draws nothing where nothing would change", async () => {
  show();
  const lost = problem("l", { kind: "lost", alternatives: [alternative("note"), alternative("keep")] });
  set({ problems: { ...PROBLEMS, problems: [lost], worth_looking: 1 }, paths: paths([path("LKNE", [1, 1]), path("*3", [1, 1])]) });
  lookAt(lost);
  expect([get().selected, watched(get()), get().instead]).toEqual([[], ["LKNE", "*3"], null]);
  const taken = choose(lost, "note");
  await soon();
  expect(get().note!.words).toBe("Noted; the trial stays as it is.");
  answers.at(-1)!({ ...PROBLEMS, problems: [], worth_looking: 0 });
  await taken;
});

it("draws a spike's erasing straight across the samples that are lost", async () => {
  show();
  const spike = problem("s", { kind: "spike", tracks: ["LKNE"], frame: 13, alternatives: [alternative("erase"), alternative("keep")] }), none = new Float32Array([NaN, NaN, NaN]);
  shown.paths = { names: ["LKNE"], first_frame: 13, n_frames: 1, xyz: base64Of(none), sd: base64Of(none.subarray(0, 1).slice()), origin: base64Of(new Uint8Array(1)) };
  set({ problems: { ...PROBLEMS, problems: [spike], worth_looking: 1 }, paths: paths([path("LKNE", [1, 1, 1, 1, 1, 1])]) });
  lookAt(spike);
  await soon();
  expect([[...get().instead!.paths[0]!.origin], get().instead!.straight]).toEqual([[0, 2, 2, 2, 0, 0], true]);
  shown.paths = null;
});

it("passes over problems whose tracks were changed, where another one need not be waited for", async () => {
  const touched = problem("p2", { tracks: ["RKNE"] }), other = problem("p3", { tracks: ["extra"] });
  show();
  set({ problems: { ...PROBLEMS, problems: [PROBLEMS.problems[0]!, touched, other], worth_looking: 3 } });
  answer.changed = ["RKNE"];
  answer.paths = { names: ["RKNE"], first_frame: 11, n_frames: 6, xyz: base64Of(new Float32Array(18)), sd: base64Of(new Float32Array(6)), origin: base64Of(new Uint8Array(6)) };
  const taken = choose(PROBLEMS.problems[0]!, "exchange");
  await soon();
  expect(get().problem).toBe("p3");
  answers[0]!({ ...PROBLEMS, problems: [touched, other], worth_looking: 2 });
  await taken;
  expect(get().problem).toBe("p3");
  step(1);
  expect(get().problem).toBe("p2");
  delete answer.changed;
  answer.paths = null;
});

it("goes on at once to a problem of tracks that were not changed, and waits where they were", async () => {
  const other = problem("p2", { tracks: ["RKNE", "extra"] });
  for (const [changed, at] of [[["LKNE"], "p2"], [["RKNE"], "p1"]] as const) {
    show();
    set({ problems: { ...PROBLEMS, problems: [PROBLEMS.problems[0]!, other] } });
    answer.changed = changed;
    answer.paths = { names: [...changed], first_frame: 11, n_frames: 6, xyz: base64Of(new Float32Array(18)), sd: base64Of(new Float32Array(6)), origin: base64Of(new Uint8Array(6)) };
    const taken = choose(PROBLEMS.problems[0]!, "exchange");
    await soon();
    expect(get().problem).toBe(at);
    answers[0]!({ ...PROBLEMS, problems: [other], worth_looking: 1 });
    await taken;
    expect(get().problem).toBe("p2");
  }
  delete answer.changed;
  answer.paths = null;
});
