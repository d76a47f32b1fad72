import { describe, expect, it } from "vitest";
import { actOf, dropOf, expectedCost, orderProblems, stepProblem } from "../src/model/problems";
import { problem } from "./support";

describe("the order of problems", () => {
  it("is by what is expected to be lost: probability × samples × mm", () => {
    const probable = problem("a", { wrong: 0.9, at_stake: 10, cost_mm: 10 }), costly = problem("b", { wrong: 0.3, at_stake: 400, cost_mm: 10 });
    expect(expectedCost(costly)).toBeCloseTo(1200);
    expect(orderProblems([probable, costly]).map((p) => p.id)).toEqual(["b", "a"]);
  });

  it("has edits that lost their place before everything", () => {
    const all = [problem("swap", { at_stake: 1e6 }), problem("thin", { kind: "thin", at_stake: 1 }), problem("orphan", { kind: "orphan", at_stake: 0 })];
    expect(orderProblems(all).map((p) => p.id)).toEqual(["orphan", "thin", "swap"]);
  });

  it("takes a gap as certain, and equal ones by their frame", () => {
    expect(expectedCost(problem("g", { wrong: null, at_stake: 5, cost_mm: 2 }))).toBe(10);
    expect(orderProblems([problem("late", { first: 90 }), problem("early", { first: 9 })]).map((p) => p.id)).toEqual(["early", "late"]);
  });
});

describe("from one problem to the next", () => {
  const all = ["a", "b", "c"].map((id) => problem(id));
  it("goes round", () => {
    expect(stepProblem(all, "c", 1)!.id).toBe("a");
    expect(stepProblem(all, "a", -1)!.id).toBe("c");
  });
  it("begins at an end where the one looked at is gone", () => {
    expect(stepProblem(all, "gone", 1)!.id).toBe("a");
    expect(stepProblem(all, null, -1)!.id).toBe("c");
    expect(stepProblem([], null, 1)).toBeNull();
  });
});

describe("what taking an alternative says", () => {
  it("is its act, or the verdict that all is right", () => {
    const p = problem("p");
    expect(actOf(p, p.alternatives[0]!)).toMatchObject({ kind: "exchange", first: 12 });
    expect(actOf(p, p.alternatives[1]!)).toEqual({ kind: "review", problem: "p", right: true });
  });

  it("finds the way that takes a ghost away", () => {
    const drop = { key: "d", words: "", consequence: "", act: { kind: "claim" as const, track: "*3", name: null, first: null, last: null, at: null } };
    expect(dropOf(problem("p"))).toBeNull();
    expect(dropOf(problem("p", { alternatives: [drop] }))).toBe(drop);
  });
});
