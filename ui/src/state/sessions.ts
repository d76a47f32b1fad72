/** Sessions: the one that is being made, the cameras of one, the angles of its trials; and what is done with them. */
import { create } from "zustand";
import * as home from "../api/client";
import * as api from "../api/sessions";
import type { AngleChoice, Angles, Control, ControlCamera, NewFolder, Proposed, Said, SessionCameras, Spike, White } from "../api/sessions";
import { goTo, say, tried } from "./load";
import { asking } from "./newest";
import { get, playhead, set } from "./store";

interface Sessions {
  folders: readonly NewFolder[] | null;
  folder: string | null;
  said: Said;
  proposed: Proposed | null;

  session: string | null;
  cameras: SessionCameras | null;
  /** The camera that is thought to be lost; the former calibration that is compared. */
  lost: string | null;
  control: Control | null;
  /** Whether balls are pointed at; null until it is known whether some are still to be. */
  pointing: boolean | null;
  /** Of the control image: camera, point that is asked for, threshold that is tried; answers in the order they were given. */
  camera: string;
  point: string;
  level: number | null;
  inverted: boolean;
  white: White | null;
  /** The centroid that the keys have chosen, by its place in the list; −1: none. */
  spot: number;
  /** Whether it was pointed at: a key that is held, or pressed twice, would make it the next ball too. */
  spent: boolean;
  given: readonly { camera: string; point: string }[];

  angles: Angles | null;
  choice: AngleChoice;
  spike: (Spike & { joint: number; turn: number }) | null;
}

export const useSessions = create<Sessions>()(() => ({
  folders: null, folder: null, said: {}, proposed: null, session: null, cameras: null, lost: null, control: null, pointing: null, camera: "", point: "", level: null,
  inverted: false, white: null, spot: -1, spent: false, given: [], angles: null, choice: {}, spike: null,
}));
export const now = useSessions.getState;

/** Change it, so that the foot says anew what keys do. */
export function put(some: Partial<Sessions>): void {
  useSessions.setState(some);
  set({});
}

/** The session that is looked at: its own screen's, or that of the open trial. */
/** The session that is shown; that of the trial that is marked, on Home, or open; where there is none the one that was shown last. */
export function sessionOf(): string | null {
  const { header, home, id, marked, screen } = get(), last = now().session;
  const of = (trial: string | null): string | null => home?.sessions.find((one) => one.trials.some((t) => t.id === trial))?.id ?? null;
  if (last && (screen === "cameras" || screen === "um2as")) return last;
  if (screen === "home") return of(marked) ?? header?.session_id ?? last;
  return header ? header.session_id : id ? of(id) : last;
}

export const cameraAddress = (id: string): string => `#/session/${encodeURIComponent(id)}/cameras`;

/** Show what an address says that is of no trial; whether it was such a one. */
export async function arriveAtSession(kind: string | undefined, id: string | undefined): Promise<boolean> {
  if (kind === "new") {
    set({ screen: "new" });
    const key = id ? decodeURIComponent(id) : null;
    if (key !== now().folder || !key) put({ folder: key, proposed: null, said: {} });
    if (key) await propose({});
    else {
      const found = await tried(api.folders);
      put({ folders: found?.folders ?? null });
    }
    return true;
  }
  if (kind !== "session" || !id) return false;
  const key = decodeURIComponent(id);
  set({ screen: "cameras" });
  if (key !== now().session) put({ session: key, cameras: null, control: null, pointing: null, lost: null, given: [], camera: "", point: "", white: null });
  if (get().header && get().header!.session_id !== key) set({ id: null, header: null });
  await fetchCameras();
  return true;
}

/** Say more of the recordings; the proposal follows. */
export async function propose(more: Said): Promise<void> {
  const { folder, said } = now(), all: Said = { ...said, ...more };
  if (!folder) return;
  put({ said: all });
  const proposed = await tried(() => api.proposal(folder, all));
  if (proposed && now().folder === folder && now().said === all) put({ proposed });
}

