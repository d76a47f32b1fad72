/** What a way to settle a problem would give, drawn beside what is. */
import * as api from "../api/client";
import type { Alternative, GapCandidates, Problem } from "../api/types";
import { changes } from "../model/problems";
import { candidatePath, decodePart, joined, SHOWN, straightAcross, whole, type Path } from "../model/paths";
import { get, set } from "./store";

/** Times that a gap is asked about, and ms between, until its fills are there; chosen: a minute, as a whole trial may be judged before. */
const TRIES = 240, AGAIN_MS = 250;
/** What was pointed at last: an answer that comes later is not drawn over it. */
let pointed = "";

/** Ask what a way of the problem would give, the first that changes anything where none is said, and draw it. */
export async function drawInstead(problem: Problem, key?: string): Promise<void> {
  const { id, instead } = get(), other = problem.alternatives.find((a) => (key === undefined || a.key === key) && changes(a));
  if (!other?.act || !id) return;
  const mine = (pointed = `${problem.id} ${other.key}`);
  if (instead?.problem === problem.id && instead.key === other.key) return;
  const still = (): boolean => pointed === mine && get().problem === problem.id;
  const draw = (paths: readonly Path[], straight = false): void => {
    if (still() && paths.length) set({ instead: { problem: problem.id, key: other.key, paths, words: other.words, straight } });
  };
  try {
    if (other.action === "fill") await drawFill(id, problem, other, still, draw);
    else await drawPreview(id, other, draw);
  } catch {
    // what cannot be shown beforehand is still said in words
  }
}

async function drawPreview(id: string, other: Alternative, draw: (paths: readonly Path[], straight: boolean) => void): Promise<void> {
  const shown = await api.preview(id, other.act!);
  if (!shown) return;
  const part = decodePart(shown.paths), now = get().paths, start = part.firstFrame - (now?.firstFrame ?? 0);
  const would = whole([...part.byName.values()], part.firstFrame, now), drawn = would.map((path) => straightAcross(now?.byName.get(path.name), path, start, start + part.frames));
  draw(drawn, drawn.some((path, i) => path !== would[i]));
}

/** The fills of the gap of each marker, by the method that is said; the best so far where that is the best. */
async function drawFill(id: string, problem: Problem, other: Alternative, still: () => boolean, draw: (paths: readonly Path[]) => void): Promise<void> {
  const found = new Map<string, Path>(), method = other.key.replace(/^fill-/, "");
  const take = (of: GapCandidates): void => {
    const one = of.candidates.find((c) => c.method === (method === "best" ? of.best : method)) ?? (method === "best" ? of.candidates[0] : undefined);
    const { paths } = get(), fill = one && joined(candidatePath(of.marker, one.xyz, one.sd), of.first, paths);
    if (fill) found.set(of.marker, whole([fill.path], fill.at, paths)[0]!);
    draw([...found.values()]);
  };
  await Promise.all(problem.tracks.slice(0, SHOWN).map((marker) => askedUntilThere(id, marker, problem.first, still, take)));
}

/** Ask for the ways to fill a gap until all of them are there, and take what there is each time. */
export async function askedUntilThere(id: string, marker: string, first: number, still: () => boolean, take: (found: GapCandidates) => void): Promise<void> {
  for (let tries = 0; tries < TRIES; tries++) {
    const found = await api.gap(id, marker, first).catch(() => null);
    if (!found || !still()) return;
    take(found);
    if (!found.pending) return;
    await new Promise((done) => setTimeout(done, AGAIN_MS));
  }
}
