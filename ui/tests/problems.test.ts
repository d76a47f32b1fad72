import { describe, expect, it } from "vitest";
import { actOf, asItIs, changes, dropOf, inOrder, keepOf, nextAfter, ofWhole, proposed, stepProblem, unlikely, worthALook } from "../src/model/problems";
import { alternative, problem } from "./support";

const all = ["a", "b", "c", "d"].map((id) => problem(id)), ids = (of: readonly { id: string }[]): string => of.map((p) => p.id).join("");

describe("the order of problems", () => {
  it("is the server's, by what looking saves", () => {
    expect(ids(inOrder(all, []))).toBe("abcd");
  });

  it("has what was put off at the end, in the same order", () => {
    expect(ids(inOrder(all, ["c", "a"]))).toBe("bdac");
  });
});

describe("the line below which nothing is worth a look", () => {
  const of = { problems: all, worth_looking: 3 };

  it("has what was put off above it, after the others that are worth a look", () => {
    expect(ids(worthALook(of, ["a"]))).toBe("bca");
    expect(ids(unlikely(of, ["a"]))).toBe("d");
  });

  it("is none before the problems are there", () => {
    expect([worthALook(null, []), unlikely(null, [])]).toEqual([[], []]);
  });
});

describe("from one problem to the next", () => {
  it("goes round", () => {
    expect(stepProblem(all, "d", 1)!.id).toBe("a");
    expect(stepProblem(all, "a", -1)!.id).toBe("d");
  });

  it("begins at an end where the one looked at is gone", () => {
    expect(stepProblem(all, "gone", 1)!.id).toBe("a");
    expect(stepProblem(all, null, -1)!.id).toBe("d");
    expect(stepProblem([], null, 1)).toBeNull();
  });

  it("goes on after the one that was settled, though an act may have settled others with it", () => {
    const now = all.filter((p) => p.id !== "b" && p.id !== "c");
    expect(nextAfter(all, "b", now)!.id).toBe("d");
    expect(nextAfter(all, "d", now.slice(0, 1))!.id).toBe("a");
    expect(nextAfter(all, "a", [])).toBeNull();
  });

  it("does not come back at once to one that is still there", () => {
    expect(nextAfter(all, "d", all)!.id).toBe("a");
    expect(nextAfter(all.slice(0, 1), "a", all.slice(0, 1))).toBeNull();
  });
});

describe("alternatives", () => {
  const p = problem("p");

  it("propose the one that costs least, which comes first", () => {
    expect(proposed(p)!.action).toBe("exchange");
    expect(proposed(problem("q", { alternatives: [] }))).toBeNull();
  });

  it("say their act, or that all is right where they have none", () => {
    expect(actOf(p, p.alternatives[0]!)).toEqual({ kind: "alternative", problem: "p", key: "exchange" });
    expect(actOf(p, alternative("keep", false))).toEqual({ kind: "review", problem: "p", right: true });
  });

  it("are told apart: as it is, or otherwise", () => {
    expect(p.alternatives.map(asItIs)).toEqual([false, true]);
    expect(keepOf(p)!.action).toBe("keep");
  });

  it("change the trial, or note what no edit mends", () => {
    const lost = problem("l", { kind: "lost", alternatives: [alternative("note"), alternative("keep")] });
    expect([...p.alternatives, ...lost.alternatives].map(changes)).toEqual([true, false, false, false]);
    expect([ofWhole(lost), ofWhole(p), ofWhole(null), keepOf(lost)!.action]).toEqual([true, false, false, "keep"]);
  });

  it("find the way that takes a ghost or a spike away", () => {
    expect(dropOf(p)).toBeNull();
    for (const action of ["no_marker", "erase"] as const) expect(dropOf(problem("g", { alternatives: [alternative("keep"), alternative(action)] }))!.action).toBe(action);
  });
});
