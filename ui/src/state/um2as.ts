/** The menu of UM²AS: where in it the person is, what is chosen in its tasks, and the way back from other screens. */
import { create } from "zustand";
import * as api from "../api/um2as";
import type { FilePage, Menu, MenuRow } from "../api/um2as";
import { goTo, say, tried } from "./load";
import { asking } from "./newest";
import { cameraAddress, now, put as putSession, sessionOf } from "./sessions";
import { get, keep, kept, set } from "./store";

interface Guide {
  menu: Menu | null;
  session: string | null;
  trial: string;
  /** The level that is shown, empty at the top; the task of it that is open. */
  level: string;
  task: string;
  /** Cameras for the coordinates, all where empty; the file that angles are taken of; the date for camera 1's file. */
  chosen: readonly string[];
  tdc: string;
  made: string;
  inverse: boolean;
  page: FilePage | null;
  /** Where in the menu another screen leads back to; empty where it was not come from. */
  from: string;
}

const today = (): string => new Date().toLocaleDateString("sv"); // YYYY-MM-DD of this place

export const useMenu = create<Guide>()(() => ({
  menu: null, session: null, trial: "", level: "", task: "", chosen: [], tdc: "", made: today(), inverse: false, page: null, from: kept("um2as", ""),
}));
export const guide = useMenu.getState;

/** Change it, so that the foot says anew what keys do. */
function put(some: Partial<Guide>): void {
  useMenu.setState(some);
  set({});
}

const address = (session: string, trial: string, level = "", task = ""): string => ["#/session", session, "um2as", trial, level, task].map((one, i) => (i ? encodeURIComponent(one) : one)).join("/").replace(/\/+$/, "");
export const menuAddress = (session: string): string => address(session, guide().session === session ? guide().trial : "");
const goInto = (level: string, task = ""): void => void (location.hash = address(guide().session!, guide().trial, level, task));

/** Show what an address says of the menu; whether it did. */
export async function arriveAtMenu(parts: readonly string[]): Promise<boolean> {
  const [, kind, id, name, trial = "", level = "", task = ""] = parts.map(decodeURIComponent);
  if (kind !== "session" || name !== "um2as" || !id) {
    if (!kind) leave();
    return false;
  }
  const fresh = guide().session !== id || guide().trial !== trial;
  put({ session: id, trial, level, task, page: null, ...(fresh ? { menu: null, chosen: [], tdc: "" } : {}) });
  if (now().session !== id) putSession({ session: id, cameras: null, control: null, pointing: null, lost: null, given: [], camera: "", point: "", white: null });
  leave();
  set({ screen: "um2as" });
  await fetchMenu();
  await fetchPage(1);
  return true;
}

/** The way back is forgotten: the menu itself is shown, or was left. */
const leave = (): void => (put({ from: "" }), keep("um2as", ""));

export async function fetchMenu(): Promise<void> {
  const { session, trial, chosen, tdc } = guide();
  const last = asking("menu"), menu = session && (await tried(() => api.menu(session, { trial, cameras: chosen, tdc })));
  if (menu && last() && guide().session === session && guide().trial === trial) put({ menu, tdc: menu.tdc });
}

export const rowOf = (key: string): MenuRow | undefined => guide().menu?.entries.find((row) => row.key === key);
export const rowsIn = (level: string): readonly MenuRow[] => guide().menu?.entries.filter((row) => row.above === level) ?? [];

/** The levels from the top to one. */
export function pathTo(level: string): readonly MenuRow[] {
  const row = rowOf(level);
  return row ? [...pathTo(row.above), row] : [];
}

/** Open an entry: a level, a task of this screen, or the screen where it is done. */
export function enter(row: MenuRow): void {
  if (row.place === "menu") return goInto(row.key);
  if (row.place === "here") return row.key === guide().task ? void process() : goInto(row.above, row.key);
  const { session, menu, trial } = guide(), id = menu?.trials.find((one) => one.name === (menu.trial || trial))?.id;
  put({ from: location.hash });
  keep("um2as", location.hash);
  if (row.place !== "cameras") return goTo(row.place, id ?? null);
  putSession({ pointing: true });
  location.hash = cameraAddress(session!);
}

/** Whether the person is below the top of the menu, or on a screen that it led to: it is left level by level. */
export const held = (): boolean => guide().from !== "" || (get().screen === "um2as" && (guide().level !== "" || guide().task !== ""));

/** Escape in the menu: the task closes, then a level; from the top it is left. */
export function menuUp(): boolean {
  const { level, task } = guide();
  if (get().screen !== "um2as") return false;
  if (task) goInto(level);
  else if (level) goInto(rowOf(level)?.above ?? "");
  else goTo("home");
  return true;
}

/** From another screen back to where it was come from. */
export function backToMenu(): boolean {
  const { from } = guide();
  if (!from || get().screen === "um2as") return false;
  location.hash = from;
  return true;
}

export function openMenu(): void {
  const session = sessionOf();
  if (session) location.hash = menuAddress(session);
}

const TASKS: Record<string, (g: Guide, session: string, trial: string) => Promise<api.Written>> = {
  "calibration-process": (g, session, trial) => api.parameters(session, trial, g.made),
  "digitising-save": (_, session, trial) => api.markers(session, trial),
  "xyz-process": (g, session, trial) => api.coordinates(session, { trial, cameras: [...g.chosen] }),
  "euler-process": (g, session, trial) => api.angles(session, { trial, tdc: g.tdc, inverse_cosines: g.inverse }),
};
export const canProcess = (): boolean => guide().task in TASKS && rowOf(guide().task)?.state !== "waits";

/** Do the task that is open. */
export async function process(): Promise<void> {
  const g = guide(), task = TASKS[g.task], session = g.session, trial = g.menu?.trial;
  if (!task || !session || trial === undefined || !canProcess()) return;
  const done = await tried(() => task(g, session, trial));
  if (!done) return;
  if (g.task === "xyz-process") put({ tdc: done.names[0] ?? "" });
  await fetchMenu();
  say("done", done.words);
}

/** The file that the open task shows; of several, the one that is chosen. */
export function shownFile(): string | null {
  const { task, page } = guide(), files = rowOf(task)?.files ?? [];
  if (!(task.endsWith("-view") || task.endsWith("-display")) || rowOf(task)?.state !== "done") return null;
  return page && files.includes(page.name) ? page.name : (files[0] ?? null);
}

export async function fetchPage(frame: number, name = shownFile()): Promise<void> {
  const { session, menu } = guide();
  if (!session || !menu || !name) return;
  const last = asking("page"), page = await tried(() => api.page(session, menu.trial, name, Math.max(1, frame)));
  if (page && last() && guide().session === session) put({ page });
}

export const turnPage = (by: number): void => void (guide().page && fetchPage(guide().page!.frame + by));

export async function choose(some: Partial<Pick<Guide, "chosen" | "tdc" | "made" | "inverse">>): Promise<void> {
  put(some);
  if (some.chosen || some.tdc) await fetchMenu();
}
