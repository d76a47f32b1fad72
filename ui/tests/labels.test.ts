import { expect, it } from "vitest";
import type { Labels } from "../src/api/types";
import { asked, labelRows } from "../src/model/labels";
import { HEADER } from "./support";

const labels = { proposals: [{ track: "RKNE", name: "RKNE", probability: 0.7, runner_up: "LKNE", state: "unsure" }, { track: "LKNE", name: "LKNE", probability: 1, runner_up: null, state: "sure" }], links: [], sides: "", words: "", can_ask: false, by: "", head: "" } as Labels;

it("asks first for tracks without a name, though nothing is proposed for them, then for unsure names", () => {
  expect(labelRows(HEADER, labels).map((p) => p.track)).toEqual(["*3", "RKNE", "extra", "LKNE"]);
  expect(asked(labelRows(HEADER, labels)).map((p) => p.track)).toEqual(["*3", "RKNE"]);
});

it("asks for tracks with another name proposed before those with none", () => {
  const more = { ...labels, proposals: [...labels.proposals, { track: "extra", name: "RHEE", probability: 0.8, runner_up: null, state: "unsure" as const }] };
  expect(asked(labelRows(HEADER, more)).map((p) => p.track)).toEqual(["extra", "*3", "RKNE"]);
});

it("lists all tracks before anything is proposed", () => {
  expect(labelRows(HEADER, null)).toHaveLength(4);
});
