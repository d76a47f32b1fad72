/** Acts go out one after another, and none waits for the problems to be looked for. */
import { expect, it, vi } from "vitest";
import type { Act, Problems } from "../src/api/types";
import { act, choose } from "../src/state/acts";
import { get, set, useStore } from "../src/state/store";
import { HEADER, problem, PROBLEMS, set as paths } from "./support";

const said: Act[] = [], answers: ((problems: Problems) => void)[] = [];
vi.mock("../src/api/client", async (real) => ({
  ...(await real<object>()),
  act: (_id: string, _head: string, what: Act) => (said.push(what), Promise.resolve({ entry: 1, outcomes: [], head: "", changed: [], removed: [], header: HEADER })),
  problems: () => new Promise<Problems>((done) => answers.push(done)),
}));
vi.stubGlobal("requestAnimationFrame", () => 1);
vi.stubGlobal("location", { search: "?still", hash: "" });

const soon = (): Promise<unknown> => new Promise((done) => setTimeout(done));
const show = (): void => {
  said.length = answers.length = 0;
  set({ ...useStore.getInitialState(), screen: "tracks", id: "t", header: HEADER, paths: paths([]), problems: PROBLEMS, problem: "p1" });
};

it("says a second act while the problems after the first are still looked for", async () => {
  show();
  await act({ kind: "finish" });
  await act({ kind: "undo" });
  expect([said.length, answers.length]).toEqual([2, 2]);
});

it("takes the problems that were looked for last, in whatever order they come", async () => {
  show();
  await act({ kind: "finish" });
  await act({ kind: "undo" });
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
