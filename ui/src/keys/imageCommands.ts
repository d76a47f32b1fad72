/** Commands of the screens Detect and Digitise. */
import * as d from "../state/detect";
import * as g from "../state/digitise";
import { runTrial } from "../state/load";
import { get, running, set, type State } from "../state/store";
import type { Command, Level } from "./commands";

const DETECT = ["detect"] as const, DIGITISE = ["digitise"] as const;
const there = (s: State): boolean => s.detect !== null;
const tried = (s: State): boolean => s.detect !== null && d.changed(s.detect);
const phase = (s: State): string => (s.digitise && s.digitise.shown === null ? s.digitise.now.question.phase : "");
const asks = (...phases: string[]) => (s: State): boolean => phases.includes(phase(s));
const name = (s: State): string => s.digitise?.now.question.marker ?? "";
const frame = (by: number) => (): void => d.goToFrame((d.detect()?.frame ?? 1) + by);

export const DETECT_COMMANDS: readonly Command[] = [
  { id: "detect-lower", keys: ["["], title: "Threshold 1 lower", group: "Detection", screens: DETECT, when: there, foot: 1, hint: () => "threshold lower", run: () => d.moveThreshold(-1) },
  { id: "detect-raise", keys: ["]"], title: "Threshold 1 higher", group: "Detection", screens: DETECT, when: there, foot: 2, hint: () => "higher", run: () => d.moveThreshold(1) },
  { id: "detect-apply", keys: ["Enter"], title: "Write what is tried into the session", group: "Detection", screens: DETECT, when: tried, foot: 0, hint: () => "apply to all frames", run: () => void d.applyDraft() },
  { id: "detect-forget", keys: ["Backspace"], title: "Forget what is tried", group: "Detection", screens: DETECT, when: tried, foot: 3, hint: () => "forget what is tried", run: d.forgetDraft },
  { id: "detect-mask", keys: ["M"], title: "Paint masks", group: "Detection", screens: DETECT, when: there, foot: 4, hint: (s) => (s.detect!.painting ? "no longer paint masks" : "paint masks"), run: d.flipPainting },
  { id: "detect-white", keys: ["P"], title: "Show white pixels", group: "Detection", screens: DETECT, when: there, foot: 5, hint: (s) => (s.detect!.white ? "without white pixels" : "white pixels"), run: d.flipWhite },
  { id: "detect-run", keys: ["Shift+Enter"], title: "Run the trial again", group: "Detection", screens: ["detect", "digitise", "tracks", "angles", "report", "history"], when: (s) => s.id !== null && !running(s, s.id) && (s.header ? s.header.session_id !== null && (s.screen === "detect" || s.screen === "digitise" || s.header.stale !== "") : s.runs), fits: (s) => s.screen !== "digitise" || !s.digitise || phase(s) === "done", foot: 8, hint: () => "run the trial", run: () => void runTrial() },
  { id: "detect-forward", keys: ["ArrowRight"], title: "1 frame on", group: "Time", screens: DETECT, when: there, foot: 6, hint: () => "next frame", run: frame(1) },
  { id: "detect-back", keys: ["ArrowLeft"], title: "1 frame back", group: "Time", screens: DETECT, run: frame(-1) },
  { id: "detect-forward-10", keys: ["Shift+ArrowRight"], title: "10 frames on", group: "Time", screens: DETECT, run: frame(10) },
  { id: "detect-back-10", keys: ["Shift+ArrowLeft"], title: "10 frames back", group: "Time", screens: DETECT, run: frame(-10) },
];

