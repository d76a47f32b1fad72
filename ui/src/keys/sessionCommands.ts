/** Keys of the screens New session, Cameras & calibration, and Angles. */
import { goTo } from "../state/load";
import { answer, asked, back, calibrate, choose, lookAtSpike, makeSession, now, pointAtSpot, put, sessionOf, stepSpot, writeEuler } from "../state/sessions";
import { get, playhead, running, set, type State } from "../state/store";
import type { Command, Level } from "./commands";

const balls = (): boolean => now().control !== null && now().pointing === true && now().camera !== "";

/** Whether the point that is asked for was not said yet. */
const unsaid = (): boolean => now().control?.cameras.find((c) => c.name === now().camera && asked(c).some((b) => b.point === now().point && b.seen === null)) !== undefined;

/** The point after or before the one that is asked for. */
function step(by: 1 | -1): void {
  const own = now().control?.cameras.find((c) => c.name === now().camera), all = own ? asked(own) : [];
  const at = all.findIndex((b) => b.point === now().point);
  if (all.length) choose({ camera: now().camera, point: all[(at + by + all.length) % all.length]!.point });
}

/** Trials of Home in their order, each with its name; those with results before they can be looked at come as they stand. */
const trials = (s: State): { id: string; name: string }[] => (s.home ? [...s.home.sessions.flatMap((one) => one.trials), ...s.home.files] : []);
const folders = (): { id: string; name: string }[] => (now().folder ? [] : (now().folders ?? []).map((one) => ({ id: one.id, name: one.title })));
const listed = (s: State): { id: string; name: string }[] => (s.screen === "home" ? trials(s) : folders());
const marked = (s: State): { id: string; name: string } | undefined => listed(s).find((one) => one.id === s.marked) ?? listed(s)[0];

/** Mark the next or the one before; its button takes the focus. */
function mark(by: 1 | -1): void {
  const all = listed(get()), at = all.findIndex((one) => one.id === get().marked);
  if (all.length) set({ marked: all[at < 0 ? (by > 0 ? 0 : all.length - 1) : (at + by + all.length) % all.length]!.id });
}

function openMarked(): void {
  const one = marked(get());
  if (one && get().screen === "home") goTo("tracks", one.id);
  else if (one) location.hash = `#/new/${encodeURIComponent(one.id)}`;
}

const LISTS = ["home", "new"] as const;
const many = (s: State): boolean => listed(s).length > 0;

