/** Answers that come late: none is taken for what is when something newer is known. */
import { beforeEach, expect, it, vi } from "vitest";
import type { Angles } from "../src/api/sessions";
import { connect } from "../src/api/live";
import { goToFrame, loadDetect, tryValue } from "../src/state/detect";
import { act } from "../src/state/acts";
import { arrive, askNames, fetchHome, fresh, refetch, wantDetections } from "../src/state/load";
import { byId, possible } from "../src/keys/commands";
import { answer as answerBall, back, fetchAngles, now, put, stepSpot } from "../src/state/sessions";
import { get, playhead, set, useStore } from "../src/state/store";
import { HEADER, path, PROBLEMS, set as paths } from "./support";

/** What was asked for and not answered yet, by the function that asked. */
const open: Record<string, ((value: unknown) => void)[]> = vi.hoisted(() => ({}));
const later = vi.hoisted(() => (name: string) => () => new Promise((done) => (open[name] ??= []).push(done)));
const kinds = vi.hoisted(() => ["home", "trial", "paths", "labels", "gaps", "detections", "act", "detection", "detectFrame"]);
vi.mock("../src/api/client", async (real) => ({
  ...(await real<object>()), ...Object.fromEntries(kinds.map((name) => [name, later(name)])), problems: () => Promise.resolve(PROBLEMS), standing: () => Promise.resolve({ ready: true }),
}));
vi.mock("../src/api/sessions", async (real) => ({ ...(await real<object>()), angles: later("angles"), ball: later("ball") }));
vi.stubGlobal("requestAnimationFrame", (draw: () => void) => (queueMicrotask(draw), 1));
vi.stubGlobal("window", globalThis);
vi.stubGlobal("location", { search: "?still", hash: "", protocol: "http:", host: "h" });

const soon = (ms = 5): Promise<unknown> => new Promise((done) => setTimeout(done, ms));
/** Answer what was asked as the n-th of those that are still open. */
async function give(name: string, value: unknown, n = 0): Promise<void> {
  open[name]!.splice(n, 1)[0]!(value);
  await soon();
}
const head = (name: string): typeof HEADER => ({ ...HEADER, head: name });
const done = (name: string): object => ({ entry: 1, outcomes: [], head: name, changed: [], removed: [], paths: null, header: head(name) });

beforeEach(() => {
  for (const name of Object.keys(open)) open[name] = [];
  set({ ...useStore.getInitialState(), screen: "tracks", id: "t", header: head("h1"), paths: { ...paths([path("LKNE", [1, 1, 0, 0, 1, 1])]), head: "h1" } });
  playhead.set(11, 6, 100);
});

it("keeps the newer of two answers about one thing, in whatever order they come", async () => {
  set({ screen: "labels" });
  void fresh(), void fresh();
  await give("labels", { proposals: [], head: "new" }, 1);
  await give("labels", { proposals: [], head: "old" });
  expect(get().labels!.head).toBe("new");
  void fetchHome(), void fetchHome();
  await give("home", { version: "new" }, 1);
  await give("home", { version: "old" });
  expect(get().home!.version).toBe("new");
});

it("keeps an act where the trial as it was before comes after it", async () => {
  void refetch();
  void act({ kind: "finish" });
  await soon();
  await give("act", done("h2"));
  await give("trial", head("h1")), await give("paths", { ...paths([]), head: "h1" });
  expect([get().header!.head, get().paths!.byName.size]).toEqual(["h2", 1]);
});

it("opens a trial that was left and opened again while something was said of it", async () => {
  void act({ kind: "track_again" });
  await soon();
  vi.stubGlobal("location", { search: "?still", hash: "#/trial/t/tracks", protocol: "http:", host: "h" });
  set({ header: null, paths: null }); // as another trial was looked at meanwhile
  void arrive();
  await soon();
  await give("act", done("h2"));
  while (open["trial"]!.length) await give("trial", head("h2")), await give("paths", { ...paths([path("LKNE", [1, 1, 0, 0, 1, 1])]), head: "h2" });
  expect([get().header?.head, get().paths?.head]).toEqual(["h2", "h2"]);
});

it("shows a trial that was asked for twice though the second answer is an error", async () => {
  vi.stubGlobal("location", { search: "?still", hash: "#/trial/t/tracks", protocol: "http:", host: "h" });
  set({ header: null, paths: null });
  void arrive();
  await soon();
  set({ header: null, paths: null });
  void arrive();
  await soon();
  await give("trial", Promise.reject(new Error("no")), 1);
  await give("trial", head("h1")), await give("paths", { ...paths([]), head: "h1" });
  expect([get().header?.head, get().paths?.head]).toEqual(["h1", "h1"]);
});

it("asks again where the journal went on between two answers of one state", async () => {
  void refetch();
  await give("trial", head("h1")), await give("paths", { ...paths([]), head: "h2" });
  expect(get().paths!.head).toBe("h1");
  await give("trial", head("h2")), await give("paths", { ...paths([]), head: "h2" });
  expect([get().header!.head, get().paths!.head]).toEqual(["h2", "h2"]);
});