/** Write the session; its trials are run where `run` says so. */
export async function makeSession(run: boolean): Promise<void> {
  const { folder, said, proposed } = now();
  if (!folder) return;
  const made = await tried(() => api.make(folder, said));
  if (!made) return;
  put({ folder: null, proposed: null, said: {}, folders: null, session: made.session, cameras: null, control: null, pointing: null, camera: "", point: "" });
  set({ id: null, header: null });
  if (run && made.trials[0]) await tried(() => home.run(made.trials[0]!));
  location.hash = run ? "#/" : cameraAddress(made.session);
  setTimeout(() => say("done", `${proposed?.name ?? "The session"} is made${run ? ", and its first trial is being run" : ". Calibrate its cameras"}.`), 300);
}

export async function fetchCameras(): Promise<void> {
  const id = now().session, last = asking("cameras");
  const cameras = id && (await tried(() => api.cameras(id)));
  if (!cameras || now().session !== id || !last()) return;
  put({ cameras });
  const control = cameras.control ? await tried(() => api.control(id)) : null;
  if (now().session !== id || !last()) return;
  const asks = control?.cameras.some((c) => c.balls.some((b) => b.seen === null)) ?? false;
  put({ control, pointing: now().pointing ?? asks }); // it stays open when all is said: the reference marker is asked for then
  if (control && !now().camera) choose(firstOpen(control, control.cameras[0]?.name ?? ""));
}

export async function calibrate(): Promise<void> {
  const id = now().session;
  put({ pointing: false });
  if (id && (await tried(() => api.calibrate(id)))) say("news", "The cameras are being calibrated.");
}

/** What is asked for in a camera's image: balls in their order, then the reference marker. */
export const asked = (camera: ControlCamera): readonly ControlCamera["reference"][] => [...camera.balls, camera.reference];

/** The first camera from one on whose balls are not all said, and the ball; the reference marker last. */
function firstOpen(control: Control, camera: string): { camera: string; point: string } {
  const at = Math.max(0, control.cameras.findIndex((c) => c.name === camera));
  const all = [...control.cameras.slice(at), ...control.cameras.slice(0, at)];
  const next = all.find((c) => c.balls.some((b) => b.seen === null)) ?? all[0];
  return { camera: next?.name ?? "", point: next?.balls.find((b) => b.seen === null)?.point ?? control.reference };
}

export function choose({ camera, point }: { camera: string; point: string }): void {
  const before = now().camera;
  put({ camera, point });
  if (camera === before) return;
  const own = now().control?.cameras.find((c) => c.name === camera);
  put({ level: own?.threshold ?? null, inverted: own?.inverted ?? false, white: null, spot: -1 });
  void fetchWhite();
}

/** What can be pointed at by the threshold that is tried. */
export async function fetchWhite(): Promise<void> {
  const { session, camera, level, inverted } = now();
  if (!session || !camera) return;
  const white = await tried(() => api.white(session, camera, level, inverted));
  if (white && now().camera === camera && now().level === level && now().inverted === inverted) put({ white, spot: -1 });
}

/** Choose the next white spot of the image, or the one before: from left to right, as they are looked for. */
export function stepSpot(by: 1 | -1): void {
  const n = now().white?.centroids.length ?? 0, at = now().spot;
  if (n) put({ spot: at < 0 ? (by > 0 ? 0 : n - 1) : (at + by + n) % n, spent: false });
}

/** Where the spots of the image are, from left to right. */
export const spotsOf = (white: White | null): readonly (readonly [number, number])[] => [...(white?.centroids ?? [])].sort((a, b) => a[0] - b[0] || a[1] - b[1]);

/** Point at the spot that the keys have chosen, once. */
export function pointAtSpot(): void {
  const { white, spot, spent, given } = now(), at = spotsOf(white)[spot];
  if (!at || spent || answering) return;
  put({ spent: true });
  void answer({ u: at[0], v: at[1] }).then(() => now().given === given && put({ spent: false })); // refused: it may be pointed at again
}

