/** Keys of the menu of UM²AS; Escape, one level up, is every screen's. */
import { canProcess, guide, openMenu, process, rowOf, turnPage } from "../state/um2as";
import { sessionOf } from "../state/sessions";
import type { Command } from "./commands";

const SCREENS = ["um2as"] as const;
const paged = (): boolean => (guide().page?.frames ?? 0) > 1;

export const UM2AS_COMMANDS: readonly Command[] = [
  { id: "um2as-process", keys: ["Enter"], title: "Do the task that is open", group: "Digitising", screens: SCREENS, when: canProcess, foot: 0, hint: () => rowOf(guide().task)?.title ?? "do it", run: () => void process() },
  { id: "um2as-on", keys: ["Space"], title: "Next frame", group: "Time", screens: SCREENS, when: paged, foot: 1, hint: () => "next frame", run: () => turnPage(1) },
  { id: "um2as-back", keys: ["Backspace"], title: "Frame before", group: "Time", screens: SCREENS, when: paged, foot: 2, hint: () => "frame before", run: () => turnPage(-1) },
  { id: "um2as", keys: ["Alt+Shift+U"], title: "The menu of UM²AS", group: "Go to", when: () => sessionOf() !== null && guide().from === "", run: openMenu },
];