export const DIGITISE_COMMANDS: readonly Command[] = [
  { id: "digitise-spot", keys: ["Space"], title: "Point at the spot that is chosen", group: "Digitising", screens: DIGITISE, when: (s) => asks("point", "correct")(s) && s.digitise!.now.question.spots.length > 0, foot: 1, hint: (s) => `${name(s)} is at the ring`, run: g.pointAtSpot },
  { id: "digitise-next", keys: ["."], title: "Next spot", group: "Digitising", screens: DIGITISE, when: asks("point", "correct"), foot: 3, hint: () => "next spot", run: () => g.stepSpot(1) },
  { id: "digitise-before", keys: [","], title: "Spot before", group: "Digitising", screens: DIGITISE, when: asks("point", "correct"), run: () => g.stepSpot(-1) },
  { id: "digitise-yes", keys: ["Y"], title: "Yes; or, what the other cameras say", group: "Digitising", screens: DIGITISE, when: (s) => asks("reference", "verify")(s) || (asks("point")(s) && s.digitise!.now.question.said !== null), foot: 0, hint: (s) => (phase(s) === "point" ? "as the other cameras say" : "yes"), run: () => void g.answer({ kind: "yes" }) },
  { id: "digitise-no", keys: ["N"], title: "No, it is not", group: "Digitising", screens: DIGITISE, when: asks("reference", "verify"), foot: 1, hint: () => "no", run: () => void g.answer({ kind: "no" }) },
  { id: "digitise-absent", keys: ["B"], title: "The marker is not present", group: "Digitising", screens: DIGITISE, when: asks("point", "correct"), foot: 2, hint: (s) => `${name(s)} is not present`, run: () => void g.answer({ kind: "absent" }) },
  { id: "digitise-save", keys: ["Enter"], title: "Save the frame", group: "Digitising", screens: DIGITISE, when: asks("review"), foot: 0, hint: (s) => `save frame ${s.digitise!.now.question.frame}`, run: () => void g.answer({ kind: "save" }) },
  { id: "digitise-verify", keys: ["V"], title: "Verify marker by marker", group: "Digitising", screens: DIGITISE, when: asks("review"), foot: 1, hint: () => "verify marker by marker", run: () => void g.answer({ kind: "verify" }) },
  { id: "digitise-hand", keys: ["H"], title: "Digitise the whole frame by hand", group: "Digitising", screens: DIGITISE, when: asks("review"), foot: 4, hint: () => "all of it by hand", run: () => void g.answer({ kind: "hand" }) },
  { id: "digitise-undo", keys: ["Backspace"], title: "Take the last answer back", group: "Digitising", screens: DIGITISE, when: (s) => s.digitise?.now.can_undo === true, foot: 5, hint: () => "take the last answer back", run: () => void g.answer({ kind: "undo" }) },
  { id: "digitise-again", keys: ["R"], title: "Look again at the saved frame that is shown", group: "Digitising", screens: DIGITISE, when: (s) => { const x = s.digitise; return x !== null && x.shown !== null && g.isSaved(x.now, x.shown); }, foot: 0, hint: (s) => `change frame ${s.digitise!.shown}`, run: () => { const shown = get().digitise?.shown; if (shown) void g.answer({ kind: "frame", frame: shown }); } },
  { id: "digitise-here", keys: ["Home"], title: "Back to the frame that is asked about", group: "Time", screens: DIGITISE, when: (s) => s.digitise?.shown != null, foot: 1, hint: () => "back to the question", run: () => void g.showFrame(get().digitise?.now.question.frame ?? 1) },
  { id: "digitise-forward", keys: ["ArrowRight"], title: "1 frame on", group: "Time", screens: DIGITISE, when: (s) => s.digitise !== null, run: () => g.stepFrame(1) },
  { id: "digitise-back", keys: ["ArrowLeft"], title: "1 frame back", group: "Time", screens: DIGITISE, when: (s) => s.digitise !== null, fits: (s) => (s.digitise!.shown ?? s.digitise!.now.question.frame) > 1, foot: 6, hint: () => "frame before", run: () => g.stepFrame(-1) },
];

/** What Escape closes on these screens first. */
export function imageUp({ screen, detect, digitise }: State): Level | null {
  if (screen === "detect" && detect) {
    if (detect.painting) return { words: "no longer paint masks", run: d.flipPainting };
    if (detect.why) return { words: "close the answer", run: () => set({ detect: { ...detect, why: null } }) };
    if (detect.large) return { words: "all cameras", run: () => set({ detect: { ...detect, large: null } }) };
  }
  if (screen !== "digitise" || digitise?.shown == null) return null;
  return { words: "back to the question", run: () => set({ digitise: { ...digitise, shown: null } }) };
}
