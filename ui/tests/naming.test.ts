/** Naming one track after another on Labels. */
import { beforeEach, expect, it, vi } from "vitest";
import type { Act, Labels, TrialHeader } from "../src/api/types";
import { byId } from "../src/keys/commands";
import { lookAtTrack, nameTrack } from "../src/state/labels";
import { get, playhead, set, useStore } from "../src/state/store";
import { HEADER, path, set as paths } from "./support";

const answer: { header: TrialHeader } = vi.hoisted(() => ({ header: null as unknown as TrialHeader }));
const said: Act[] = [];
vi.mock("../src/api/client", async (real) => ({
  ...(await real<object>()),
  act: (_id: string, _head: string, what: Act) => (said.push(what), Promise.resolve({ entry: 1, outcomes: [], head: "", changed: [], removed: [], paths: null, header: answer.header })),
  problems: () => Promise.resolve({ problems: [], errors: 0, errors_left: 0, worth_looking: 0, head: "" }),
  labels: () => Promise.resolve(get().labels),
}));
vi.stubGlobal("requestAnimationFrame", (draw: () => void) => (queueMicrotask(draw), 1));
vi.stubGlobal("location", { search: "?still", hash: "" });

const tracks = (...names: string[]): TrialHeader => ({ ...HEADER, tracks: names.map((name) => ({ ...HEADER.tracks[0]!, name, named: !name.startsWith("*") })) });
const labels = { proposals: ["*3", "*4", "*5"].map((track) => ({ track, name: "LHEE", probability: 0.5, runner_up: null, state: "unsure" })), known: [], links: [], head: "" } as unknown as Labels;

beforeEach(() => {
  said.length = 0;
  const there = paths([path("*3", [1, 1, 0, 0, 0, 0]), path("*4", [0, 0, 0, 1, 1, 1]), path("*5", [0, 1, 1, 0, 0, 0])]);
  set({ ...useStore.getInitialState(), screen: "labels", id: "t", header: tracks("*3", "*4", "*5"), labels, paths: there });
  playhead.set(11, 6, 100);
  playhead.go(11);
});

it("looks at a track in the nearest frame that has it, and leaves the frame where that has it", () => {
  lookAtTrack("*4");
  expect([playhead.frame, get().selected]).toEqual([14, ["*4"]]);
  lookAtTrack("*4");
  playhead.go(15);
  lookAtTrack("*4");
  expect(playhead.frame).toBe(15);
});

it("goes to the next track when one was named, and to the first that is left after the last", async () => {
  lookAtTrack("*4");
  answer.header = tracks("*3", "LHEE", "*5");
  await nameTrack("LHEE", "*4");
  expect([said[0], get().track, playhead.frame]).toEqual([{ kind: "claim", track: "*4", name: "LHEE", first: null, last: null, at: 14 }, "*5", 13]);
  answer.header = tracks("*3", "LHEE", "LTOE");
  await nameTrack("LTOE", "*5");
  expect(get().track).toBe("*3");
});

it("goes on after U and Delete as after a name, and stays with a track that nobody was asked about", async () => {
  for (const id of ["unname", "drop"]) {
    set({ header: tracks("*3", "*4", "*5") });
    lookAtTrack("*3");
    answer.header = tracks("*4", "*5");
    byId(id).run();
    await vi.waitFor(() => expect(get().selected).toEqual(["*4"]));
  }
  set({ header: tracks("*3", "RKNE"), selected: ["RKNE"], track: "RKNE" });
  answer.header = tracks("*3", "LKNE");
  await nameTrack("LKNE", "RKNE");
  expect(get().track).toBe("RKNE");
});