it("draws a fill that was still computed when something else was said", async () => {
  const filled = (): object => ({ ...paths([path("LKNE", [1, 1, 2, 2, 1, 1])]), head: "h3" });
  void act({ kind: "gap", marker: "LKNE", first: 13, last: 14, method: "body" });
  await soon();
  await give("act", { ...done("h2"), changed: ["LKNE"] });
  await give("paths", { ...paths([path("LKNE", [1, 1, 0, 0, 1, 1])]), head: "h2", pending: true });
  void act({ kind: "event", label: "Foot Strike", side: "Left", time_s: 0 });
  await soon();
  await give("act", done("h3"));
  await vi.waitFor(() => expect(open["paths"]).toHaveLength(1), 2000);
  await give("paths", filled());
  expect([...get().paths!.byName.get("LKNE")!.origin]).toEqual([1, 1, 2, 2, 1, 1]);
});

it("asks for the names again where tracks were named while they were looked for", async () => {
  set({ screen: "labels" });
  void askNames();
  void fresh();
  await give("labels", { proposals: [], head: "after the act" }, 1);
  await give("labels", { proposals: [], head: "before it", words: "" });
  await give("labels", { proposals: [], head: "now" });
  expect(get().labels!.head).toBe("now");
});

it("draws no images of before an act, and asks for those of now", async () => {
  void wantDetections(11);
  set({ header: head("h2"), detected: null });
  await give("detections", { old: true });
  expect(get().detected).toBeNull();
  await give("detections", { old: false });
  expect(get().detected).toEqual({ old: false });
});

it("hears of another window's act while it is busy, and not of its own", async () => {
  const socket: { onmessage?: (m: { data: string }) => void } = {};
  vi.stubGlobal("WebSocket", class { constructor() { return socket; } });
  connect();
  const hear = (name: string): void => socket.onmessage!({ data: JSON.stringify({ kind: "journal", trial: "t", head: name }) });
  void act({ kind: "finish" });
  await soon();
  hear("h2");
  await give("act", done("h2"));
  expect(open["trial"]).toHaveLength(0);
  set({ busy: 1 });
  hear("of another window");
  await soon();
  expect(open["trial"]).toHaveLength(1);
});

it("shows the angles that were chosen last", async () => {
  put({ choice: {}, angles: null });
  void fetchAngles({ file: "a" } as object), void fetchAngles({ file: "b" } as object);
  await give("angles", { name: "b" } as unknown as Angles, 1);
  await give("angles", { name: "a" } as unknown as Angles);
  expect(now().angles).toEqual({ name: "b" });
});

it("shows detection a camera at a time while it is learned, and goes on with the frame that is wanted now", async () => {
  const about = { first: 1, last: 9, cameras: [{ name: "a" }, { name: "b" }], parameters: [] }, found = (): string[] => get().detect!.found.map((c) => c.name);
  const answer = (...names: string[]): Promise<void> => give("detectFrame", { frame: 1, cameras: names.map((name) => ({ name, limits: {} })) });
  open["detectFrame"] = [];
  void loadDetect("t"), await soon();
  await give("detection", about), await answer("a");
  expect(found()).toEqual(["a"]);
  goToFrame(2), await soon(60);
  await give("detectFrame", { frame: 1, cameras: [{ name: "b", limits: {} }] });
  expect([found(), open["detectFrame"].length]).toEqual([["a"], 1]);
  await answer("a"), await answer("b");
  expect([found(), open["detectFrame"].length]).toEqual([["a", "b"], 0]);
  tryValue("threshold", 3), await soon(60);
  expect(open["detectFrame"].length).toBe(1);
  await answer("a", "b");
  expect(open["detectFrame"].length).toBe(0);
});

it("takes a second click for no answer to the same question", async () => {
  const control = { cameras: [{ name: "c", balls: [{ point: "1", seen: null }, { point: "2", seen: null }], reference: { point: "r" } }], reference: "r" };
  put({ session: "s", camera: "c", point: "1", control: control as never, given: [] });
  void answerBall({ u: 1, v: 1 } as never), void answerBall({ u: 2, v: 2 } as never);
  await soon();
  expect(open["ball"]).toHaveLength(1);
  const said = { ...control, cameras: [{ ...control.cameras[0]!, balls: [{ point: "1", seen: true }, { point: "2", seen: null }] }] };
  await give("ball", said);
  expect([now().given.length, now().point]).toEqual([1, "2"]);
});

it("points at a spot once, however long the key is held, until another is chosen or the answer is taken back", async () => {
  const balls = (...seen: (true | null)[]): unknown => ({ cameras: [{ name: "c", balls: seen.map((own, k) => ({ point: `${k + 1}`, seen: own })), reference: { point: "r" } }], reference: "r" });
  put({ session: "s", camera: "c", point: "1", pointing: true, control: balls(null, null) as never, given: [], white: { centroids: [[5, 5], [9, 9]] } as never, spot: -1 });
  const key = byId("ball-spot"), press = (): Promise<unknown> => (possible(key, get()) && key.run(), soon());
  set({ screen: "cameras" }), stepSpot(1);
  await press(), await give("ball", balls(true, null));
  expect([now().given.length, now().point]).toEqual([1, "2"]);
  await press();
  expect(open["ball"]).toHaveLength(0);
  stepSpot(1), await press(), await give("ball", balls(true, true));
  expect(now().given).toHaveLength(2);
  void back(), await give("ball", balls(true, null));
  await press();
  expect(open["ball"]).toHaveLength(1);
});
