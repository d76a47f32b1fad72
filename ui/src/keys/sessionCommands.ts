/** Keys of the screens New session, Cameras & calibration, and Angles. */
import { answer, asked, back, calibrate, choose, lookAtSpike, makeSession, now, sessionOf, writeEuler } from "../state/sessions";
import { playhead } from "../state/store";
import type { Command } from "./commands";

const balls = (): boolean => now().control !== null && now().camera !== "";

/** The point after or before the one that is asked for. */
function step(by: 1 | -1): void {
  const own = now().control?.cameras.find((c) => c.name === now().camera), all = own ? asked(own) : [];
  const at = all.findIndex((b) => b.point === now().point);
  if (all.length) choose({ camera: now().camera, point: all[(at + by + all.length) % all.length]!.point });
}

export const SESSION_COMMANDS: readonly Command[] = [
  { id: "session-make", keys: ["Shift+Enter"], title: "Make the session", group: "Cameras", screens: ["new"], when: () => now().proposed?.lacking === "", foot: 1, hint: () => `make the session ${now().proposed?.name ?? ""}`, run: () => void makeSession(false) },
  { id: "calibrate", keys: ["Shift+Enter"], title: "Calibrate now", group: "Cameras", screens: ["cameras"], when: () => now().session !== null, foot: 4, hint: () => "calibrate now", run: () => void calibrate() },
  { id: "ball-none", keys: ["B"], title: "The camera does not see it", group: "Cameras", screens: ["cameras"], when: balls, foot: 1, hint: () => `${now().camera} does not see ${now().point}`, run: () => void answer({ seen: false }) },
  { id: "ball-back", keys: ["Backspace"], title: "Take the last answer back", group: "Cameras", screens: ["cameras"], when: () => balls() && now().given.length > 0, foot: 2, hint: () => `take ${now().given.at(-1)!.point} back`, run: () => void back() },
  { id: "ball-next", keys: ["N"], title: "Next ball", group: "Cameras", screens: ["cameras"], when: balls, foot: 3, hint: () => "next ball", run: () => step(1) },
  { id: "ball-previous", keys: ["Shift+N"], title: "Ball before", group: "Cameras", screens: ["cameras"], when: balls, run: () => step(-1) },
  { id: "frame-on", keys: ["Space"], title: "Next frame", group: "Time", screens: ["angles"], foot: 2, hint: () => "next frame", run: () => playhead.step(1) },
  { id: "frame-back", keys: ["Backspace"], title: "Frame before", group: "Time", screens: ["angles"], foot: 3, hint: () => "frame before", run: () => playhead.step(-1) },
  { id: "play-angles", keys: ["P"], title: "Play or pause", group: "Time", screens: ["angles"], foot: 4, hint: () => "play or pause", run: () => playhead.toggle() },
  { id: "spike-look", keys: ["Enter"], title: "Look at the marker that made the leap", group: "Time", screens: ["angles"], when: () => now().spike !== null, foot: 1, hint: () => `look at ${now().spike!.marker} in frame ${now().spike!.frame}`, run: lookAtSpike },
  { id: "euler", keys: ["Shift+E"], title: "Write the three Euler files", group: "Trial", screens: ["angles"], when: () => now().angles?.euler === true, foot: 6, hint: () => "write .shd .elb .wst", run: () => void writeEuler() },
  { id: "new", keys: ["Alt+Shift+N"], title: "New session from recordings", group: "Go to", run: () => void (location.hash = "#/new") },
  { id: "cameras", keys: ["Shift+C"], title: "Cameras & calibration", group: "Go to", when: () => sessionOf() !== null, run: () => void (location.hash = `#/session/${encodeURIComponent(sessionOf()!)}/cameras`) },
];
