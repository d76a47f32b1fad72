/** Keys of the menu of UM²AS; Escape, one level up, is every screen's. */
import { canProcess, enter, guide, openMenu, process, rowOf, rowsIn, turnPage } from "../state/um2as";
import { sessionOf } from "../state/sessions";
import type { Command } from "./commands";

const SCREENS = ["um2as"] as const;
const paged = (): boolean => (guide().page?.frames ?? 0) > 1;
const buttons = (): HTMLElement[] => [...document.querySelectorAll<HTMLElement>("[data-entry]")];
/** Which entry has the focus; −1 where none has. */
const marked = (): number => buttons().findIndex((one) => one === document.activeElement);
/** Whether keys are those of the entries: no task is open, or one has the focus. */
const listed = (): boolean => rowsIn(guide().level).length > 0 && (guide().task === "" || marked() >= 0);
const entry = (): ReturnType<typeof rowOf> => rowsIn(guide().level)[Math.max(0, marked())];

function mark(by: 1 | -1): void {
  const all = buttons(), at = marked();
  all[at < 0 ? (by > 0 ? 0 : all.length - 1) : (at + by + all.length) % all.length]?.focus();
}

/** The task that is open, else the entry that has the focus. */
function go(): void {
  const row = entry();
  if (canProcess()) void process();
  else if (row) enter(row);
}

export const UM2AS_COMMANDS: readonly Command[] = [
  { id: "um2as-process", keys: ["Enter"], title: "Do the task that is open, or go into the entry that is marked", group: "Digitising", screens: SCREENS, when: () => canProcess() || listed(), foot: 0, hint: () => rowOf(guide().task)?.title ?? "go into the entry", run: go },
  { id: "um2as-next", keys: ["ArrowDown"], title: "Next entry of the menu", group: "Go to", screens: SCREENS, when: listed, foot: 3, hint: () => "next entry", run: () => mark(1) },
  { id: "um2as-before", keys: ["ArrowUp"], title: "Entry of the menu before", group: "Go to", screens: SCREENS, when: listed, foot: 4, hint: () => "entry before", run: () => mark(-1) },
  { id: "um2as-on", keys: ["Space"], title: "Next frame", group: "Time", screens: SCREENS, when: paged, foot: 1, hint: () => "next frame", run: () => turnPage(1) },
  { id: "um2as-back", keys: ["Backspace"], title: "Frame before", group: "Time", screens: SCREENS, when: paged, foot: 2, hint: () => "frame before", run: () => turnPage(-1) },
  { id: "um2as", keys: ["Alt+Shift+U"], title: "The menu of UM²AS", group: "Go to", when: () => sessionOf() !== null && guide().from === "", run: openMenu },
];
