/** Every key that the foot shows does what it says there, on every kind of problem. */
import { beforeEach, describe, expect, it, vi } from "vitest";
import type { Act, Action, Problem } from "../src/api/types";
import { byId, footLine } from "../src/keys/commands";
import { get, playhead, set, useStore } from "../src/state/store";
import { alternative, HEADER, path, problem, set as paths } from "./support";

const said: Act[] = [];
vi.mock("../src/api/client", async (real) => ({
  ...(await real<object>()),
  act: (_id: string, _head: string, what: Act) => (said.push(what), Promise.reject(new Error("only looked at"))),
}));
vi.stubGlobal("requestAnimationFrame", () => 1);
vi.stubGlobal("location", { search: "?still", hash: "" });

/** The ways that the server gives for each kind (engine/problems), in some order of their costs. */
const WAYS: Record<Problem["kind"], Action[]> = {
  swap: ["exchange", "keep"], join: ["join", "keep"], ghost: ["no_marker", "keep"], spike: ["keep", "erase"], filled: ["erase", "keep"], label: ["rename", "keep"],
  sides: ["keep", "exchange"], gap: ["fill", "leave_open"], edit: ["drop_edit", "wait"],
  lost: ["note", "keep"], repeated: ["erase", "keep"], moved: ["note", "keep"], shaken: ["erase", "keep"],
};
const KINDS = Object.keys(WAYS) as Problem["kind"][];
/** Keys that are about something else than the problem, on every screen. */
const ELSEWHERE = ["next", "undo", "sign", "print", "help", "up"];

const ways = (kind: Problem["kind"]) => WAYS[kind].map((action) => ({ ...alternative(action, action !== "wait"), words: `way: ${action}` }));

/** What is on the screen where such a problem is looked at. */
function show(kind: Problem["kind"], tracks: string[]): void {
  const one = problem("p1", { kind, tracks, alternatives: ways(kind) });
  const all = { problems: [one, problem("p2")], errors: 1, errors_left: 0.2, worth_looking: 2, head: "" };
  const there = paths(["LKNE", "RKNE", "*3", "*5"].map((name) => path(name, [1, 1, 0, 1, 1, 1])));
  set({ ...useStore.getInitialState(), screen: "tracks", id: "t", header: HEADER, paths: there, problems: all, problem: "p1", selected: tracks });
  playhead.set(11, 6, 100);
  playhead.go(12);
}

/** The acts that a key says, and what was put off by it. */
async function does(id: string): Promise<{ acts: Act[]; later: readonly string[] }> {
  said.length = 0;
  byId(id).run();
  await new Promise((done) => setTimeout(done));
  return { acts: [...said], later: get().later };
}

/** What a key must say, by its words. */
function wanted(id: string, words: string, tracks: string[]): Act[] | null {
  if (words.startsWith("way: ")) {
    const key = words.slice(5);
    return key === "wait" ? [] : [{ kind: "alternative", problem: "p", key }];
  }
  if (id === "exchange") return [{ kind: "exchange", a: tracks[0]!, b: tracks[1]!, first: 12, last: null }];
  if (id === "open") return [{ kind: "alternative", problem: "p", key: "leave_open" }];
  return null;
}

describe.each(KINDS)("the foot on a problem of kind %s", (kind) => {
  const cases = kind === "gap" || kind === "sides" ? [["LKNE", "RKNE"]] : [["LKNE", "RKNE"], ["*3", "*5"], ["LKNE", "*3"]];

  beforeEach(() => void (said.length = 0));

  it.each(cases)("offers with %s and %s only what does what it says", async (...tracks) => {
    show(kind, tracks);
    for (const { id, words } of footLine(get()).filter((one) => !ELSEWHERE.includes(one.id))) {
      show(kind, tracks);
      const { acts, later } = await does(id), must = wanted(id, words, tracks);
      if (id === "later" || words === "way: wait") expect([id, acts, later]).toEqual([id, [], ["p1"]]);
      else if (must) expect([id, acts]).toEqual([id, must]);
      else if (id === "name") expect([acts, get().dialog, words]).toEqual([[], "name", `name ${tracks[0]}`]);
      else if (id === "put") expect([acts, get().clicks, words, tracks[0]!.startsWith("*")]).toEqual([[], [], `put ${tracks[0]} in this frame`, false]);
      else expect([id, words]).toEqual(["", "nothing is known of what it should do"]);
    }
  });

  it("has a key for each way", () => {
    show(kind, ["LKNE", "RKNE"]);
    const line = footLine(get());
    expect(line.find((one) => one.id === "accept")!.words).toBe(`way: ${WAYS[kind][0]}`);
    const second = WAYS[kind][1] === "keep" ? "right" : "take-2"; // Y alone stands for what is right as it is
    expect(line.filter((one) => one.words === `way: ${WAYS[kind][1]}` && one.id !== "drop" && one.id !== "open").map((one) => one.id)).toEqual([second]);
  });

  it("speaks of a gap, of right as it is, and of no marker only where there is such a way", () => {
    show(kind, ["LKNE", "RKNE"]);
    const ids = footLine(get()).map((one) => one.id);
    expect([ids.includes("open"), ids.includes("right"), ids.includes("drop")]).toEqual([kind === "gap", WAYS[kind].indexOf("keep") > 0, ["ghost", "spike", "filled", "repeated", "shaken"].includes(kind)]);
  });
});

describe("marks that somebody made on a problem", () => {
  it("are what Delete is about", async () => {
    show("spike", ["LKNE"]);
    set({ first: 13, last: 14 });
    expect(footLine(get()).find((one) => one.id === "drop")!.words).toBe("erase the marked samples of LKNE");
    expect((await does("drop")).acts).toEqual([{ kind: "erase", marker: "LKNE", first: 13, last: 14 }]);
  });
});

describe("while problems are looked for", () => {
  it("does not say that none is left", () => {
    show("spike", ["LKNE"]);
    set({ problems: null, problem: null });
    expect(footLine(get()).find((one) => one.id === "next")!.words).toBe("problems are being looked for …");
  });
});
