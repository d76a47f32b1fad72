/** The table of gaps: its order, and which row is which when the server has answered anew. */
import { beforeEach, expect, it, vi } from "vitest";
import type { GapCandidates, GapRow, Gaps, TrialHeader } from "../src/api/types";
import { byId, footLine } from "../src/keys/commands";
import { inTable, nextOrder } from "../src/model/gaps";
import { withoutSubject } from "../src/model/names";
import { lookAtGap } from "../src/state/acts";
import { get, playhead, set, useStore } from "../src/state/store";
import { HEADER, path, set as paths } from "./support";

const answers: GapCandidates[] = [];
vi.mock("../src/api/client", async (real) => ({ ...(await real<object>()), gap: () => Promise.resolve(answers.shift() ?? null) }));
vi.stubGlobal("requestAnimationFrame", () => 1);
vi.stubGlobal("location", { search: "?still", hash: "" });

const row = (marker: string, first: number, frames: number, expected_mm: number | null = 1): GapRow =>
  ({ marker, first, last: first + frames - 1, frames, method: "linear", expected_mm, others: [], cameras_alone: [], state: "fillable", choice: null, words: "" });
const table = (...gaps: GapRow[]): Gaps => ({ gaps, limit_mm: 5, pending: false, head: "" });
const seen = (rows: readonly GapRow[]): string[] => rows.map((g) => `${g.marker}${g.first}`);
const ROWS = [row("T10", 12, 5, 2), row("T9", 13, 1, null), row("T9", 15, 3, 9)];

beforeEach(() => {
  set({ ...useStore.getInitialState(), screen: "gaps", id: "t", header: HEADER, paths: paths([path("T9", [1, 0, 1, 1, 0, 1]), path("T10", [1, 0, 1, 1, 0, 1])]), gaps: table(...ROWS) });
  playhead.set(11, 6, 100);
});

it("orders by length, by expected error with what cannot be said last, and by marker as people count", () => {
  expect(seen(inTable(ROWS, null))).toEqual(seen(ROWS));
  expect(seen(inTable(ROWS, { by: "frames", down: true }))).toEqual(["T1012", "T915", "T913"]);
  expect(seen(inTable(ROWS, { by: "expected", down: true }))).toEqual(["T915", "T1012", "T913"]);
  expect(seen(inTable(ROWS, { by: "expected", down: false }))).toEqual(["T1012", "T915", "T913"]);
  expect(seen(inTable(ROWS, { by: "marker", down: false }))).toEqual(["T913", "T915", "T1012"]);
});

it("gives the worst first at a click on a title, the other way at the second, and the file's order at the third", () => {
  const worst = nextOrder(null, "expected"), best = nextOrder(worst, "expected");
  expect([worst, best, nextOrder(best, "expected"), nextOrder(worst, "marker")]).toEqual([{ by: "expected", down: true }, { by: "expected", down: false }, null, { by: "marker", down: false }]);
});

it("goes through the gaps as the table shows them", () => {
  set({ gapOrder: { by: "expected", down: true } });
  const found = [1, 2, 3].map(() => (byId("gap-next").run(), `${get().gap!.marker}${get().gap!.first}`));
  expect(found).toEqual(["T915", "T1012", "T913"]);
});

it("knows the gap that is looked at when the table has come anew", () => {
  set({ gaps: table(ROWS[0]!), gap: { ...ROWS[0]! } });
  expect(footLine(get()).map((line) => line.id)).not.toContain("gap-next");
  set({ gaps: table(...ROWS.map((g) => ({ ...g }))) });
  byId("gap-next").run();
  expect(seen([get().gap!])).toEqual(["T913"]);
});

it("fills by what is best as far as is known, until a person chose another way", async () => {
  const way = (method: string, expected_mm: number): GapCandidates["candidates"][number] => ({ method, expected_mm, xyz: [[0, 0, 0]], sd: null });
  const found = (best: string | null, pending: boolean): GapCandidates => ({ marker: "T9", first: 13, last: 13, best, pending, head: "", candidates: [way("pca", 1), way("cubic", 2)] });
  answers.push(found(null, true), found("cubic", false));
  await lookAtGap(ROWS[1]!);
  expect(get().method).toBe("cubic");
  answers.push(found("cubic", false));
  const looked = lookAtGap({ ...ROWS[1]!, choice: null });
  await vi.waitFor(() => expect(get().candidates).not.toBeNull());
  await looked;
  byId("method").run();
  expect(get().method).toBe("pca");
  answers.push(found("cubic", true), found("cubic", false));
  const again = lookAtGap(ROWS[1]!);
  set({ method: "linear", picked: true });
  await again;
  expect(get().method).toBe("linear");
});

it("writes names without the subject where they stay apart", () => {
  const of = (...names: string[]): TrialHeader => ({ ...HEADER, tracks: names.map((name) => ({ ...HEADER.tracks[0]!, name })) });
  const one = of("Anna:LASI", "Anna:RASI", "box:left", "*3"), two = of("A:LASI", "B:LASI", "A:C7");
  expect(["Anna:LASI", "box:left", "*3"].map((name) => withoutSubject(one, name))).toEqual(["LASI", "left", "*3"]);
  expect(["A:LASI", "B:LASI", "A:C7"].map((name) => withoutSubject(two, name))).toEqual(["A:LASI", "B:LASI", "C7"]);
});
