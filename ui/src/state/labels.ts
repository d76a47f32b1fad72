/** Naming tracks one after another: each is looked at where it is, and the next comes by itself when one was named. */
import type { Proposal } from "../api/types";
import { asked, labelRows } from "../model/labels";
import { nearestSample } from "../model/paths";
import { claim } from "./acts";
import { get, playhead, set } from "./store";

const rows = (): Proposal[] => {
  const { header, labels, computed } = get();
  return header ? asked(labelRows(header, labels, computed)) : [];
};

/** Select a track and look at it, in the nearest frame that has it: most tracks that have no name are pieces. */
export function lookAtTrack(track: string): void {
  const { paths } = get(), path = paths?.byName.get(track), at = path && nearestSample(path, playhead.frame - paths!.firstFrame);
  if (at != null) playhead.pause(), playhead.go(at + paths!.firstFrame);
  set((s) => ({ track, selected: [track], focused: s.focused + 1 }));
}

/** The next track that somebody is asked about, or the one before. */
export function nextTrack(by: 1 | -1): void {
  const all = rows(), at = all.findIndex((p) => p.track === get().track);
  const next = all[at < 0 ? (by > 0 ? 0 : all.length - 1) : (at + by + all.length) % all.length];
  if (next) lookAtTrack(next.track);
}

/** Do something to a track; when it is done, the next that somebody is asked about, where they were asked about this one. */
export async function settle(track: string, work: () => Promise<unknown>): Promise<void> {
  const before = rows().map((p) => p.track), at = before.indexOf(track);
  const done = await work();
  if (!done || at < 0 || get().screen !== "labels" || get().dialog) return;
  const now = new Set(rows().map((p) => p.track)), next = [...before.slice(at + 1), ...before.slice(0, at)].find((one) => now.has(one));
  if (next) lookAtTrack(next);
}

/** A name for a track, null for none; then the next that somebody is asked about. */
export const nameTrack = (name: string | null, track: string): Promise<void> => settle(track, () => claim(name, track));
