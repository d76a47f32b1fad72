import { describe, expect, it } from "vitest";
import { labelRows } from "../src/model/labels";
import { rowOrder } from "../src/model/lanes";
import { shownPaths } from "../src/model/paths";
import { ends, inShort } from "../src/model/format";
import { HEADER, path, set } from "./support";

const header = { ...HEADER, tracks: HEADER.tracks.map((t) => ({ ...t, computed: t.name === "extra" })) };
const paths = set(["*3", "RKNE", "extra", "LKNE"].map((name) => path(name, [1, 1, 1, 1, 1, 1])));

describe("points that are no markers", () => {
  it("are shown where they are asked for alone", () => {
    expect([...shownPaths(header, paths, false)!.byName.keys()]).toEqual(["*3", "RKNE", "LKNE"]);
    expect(shownPaths(header, paths, true)).toBe(paths);
    expect(shownPaths(HEADER, paths, false)).toBe(paths);
    expect(labelRows(header, null).map((p) => p.track)).not.toContain("extra");
    expect(labelRows(header, null, true).map((p) => p.track)).toContain("extra");
  });

  it("have their lanes below all others", () => {
    expect(rowOrder(header, paths)).toEqual(["LKNE", "RKNE", "*3", "extra"]);
  });
});

it("a long name keeps its end, where sides and numbers stand", () => {
  expect([inShort("LateralEpicondyleL", 9), inShort("LateralEpicondyleR", 9), inShort("LKNE", 9)]).toEqual(["Late…yleL", "Late…yleR", "LKNE"]);
  expect([ends("ScapulaL1"), ends("T10")]).toEqual([["Scapu", "laL1"], ["", "T10"]]);
});
