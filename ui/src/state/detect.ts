/** Detection being tried: what the session says, what is tried instead, and what that finds in the frame that is shown. */
import * as api from "../api/client";
import type { CameraFound, Detection, DetectDraft, PlaceWhy } from "../api/types";
import { get, set } from "./store";
import { ready, say, tried } from "./load";
import { asking } from "./newest";

export type Value = number | boolean | null;
export type Polygon = [number, number][];
export interface Tried {
  about: Detection;
  frame: number;
  /** Of all cameras where null. */
  of: string | null;
  /** The camera that is shown alone. */
  large: string | null;
  draft: { every: Record<string, Value>; cameras: Record<string, Record<string, Value>>; masks: Record<string, Polygon[]> };
  found: readonly CameraFound[];
  white: boolean;
  painting: boolean;
  why: (PlaceWhy & { camera: string; u: number; v: number }) | null;
}

const EMPTY: Tried["draft"] = { every: {}, cameras: {}, masks: {} };
/** ms between two looks while a slider is moved; chosen: it answers in a few ms. */
const SOON_MS = 40;

export const detect = (): Tried | null => get().detect;
const put = (some: Partial<Tried>): void => set((s) => ({ detect: s.detect && { ...s.detect, ...some } }));

export async function loadDetect(id: string): Promise<void> {
  const last = asking("detection");
  if (!(await ready(id, "detect"))) return;
  const about = await tried(() => api.detection(id));
  if (!about || get().id !== id || !last()) return;
  const before = get().detect, frame = before ? before.frame : about.first;
  set({ detect: { about, frame: Math.min(about.last, Math.max(about.first, frame)), of: before?.of ?? null, large: before?.large ?? null, draft: before?.draft ?? EMPTY, found: [], white: before?.white ?? true, painting: false, why: null } });
  await look();
}

let timer = 0, asked = 0;

/** What is found now, with what is tried. At first a camera at a time: what is learned from its recording takes a second. */
async function look(): Promise<void> {
  const { id, detect: t } = get();
  if (!id || !t) return;
  const number = ++asked, mine = (): boolean => number === asked && get().id === id;
  const names = t.about.cameras.map((c) => c.name), whole = names.every((name) => t.found.some((c) => c.name === name));
  for (const some of whole ? [[]] : names.map((name) => [name])) {
    const got = await tried(() => api.detectFrame(id, t.frame, t.draft as DetectDraft, some));
    if (!got || !mine()) return;
    put({ found: [...detect()!.found.filter((c) => !got.cameras.some((one) => one.name === c.name)), ...got.cameras] });
  }
  const why = detect()?.why;
  if (why) void ask(why.camera, why.u, why.v);
}

function soon(): void {
  clearTimeout(timer);
  timer = window.setTimeout(() => void look(), SOON_MS);
}

export function goToFrame(frame: number): void {
  const t = detect();
  if (!t) return;
  put({ frame: Math.min(t.about.last, Math.max(t.about.first, Math.round(frame))), why: null });
  soon();
}

/** What a parameter is now: as it is tried, else as the session says it; null where it is left open. */
export function valueOf(t: Tried, name: string, of = t.of): Value {
  if (of) {
    const own = t.draft.cameras[of];
    if (own && name in own) return own[name]!;
    return t.about.cameras.find((c) => c.name === of)?.own[name] ?? null;
  }
  return name in t.draft.every ? t.draft.every[name]! : (t.about.parameters.find((p) => p.name === name)?.stated ?? null);
}

/** With what it was used in the camera that is looked at, or the first one. */
export const usedOf = (t: Tried, name: string): number | null => foundOf(t, t.of ?? t.large)?.limits[name] ?? null;
export const foundOf = (t: Tried, camera: string | null): CameraFound | undefined => t.found.find((c) => c.name === (camera ?? t.about.cameras[0]?.name));

export function tryValue(name: string, value: Value): void {
  const t = detect();
  if (!t) return;
  const { draft, of } = t;
  put({ draft: of ? { ...draft, cameras: { ...draft.cameras, [of]: { ...draft.cameras[of], [name]: value } } } : { ...draft, every: { ...draft.every, [name]: value } } });
  soon();
}

/** The threshold higher or lower than it is used now. */
export function moveThreshold(by: number): void {
  const t = detect(), now = t && ((valueOf(t, "threshold") as number | null) ?? usedOf(t, "threshold"));
  if (now != null) tryValue("threshold", Math.min(254, Math.max(0, Math.round(now + by))));
}

export const masksOf = (t: Tried, camera: string): Polygon[] => t.draft.masks[camera] ?? (t.about.cameras.find((c) => c.name === camera)?.masks as Polygon[] | undefined) ?? [];

export function setMasks(camera: string, polygons: Polygon[]): void {
  const t = detect();
  if (!t) return;
  put({ draft: { ...t.draft, masks: { ...t.draft.masks, [camera]: polygons } } });
  soon();
}

export const changed = (t: Tried): boolean =>
  Object.keys(t.draft.every).length + Object.keys(t.draft.masks).length + Object.values(t.draft.cameras).filter((own) => Object.keys(own).length).length > 0;

export function forgetDraft(): void {
  put({ draft: EMPTY, why: null });
  soon();
}

export async function ask(camera: string, u: number, v: number): Promise<void> {
  const { id, detect: t } = get();
  if (!id || !t) return;
  const last = asking("why"), why = await tried(() => api.detectWhy(id, { frame: t.frame, camera, u, v, draft: t.draft as DetectDraft }));
  if (why && get().id === id && last() && detect()?.frame === t.frame) put({ why: { ...why, camera, u, v } });
}

/** Write what is tried into the session; its trials are stale then. */
export async function applyDraft(): Promise<void> {
  const { id, detect: t } = get();
  if (!id || !t || !changed(t)) return;
  const about = await tried(() => api.detectApply(id, t.draft as DetectDraft));
  if (!about || get().id !== id) return;
  asking("detection");
  put({ about, ...(detect()?.draft === t.draft ? { draft: EMPTY } : {}) }); // what was tried meanwhile is not written
  set({ header: null, paths: null, problems: null, gaps: null, labels: null });
  say("done", "Written into session.toml. Run the trial again, so that all of it follows.");
  await look();
}

export const showLarge = (camera: string | null): void => put({ large: camera });
export const chooseOf = (camera: string | null): void => put({ of: camera });
export const flipWhite = (): void => put({ white: !detect()?.white });
export const flipPainting = (): void => put({ painting: !detect()?.painting });
