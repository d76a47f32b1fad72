/** Numbers as people read them. */
/** Between thousands; no line ends there. */
const THIN = "\u202f";
/** mm from which on a distance is none that anybody measured, as in the program's words. */
const FAR_MM = 10_000;
export const mm = (value: number | null | undefined): string =>
  value == null || !Number.isFinite(value) ? "–" : value > FAR_MM ? `> ${count(FAR_MM)}` : value >= 100 ? value.toFixed(0) : value >= 10 ? value.toFixed(1) : value.toFixed(value < 1 ? 2 : 1);
export const percent = (p: number | null | undefined): string =>
  p == null ? "–" : p > 0.9995 ? "> 99.9 %" : p > 0.995 ? `${(100 * p).toFixed(1)} %` : p < 0.005 ? "< 1 %" : `${Math.round(100 * p)} %`;
export const count = (n: number | null | undefined): string => (n == null ? "–" : n.toLocaleString("en").replaceAll(",", THIN));
export const frames = (first: number, last: number): string => (first === last ? `f ${first}` : `f ${first}–${last}`);
/** An expected number: tenths where they tell. */
export const tenths = (n: number): string => (n < 10 ? n.toFixed(1) : String(Math.round(n)));
export const many = (n: number, one: string, more = `${one}s`): string => `${count(n)} ${n === 1 ? one : more}`;

/** m:ss.mmm from the first frame of the recording. */
export function clock(seconds: number): string {
  const whole = Math.max(0, seconds), m = Math.floor(whole / 60);
  return `${m}:${(whole - 60 * m).toFixed(3).padStart(6, "0")}`;
}

/** When, as short as it says enough: the time today, else the day. */
export function when(iso: string, now = new Date()): string {
  const at = new Date(iso);
  const pad = (n: number): string => String(n).padStart(2, "0");
  const day = `${at.getFullYear()}-${pad(at.getMonth() + 1)}-${pad(at.getDate())}`;
  const time = `${pad(at.getHours())}:${pad(at.getMinutes())}`;
  return at.toDateString() === now.toDateString() ? time : `${day} ${time}`;
}

/** A way to fill, short: a mean of several is called so. */
export const wayOf = (method: string): string => (method === "best" ? "the best way" : method.includes(" + ") ? `mean of ${method.split(" + ").length}` : method);

/** Letters of a name's end that are always seen: sides and numbers stand there; chosen. */
const END = 4;
/** A name in two, of which the second is never cut. */
export const ends = (name: string): [string, string] => [name.slice(0, Math.max(0, name.length - END)), name.slice(-END)];
/** A name of at most so many letters, cut in its middle. */
export const inShort = (name: string, most: number): string => (name.length > most ? `${name.slice(0, most - END - 1)}…${name.slice(-END)}` : name);
/** A name as long as there is room for it, cut in its middle where it must be; `width`: of words. */
export function fitting(name: string, room: number, width: (words: string) => number): string {
  let most = name.length;
  while (most > END + 2 && width(inShort(name, most)) > room) most--;
  return inShort(name, most);
}
