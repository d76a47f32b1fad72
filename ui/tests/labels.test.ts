import { expect, it } from "vitest";
import type { Labels } from "../src/api/types";
import { asked, keptNames, labelRows, nameChoices } from "../src/model/labels";
import { HEADER } from "./support";

const labels = { proposals: [{ track: "RKNE", name: "RKNE", probability: 0.7, runner_up: "LKNE", state: "unsure" }, { track: "LKNE", name: "LKNE", probability: 1, runner_up: null, state: "sure" }], links: [], sides: "", words: "", can_ask: false, by: "", known: [], head: "" } as Labels;

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

it("offers what is proposed first, then what else it may be, names that no track has, and names of others last", () => {
  const asked: Labels = { ...labels, proposals: [{ track: "*3", name: "LUAP", probability: 0.6, runner_up: "RUAP", state: "unsure" }], known: ["LHEE", "LKNE", "RUAP", "LUAP"] };
  const found = nameChoices({ ...HEADER, marker_set: null }, asked, "*3");
  expect(found.map((one) => `${one.id}: ${one.beside}`)).toEqual(["LUAP: proposed, free", "RUAP: else, free", "LHEE: free", "LKNE: has f 11–16", "RKNE: has f 11–16", "extra: has f 11–16"]);
});

it("says which markers keep their names where sides are exchanged", () => {
  expect([keptNames([]), keptNames(["RBAK"]), keptNames(["A", "B", "C", "D", "E", "F"])]).toEqual(["", "RBAK has no partner here and keeps its name", "A, B, C, D and 2 more have no partner here and keep their names"]);
});
