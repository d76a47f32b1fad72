/** Digitising: the question that the server asks, and the answers; nothing of it is kept in the page. */
import * as api from "../api/client";
import { Refused } from "../api/client";
import type { AnswerSaid, DigitisingNow, PlacedMarker, SetupBody } from "../api/types";
import { tone } from "../model/tone";
import { get, set } from "./store";
import { goTo, ready, say, tried } from "./load";
import { asking } from "./newest";

export interface Digitised {
  now: DigitisingNow;
  /** The frame that is shown, where it is another than the one that is asked about. */
  shown: number | null;
  /** What is saved of it. */
  saved: readonly PlacedMarker[];
  /** The spot that the keys have chosen, by its place in the question's list. */
  spot: number;
}

export const digitised = (): Digitised | null => get().digitise;
const put = (some: Partial<Digitised>): void => set((s) => ({ digitise: s.digitise && { ...s.digitise, ...some } }));

export async function loadDigitise(id: string): Promise<void> {
  const last = asking("digitise");
  if (!(await ready(id, "digitise"))) return;
  const now = await tried(() => api.digitising(id));
  if (now && get().id === id && last()) set({ digitise: { now, shown: null, saved: [], spot: 0 } });
}

/** Name the markers; digitising then begins. */
export async function setUp(what: SetupBody): Promise<boolean> {
  const { id } = get(), now = id && (await tried(() => api.setUpDigitising(id, what)));
  if (!now || get().id !== id) return false;
  set({ digitise: { now, shown: null, saved: [], spot: 0 }, note: null });
  return true;
}

/** Nobody digitises the trial after all. */
export async function leaveOff(): Promise<void> {
  const { id } = get();
  if (!id || (await tried(() => api.leaveDigitising(id).then(() => true))) === null) return;
  set({ digitise: null });
  goTo("detect");
}

let answering = false;

/** Answer the question that is asked; one at a time, so that a second click is no answer to the next question. */
export async function answer(said: AnswerSaid): Promise<void> {
  const { id } = get(), before = digitised()?.now;
  if (!id || !before || answering) return;
  answering = true;
  try {
    const now = await tried(() => api.answer(id, { camera: before.camera, kept: before.kept, said }).catch((error: unknown) => again(id, error)));
    if (!now || get().id !== id) return;
    asking("digitise");
    set({ digitise: { now, shown: null, saved: [], spot: 0 }, note: null });
    lastFrame(before, now);
  } finally {
    answering = false;
  }
}

/** Another window has answered: this is where it stands. */
async function again(id: string, error: unknown): Promise<DigitisingNow> {
  if (error instanceof Refused && error.status === 409) await loadDigitise(id);
  throw error;
}

/** A message and a tone where the last frame of a camera was saved. */
function lastFrame(before: DigitisingNow, now: DigitisingNow): void {
  const saved = now.cameras.find((c) => c.name === before.camera)?.saved ?? 0, on = before.question.phase === "review" && saved === now.frames;
  if (!on || (now.camera === before.camera && now.question.phase !== "done")) return;
  tone();
  say("done", now.finished ? `The last frame of ${before.camera} is saved: the trial is digitised. Run it.` : `The last frame of ${before.camera} is saved. Next: ${now.camera}.`);
}

export async function showFrame(frame: number): Promise<void> {
  const { id } = get(), d = digitised();
  if (!id || !d) return;
  const to = Math.min(d.now.frames, Math.max(1, Math.round(frame))), own = d.now.question.frame;
  put({ shown: to === own ? null : to, saved: [] });
  if (to === own || !isSaved(d.now, to)) return;
  const saved = await tried(() => api.savedFrame(id, to));
  if (saved && digitised()?.shown === to) put({ saved });
}

export const stepFrame = (by: number): void => void showFrame((digitised()?.shown ?? digitised()?.now.question.frame ?? 1) + by);
export const savedOf = (now: DigitisingNow): number => now.cameras.find((c) => c.name === now.camera)?.saved ?? 0;
/** Frames are saved one after the other, so that those that are not come last. */
export const isSaved = (now: DigitisingNow, frame: number): boolean => frame <= savedOf(now);
export const pointing = (d: Digitised): boolean => d.shown === null && (d.now.question.phase === "point" || d.now.question.phase === "correct");

export function stepSpot(by: number): void {
  const d = digitised();
  if (!d || !d.now.question.spots.length) return;
  const n = d.now.question.spots.length;
  put({ spot: (((d.spot + by) % n) + n) % n, shown: null });
}

/** Point at the spot that the keys have chosen. */
export function pointAtSpot(): void {
  const d = digitised(), spot = d?.now.question.spots[d.spot];
  if (d && spot && pointing(d)) void answer({ kind: "point", u: spot[0], v: spot[1] });
}
