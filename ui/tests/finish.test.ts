/** What is cut off a trial when it is finished is what a person said, and nothing else. */
import { describe, expect, it, vi } from "vitest";
import type { GapRow } from "../src/api/types";
import { marked, usual } from "../src/model/finish";
import { leaveGap } from "../src/state/load";
import { get, set } from "../src/state/store";
import { HEADER } from "./support";

vi.stubGlobal("location", { search: "?still", hash: "" });

const gap = { marker: "LKNE", first: 12, last: 13 } as GapRow;

describe("the frames of a finished trial", () => {
  it("are those that all markers have, though a gap is looked at", () => {
    expect(usual(HEADER, marked(12, 13, gap))).toEqual([11, 16]);
    expect(usual(HEADER, marked(null, null, null))).toEqual([11, 16]);
  });

  it("are those that somebody marked, also where a gap is looked at", () => {
    expect(usual(HEADER, marked(12, 15, gap))).toEqual([12, 15]);
    expect(usual(HEADER, marked(12, null, null))).toEqual([12, 16]);
  });
});

describe("a gap that was looked at", () => {
  it("marks no stretch on other screens, where a name or an exchange would be of it alone", () => {
    set({ gap, first: 12, last: 13 });
    leaveGap();
    expect([get().gap, get().first, get().last]).toEqual([null, null, null]);
  });

  it("leaves what somebody marked, and the end that goes on", () => {
    set({ gap, first: 12, last: 15 });
    leaveGap();
    expect([get().gap, get().first, get().last]).toEqual([null, 12, 15]);
  });
});