export const SESSION_COMMANDS: readonly Command[] = [
  { id: "trial-open", keys: ["Enter"], title: "Open the trial or folder that is marked", group: "Go to", screens: LISTS, when: many, foot: 1, hint: (s) => (s.screen === "home" ? `open ${marked(s)!.name}` : s.marked ? "look at this folder" : "look at the first folder"), run: openMarked },
  { id: "trial-next", keys: ["N"], title: "Next trial or folder", group: "Go to", screens: LISTS, when: many, foot: 2, hint: (s) => (s.screen === "home" ? "next trial" : "next folder"), run: () => mark(1) },
  { id: "trial-before", keys: ["Shift+N"], title: "Trial or folder before", group: "Go to", screens: LISTS, when: many, run: () => mark(-1) },
  { id: "session-make", keys: ["Shift+Enter"], title: "Make the session", group: "Cameras", screens: ["new"], when: () => now().proposed?.lacking === "", foot: 1, hint: () => `make the session ${now().proposed?.name ?? ""}`, run: () => void makeSession(false) },
  { id: "calibrate", keys: ["Shift+Enter"], title: "Calibrate now", group: "Cameras", screens: ["cameras"], when: (s) => now().session !== null && !running(s, now().session), foot: 4, hint: () => "calibrate now", run: () => void calibrate() },
  { id: "ball-point", keys: ["P"], title: "Point at the control balls, or look at the verdict", group: "Cameras", screens: ["cameras"], when: () => now().control !== null, foot: 5, hint: () => (now().pointing ? "the verdict" : "point at the balls"), run: () => put({ pointing: !now().pointing }) },
  { id: "ball-spot", keys: ["Space"], title: "Point at the white spot that is chosen", group: "Cameras", screens: ["cameras"], when: () => balls() && now().spot >= 0 && !now().spent, foot: 0, hint: () => `${now().point} is at the square`, run: pointAtSpot },
  { id: "ball-spot-next", keys: ["."], title: "Next white spot", group: "Cameras", screens: ["cameras"], when: balls, fits: unsaid, foot: 3, hint: () => "next white spot", run: () => stepSpot(1) },
  { id: "ball-spot-before", keys: [","], title: "White spot before", group: "Cameras", screens: ["cameras"], when: balls, run: () => stepSpot(-1) },
  { id: "ball-none", keys: ["B"], title: "The camera does not see it", group: "Cameras", screens: ["cameras"], when: balls, fits: unsaid, foot: 1, hint: () => `${now().camera} does not see ${now().point}`, run: () => void answer({ seen: false }) },
  { id: "ball-back", keys: ["Backspace"], title: "Take the last answer back", group: "Cameras", screens: ["cameras"], when: () => balls() && now().given.length > 0, foot: 2, hint: () => `take ${now().given.at(-1)!.point} back`, run: () => void back() },
  { id: "ball-next", keys: ["N"], title: "Next ball", group: "Cameras", screens: ["cameras"], when: balls, foot: 3, hint: () => "next ball", run: () => step(1) },
  { id: "ball-previous", keys: ["Shift+N"], title: "Ball before", group: "Cameras", screens: ["cameras"], when: balls, run: () => step(-1) },
  { id: "frame-on", keys: ["Space"], title: "Next frame", group: "Time", screens: ["angles"], foot: 2, hint: () => "next frame", run: () => playhead.step(1) },
  { id: "frame-back", keys: ["Backspace"], title: "Frame before", group: "Time", screens: ["angles"], foot: 3, hint: () => "frame before", run: () => playhead.step(-1) },
  { id: "play-angles", keys: ["P"], title: "Play or pause", group: "Time", screens: ["angles"], foot: 4, hint: () => "play or pause", run: () => playhead.toggle() },
  { id: "spike-look", keys: ["Enter"], title: "Look at the marker that made the leap", group: "Time", screens: ["angles"], when: () => now().spike !== null, foot: 1, hint: () => `look at ${now().spike!.marker} in frame ${now().spike!.frame}`, run: lookAtSpike },
  { id: "euler", keys: ["Shift+E"], title: "Write the three Euler files", group: "Trial", screens: ["angles"], when: () => now().angles?.euler === true, foot: 6, hint: () => "write .shd .elb .wst", run: () => void writeEuler() },
  { id: "new", keys: ["Alt+Shift+N"], title: "New session from recordings", group: "Go to", fits: (s) => s.screen === "home", foot: 58, hint: () => "new session", run: () => void (location.hash = "#/new") },
  { id: "cameras", keys: ["Shift+C"], title: "Cameras & calibration", group: "Go to", when: () => sessionOf() !== null, run: () => void (location.hash = `#/session/${encodeURIComponent(sessionOf()!)}/cameras`) },
];

/** What Escape closes on these screens first. */
export function sessionUp({ screen }: State, guided: boolean): Level | null {
  const { folder, pointing, control, lost, spike } = now();
  if (screen === "new" && folder) return { words: "another folder", run: () => void (location.hash = "#/new") };
  if (screen === "angles" && spike) return { words: "close the answer", run: () => put({ spike: null }) };
  if (screen !== "cameras") return null;
  if (control && pointing && !guided) return { words: "the verdict", run: () => put({ pointing: false }) };
  return lost ? { words: "all cameras again", run: () => put({ lost: null }) } : null;
}
