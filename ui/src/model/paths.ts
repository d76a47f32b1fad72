/** Paths of markers as typed arrays: one record a marker, so that an edit replaces one and shares the rest. */
import type { ChangedPaths, GapRow, PathsHeader, PathsPart, TrialHeader } from "../api/types";

export const MISSING = 0, MEASURED = 1, FILLED = 2, EDITED = 3;
export const ORIGINS = ["missing", "measured", "filled", "edited"] as const;

/** One path of n frames: xyz (n × 3) mm, NaN where missing; sd (n) mm, of the largest axis; origin (n). */
export interface Path {
  readonly name: string;
  readonly xyz: Float32Array;
  readonly sd: Float32Array;
  readonly origin: Uint8Array;
  readonly cov?: Float32Array;
  readonly residual?: Float32Array;
  readonly cameras?: Uint8Array;
}

/** Gaps between samples of these markers, and how many of them have one. */
export function gapsOf(paths: readonly Path[]): { gaps: number; markers: number } {
  let gaps = 0, markers = 0;
  for (const { origin } of paths) {
    let own = 0, seen = false;
    for (let i = 0; i < origin.length; i++) if (origin[i]) (own += seen && !origin[i - 1] ? 1 : 0), (seen = true);
    gaps += own;
    markers += own ? 1 : 0;
  }
  return { gaps, markers };
}

/** The same of gaps that are known, without those that somebody chose a way for: their fills may still be worked out. */
export function leftOpen(gaps: readonly GapRow[]): { gaps: number; markers: number } {
  const open = gaps.filter((gap) => gap.choice == null || gap.choice === "open");
  return { gaps: open.length, markers: new Set(open.map((gap) => gap.marker)).size };
}

export interface PathSet {
  readonly firstFrame: number;
  readonly frames: number;
  readonly head: string;
  /** Chosen fills are still computed: ask again. */
  readonly pending: boolean;
  readonly byName: ReadonlyMap<string, Path>;
}

const WIDTH = { xyz: 12, sd: 4, origin: 1, cov: 24, residual: 4, cameras: 1 } as const;

/** The paths of an answer's body: its columns one after the other, each of all markers. */
export function decodePaths(header: PathsHeader, body: ArrayBuffer): PathSet {
  const { names, n_frames: n } = header;
  const at: Partial<Record<keyof typeof WIDTH, number>> = {};
  let offset = 0;
  for (const column of header.columns) {
    at[column] = offset;
    offset += WIDTH[column] * n * names.length;
  }
  if (offset !== body.byteLength) throw new Error(`paths of ${body.byteLength} bytes, wanted ${offset}`);
  const floats = (column: "xyz" | "sd" | "cov" | "residual", i: number): Float32Array | undefined => {
    const start = at[column], width = WIDTH[column] / 4;
    if (start === undefined) return undefined;
    const from = start + i * n * width * 4; // not always a multiple of 4 after a column of bytes
    return from % 4 ? new Float32Array(body.slice(from, from + n * width * 4)) : new Float32Array(body, from, n * width);
  };
  const bytes = (column: "origin" | "cameras", i: number): Uint8Array | undefined =>
    at[column] === undefined ? undefined : new Uint8Array(body, at[column] + i * n, n);
  const byName = new Map(
    names.map((name, i): [string, Path] => [
      name,
      {
        name, xyz: floats("xyz", i)!, sd: floats("sd", i)!, origin: bytes("origin", i)!,
        cov: floats("cov", i), residual: floats("residual", i), cameras: bytes("cameras", i),
      },
    ]),
  );
  return { firstFrame: header.first_frame, frames: n, head: header.head, pending: header.pending, byName };
}

/** Paths of a message: base64 of the columns that `paths` has. */
export function decodePart({ names, first_frame, n_frames, xyz, sd, origin }: PathsPart): PathSet {
  const columns = [xyz, sd, origin].map(bytesOf), body = new Uint8Array(columns.reduce((n, column) => n + column.length, 0));
  let at = 0;
  for (const column of columns) body.set(column, at), (at += column.length);
  return decodePaths({ names, first_frame, n_frames, columns: ["xyz", "sd", "origin"], view: "edited", head: "", pending: false }, body.buffer);
}

/** Newer browsers have a decoder that is fifty times as fast. */
const native = (Uint8Array as { fromBase64?: (text: string) => Uint8Array<ArrayBuffer> }).fromBase64;
const bytesOf = (text: string): Uint8Array<ArrayBuffer> => native?.call(Uint8Array, text) ?? Uint8Array.from(atob(text), (c) => c.charCodeAt(0));