let answering = false;

/** One answer at a time, so that a second click is none to the same question; what was asked for before is older. */
async function onlyOne(ask: () => Promise<Control>): Promise<Control | null> {
  answering = true;
  try {
    return await tried(ask);
  } finally {
    answering = false;
    asking("cameras");
  }
}

/** Answer for the point that is asked for; the next is asked for then. */
export async function answer(said: Omit<api.Ball, "point">): Promise<void> {
  const { session, camera, point, level, inverted, control } = now();
  if (!session || !camera || !point || answering) return;
  const got = await onlyOne(() => api.ball(session, camera, { ...said, point, threshold: level, inverted }));
  if (!got || now().session !== session) return;
  put({ control: got, given: [...now().given, { camera, point }] });
  say("done", `${point} in ${camera}: ${said.seen === false ? "not seen" : "found"}.`);
  const own = got.cameras.find((c) => c.name === camera)!, rest = asked(own), at = rest.findIndex((b) => b.point === point);
  const next = rest.slice(at + 1).find((b) => b.seen === null);
  choose(next ? { camera, point: next.point } : firstOpen(got, nextOf(control!, camera)));
  if (got.cameras.every((c) => c.balls.every((b) => b.seen !== null))) say("done", "All balls of all cameras are said. Calibrate.");
}

const nextOf = (control: Control, camera: string): string => control.cameras[(control.cameras.findIndex((c) => c.name === camera) + 1) % control.cameras.length]!.name;

/** Take the last answer back, and ask for it again. */
export async function back(): Promise<void> {
  const { session, given } = now(), last = given.at(-1);
  if (!session || !last || answering) return;
  const got = await onlyOne(() => api.ball(session, last.camera, { point: last.point, forget: true }));
  if (!got || now().session !== session) return;
  put({ control: got, given: given.slice(0, -1), spent: false });
  choose(last);
  say("done", `${last.point} in ${last.camera} is taken back. Where is it?`);
}

export async function keepThreshold(all: boolean): Promise<void> {
  const { session, camera, level, inverted, white } = now(), value = level ?? white?.threshold;
  if (!session || value == null) return;
  const got = await tried(() => api.threshold(session, { camera: all ? null : camera, threshold: value, inverted }));
  if (got) put({ control: got }), say("done", `The threshold of ${all ? "all cameras" : camera} is ${Math.round(value)} from now on.`);
}

/** The angles of the open trial, as they are chosen. */
export async function fetchAngles(more: AngleChoice = {}): Promise<void> {
  const id = get().id, choice = { ...now().choice, ...more };
  put({ choice, spike: null });
  const angles = id && (await tried(() => api.angles(id, choice)));
  if (angles && get().id === id && now().choice === choice) put({ angles });
}

/** What made an angle leap near a frame. */
export async function askSpike(joint: number, turn: number, frame: number): Promise<void> {
  const id = get().id, last = asking("spike");
  playhead.pause(), playhead.go(frame);
  const spike = id && (await tried(() => api.spike(id, { ...now().choice, joint, turn, frame })));
  if (!spike || get().id !== id || !last()) return;
  put({ spike: { ...spike, joint, turn } });
  playhead.go(spike.frame);
}

/** To the marker that made it, in its images. */
export function lookAtSpike(): void {
  const spike = now().spike;
  if (!spike) return;
  goTo("tracks");
  setTimeout(() => {
    playhead.go(spike.frame);
    set((s) => ({ selected: [spike.marker], follow: true, focused: s.focused + 1 }));
    say("news", spike.words);
  }, 50);
}

export async function writeEuler(): Promise<void> {
  const id = get().id, got = id && (await tried(() => api.euler(id, now().choice)));
  if (got) say("done", `Written: ${got.names.join(", ")}`);
}
