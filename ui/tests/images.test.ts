import { describe, expect, it } from "vitest";
import type { DigitisingNow } from "../src/api/types";
import { namesOf } from "../src/parts/StartUp";
import { changed, masksOf, usedOf, valueOf, type Tried } from "../src/state/detect";
import { isSaved } from "../src/state/digitise";

const TRIED: Tried = {
  about: {
    trial: "one", session: "tried", method: "centroids", first: 1, last: 20, every: 1, learned: true, words: "",
    parameters: [
      { name: "threshold", whole: false, flag: false, unit: "grey levels", low: 0, high: 255, meaning: "", stated: 90 },
      { name: "min_area", whole: true, flag: false, unit: "px²", low: 1, high: null, meaning: "", stated: null },
    ],
    cameras: [
      { name: "a", width: 10, height: 8, tall: false, own: { min_area: 5 }, masks: [[[0, 0], [1, 0], [1, 1]]] },
      { name: "b", width: 10, height: 8, tall: false, own: {}, masks: [] },
    ],
  },
  frame: 1, of: null, large: null, draft: { every: {}, cameras: {}, masks: {} }, white: true, painting: false, why: null,
  found: [{ name: "a", threshold: 90, inverted: false, ground: false, limits: { threshold: 90, min_area: 5 }, marks: [], histogram: [], refused: "" }],
};

describe("detection being tried", () => {
  it("is as the session says until something else is tried", () => {
    expect(valueOf(TRIED, "threshold")).toBe(90);
    expect(valueOf(TRIED, "min_area")).toBeNull();
    expect(usedOf(TRIED, "min_area")).toBe(5);
    expect(changed(TRIED)).toBe(false);
  });

  it("is one thing for all cameras and another for one", () => {
    const t = { ...TRIED, draft: { every: { threshold: 40 }, cameras: { a: { min_area: null } }, masks: {} } };
    expect([valueOf(t, "threshold"), valueOf(t, "min_area", "a"), valueOf(TRIED, "min_area", "a"), valueOf(t, "threshold", "a")]).toEqual([40, null, 5, null]);
    expect(changed(t)).toBe(true);
  });

  it("has the masks that are drawn, or those of the file", () => {
    expect(masksOf(TRIED, "a")).toHaveLength(1);
    expect(masksOf({ ...TRIED, draft: { ...TRIED.draft, masks: { a: [] } } }, "a")).toEqual([]);
  });
});

describe("digitising", () => {
  it("takes names, or how many there are", () => {
    expect(namesOf("ACR1, ELB4 REF;")).toEqual(["ACR1", "ELB4", "REF"]);
    expect(namesOf("3")).toEqual(["1", "2", "3"]);
    expect(namesOf("31")).toEqual(["31"]);
    expect(namesOf("  ")).toEqual([]);
  });

  it("has saved frames first", () => {
    const now = { camera: "a", frames: 9, cameras: [{ name: "a", saved: 3 }] } as DigitisingNow;
    expect([3, 4].map((frame) => isSaved(now, frame))).toEqual([true, false]);
  });
});