/** The paths that an act changed: each is its base, or nothing, but in the frames of the message. */
export function changedPaths(whole: PathSet, message: ChangedPaths): PathSet {
  const part = decodePart(message), at = part.firstFrame - whole.firstFrame, all = part.frames === whole.frames;
  const byName = new Map(message.names.map((name, i): [string, Path] => [name, all ? part.byName.get(name)! : onBase(whole.byName.get(message.bases[i]!), part.byName.get(name)!, at, whole.frames)]));
  return { ...whole, byName };
}

/** A path of n frames: some frames of it laid over its base. What it has all of its base is the same, so that it need not be looked at anew. */
function onBase(base: Path | undefined, { name, xyz, sd, origin }: Path, at: number, n: number): Path {
  if (base && !origin.length) return { name, xyz: base.xyz, sd: base.sd, origin: base.origin };
  const whole = { name, xyz: base?.xyz.slice() ?? new Float32Array(3 * n).fill(NaN), sd: base?.sd.slice() ?? new Float32Array(n).fill(NaN), origin: base?.origin.slice() ?? new Uint8Array(n) };
  whole.xyz.set(xyz, 3 * at), whole.sd.set(sd, at), whole.origin.set(origin, at);
  return whole;
}

/** The set with some paths replaced, and some gone. */
export function mergePaths(whole: PathSet, some: PathSet, removed: readonly string[] = []): PathSet {
  const byName = new Map(whole.byName);
  for (const name of removed) byName.delete(name);
  for (const [name, path] of some.byName) byName.set(name, path);
  return { ...whole, head: some.head, pending: some.pending, byName };
}

/** Names of the points of a file that are no markers: axes of segments, centres of joints, midpoints. */
export const computedNames = (header: TrialHeader | null): string[] => (header?.tracks ?? []).filter((t) => t.computed).map((t) => t.name);

/** The paths that are shown: points that are no markers only where they are asked for. The same set where there are none. */
export function shownPaths(header: TrialHeader | null, paths: PathSet | null, computed: boolean): PathSet | null {
  const away = new Set(computed ? [] : computedNames(header));
  return paths && away.size ? { ...paths, byName: new Map([...paths.byName].filter(([name]) => !away.has(name))) } : paths;
}

/** A run of frames of one origin: start included, end excluded, counted from 0. */
export interface Run { start: number; end: number; origin: number }

const KNOWN = new WeakMap<Uint8Array, readonly Run[]>();

/** The runs of a path, first to last; looked for once, as origins of a path never change. */
export function runs(origin: Uint8Array): readonly Run[] {
  const known = KNOWN.get(origin);
  if (known) return known;
  const found: Run[] = [];
  KNOWN.set(origin, found);
  for (let start = 0, i = 1; i <= origin.length; i++) {
    if (i === origin.length || origin[i] !== origin[start]) {
      found.push({ start, end: i, origin: origin[start]! });
      start = i;
    }
  }
  return found;
}

const SD = new WeakMap<Float32Array, boolean>();

/** Whether anything is known of how uncertain a path is, as most files say nothing of it; looked for once. */
export function hasSd({ sd }: Path): boolean {
  let known = SD.get(sd);
  if (known === undefined) SD.set(sd, (known = sd.some((v) => v > 0)));
  return known;
}

/** mm/s of each frame, from the frames beside it; NaN where one is missing. */
export function speed(path: Path, rate: number): Float32Array {
  const n = path.sd.length, out = new Float32Array(n).fill(NaN), x = path.xyz;
  for (let i = 1; i + 1 < n; i++) {
    const a = 3 * (i - 1), b = 3 * (i + 1), dx = x[b]! - x[a]!, dy = x[b + 1]! - x[a + 1]!, dz = x[b + 2]! - x[a + 2]!;
    out[i] = (Math.sqrt(dx * dx + dy * dy + dz * dz) * rate) / 2; // hypot takes ten times as long
  }
  return out;
}

/** mm of the step into each frame; NaN where one of the two is missing. */
export function jump(path: Path, index: number): number {
  const x = path.xyz, a = 3 * (index - 1), b = 3 * index;
  return index < 1 ? NaN : Math.hypot(x[b]! - x[a]!, x[b + 1]! - x[a + 1]!, x[b + 2]! - x[a + 2]!);
}

/** The frame, counted from 0, in which a path is there and that is nearest to one; null where it is never there. */
export function nearestSample({ origin }: Path, index: number): number | null {
  for (let off = 0; off < origin.length + Math.abs(index); off++) for (const i of [index - off, index + off]) if (origin[i]) return i;
  return null;
}

/** Two paths with their samples exchanged in [start, end): what an exchange of names would give. */
export function exchanged(a: Path, b: Path, start: number, end: number): [Path, Path] {
  const swapped = (own: Path, other: Path): Path => {
    const xyz = own.xyz.slice(), sd = own.sd.slice(), origin = own.origin.slice();
    xyz.set(other.xyz.subarray(3 * start, 3 * end), 3 * start);
    sd.set(other.sd.subarray(start, end), start);
    origin.set(other.origin.subarray(start, end), start);
    return { name: own.name, xyz, sd, origin };
  };
  return [swapped(a, b), swapped(b, a)];
}

/** Pieces of paths as paths of all frames of the trial, so that the frame means the same everywhere. */
export function whole(pieces: readonly Path[], at: number, paths: PathSet | null): Path[] {
  return pieces.map((piece) => {
    const n = paths?.frames ?? 0, from = at - (paths?.firstFrame ?? 0);
    if (piece.origin.length === n && from === 0) return piece;
    const xyz = new Float32Array(3 * n).fill(NaN), sd = new Float32Array(n).fill(NaN), origin = new Uint8Array(n);
    const skip = Math.max(0, -from), to = Math.max(0, from), own = Math.max(0, n - to);
    xyz.set(piece.xyz.subarray(3 * skip, 3 * (skip + own)), 3 * to), sd.set(piece.sd.subarray(skip, skip + own), to), origin.set(piece.origin.subarray(skip, skip + own), to);
    return { name: piece.name, xyz, sd, origin };
  });
}

/** A way to fill as a path of the gap's frames. */
export function candidatePath(name: string, xyz: readonly (readonly number[])[], sd: readonly (readonly number[])[] | null): Path {
  const n = xyz.length, cov = new Float32Array(6 * n).fill(NaN);
  for (const [i, s] of (sd ?? []).entries()) (cov[6 * i] = s[0]! ** 2), (cov[6 * i + 3] = s[1]! ** 2), (cov[6 * i + 5] = s[2]! ** 2);
  return { name, xyz: Float32Array.from(xyz.flat()), sd: sd ? Float32Array.from(sd.map((s) => Math.max(...s))) : new Float32Array(n).fill(NaN), origin: new Uint8Array(n).fill(2), cov };
}

/** A piece with the samples beside it, so that its line goes on from them and a single frame is a line too. */
export function joined(piece: Path, first: number, paths: PathSet | null): { path: Path; at: number } {
  const own = paths?.byName.get(piece.name), n = piece.origin.length, from = first - (paths?.firstFrame ?? 0);
  const xyz = new Float32Array(3 * (n + 2)).fill(NaN), sd = new Float32Array(n + 2).fill(NaN), cov = new Float32Array(6 * (n + 2)).fill(NaN), origin = new Uint8Array(n + 2);
  xyz.set(piece.xyz, 3), sd.set(piece.sd, 1), origin.set(piece.origin, 1);
  if (piece.cov) cov.set(piece.cov, 6);
  for (const [at, i] of [[0, from - 1], [n + 1, from + n]] as const) if (own?.origin[i]) xyz.set(own.xyz.subarray(3 * i, 3 * i + 3), 3 * at), (origin[at] = own.origin[i]!);
  return { path: { ...piece, xyz, sd, origin, cov }, at: first - 1 };
}

/** Markers of which curves are shown, at most; chosen: as many as colours tell apart. */
export const SHOWN = 4;
/** What would be, of the markers whose curves are shown: of a few all of it, as it may have other names. */
export const besideCurves = (instead: readonly Path[], seen: readonly string[]): readonly Path[] =>
  seen.length > SHOWN ? instead.filter((path) => seen.slice(0, SHOWN).includes(path.name)) : instead;

/** A path as it would be in [start, end), as elsewhere it stays; straight across the samples that it would lose, of which nothing
 * would be drawn else. The same path where it loses none between two that it keeps. */
export function straightAcross(own: Path | undefined, would: Path, start: number, end: number): Path {
  if (!own) return would;
  const n = own.origin.length, at = (i: number): Path => (i >= start && i < end ? would : own);
  const next = (i: number, by: 1 | -1): number => {
    while (i >= 0 && i < n && !at(i).origin[i]) i += by;
    return i;
  };
  let drawn: Path | null = null;
  for (let i = start; i < end; i++) {
    if (would.origin[i] || !own.origin[i]) continue;
    const a = next(i, -1), b = next(i, 1);
    if (a >= 0 && b < n) line((drawn ??= { name: would.name, xyz: would.xyz.slice(), sd: would.sd.slice(), origin: would.origin.slice() }), a, at(a), b, at(b));
    i = b;
  }
  return drawn ?? would;
}

/** Draw a line into a path, from sample a of one to sample b of another. */
function line(to: Path, a: number, from: Path, b: number, until: Path): void {
  for (let i = a; i <= b; i++) {
    for (let k = 0; k < 3; k++) to.xyz[3 * i + k] = from.xyz[3 * a + k]! + ((until.xyz[3 * b + k]! - from.xyz[3 * a + k]!) * (i - a)) / (b - a);
    to.origin[i] = FILLED;
  }
}
