/** From key presses to commands. */
import { get } from "../state/store";
import { COMMANDS, possible } from "./commands";

interface Press { key: string; ctrlKey: boolean; metaKey: boolean; altKey: boolean; shiftKey: boolean; code?: string }

/** A press as the table writes it. Letters are upper case; signs such as ? and [ carry no Shift of their own. */
export function chord(e: Press): string {
  const digit = e.shiftKey && e.code?.startsWith("Digit") ? e.code.slice(5) : null; // Shift+1 is ! on one keyboard, + on another
  const key = digit ?? (e.key === " " ? "Space" : e.key.length === 1 ? e.key.toUpperCase() : e.key);
  const sign = key.length === 1 && key.toLowerCase() === key.toUpperCase() && !digit;
  const third = sign && e.altKey && !/\d/.test(key); // signs such as [ stand on a key's third level on many keyboards: AltGr, which some send as Ctrl+Alt; Alt with a digit is the browser's
  const parts = [!third && (e.ctrlKey || e.metaKey) ? "Ctrl" : "", !third && e.altKey ? "Alt" : "", e.shiftKey && !sign ? "Shift" : "", key];
  return parts.filter(Boolean).join("+");
}

const typedInto = (target: EventTarget | null): boolean =>
  (target instanceof HTMLInputElement && target.type !== "checkbox" && target.type !== "range") || target instanceof HTMLTextAreaElement || target instanceof HTMLSelectElement;

const inDialog = (target: EventTarget | null): boolean => target instanceof HTMLElement && target.closest("dialog") !== null;

/** Whether a key is typed into something, or belongs to what has the focus. */
function taken(target: EventTarget | null, pressed: string): boolean {
  if (!(target instanceof HTMLElement)) return false;
  if (inDialog(target)) return true;
  if (typedInto(target)) return !["Escape", "F1", "Ctrl+K"].includes(pressed);
  const own = target.closest("button, a, summary, [role=tab]") !== null;
  if (own && (pressed === "Enter" || pressed === "Space")) return true;
  return target.getAttribute("role") === "separator" && pressed.includes("Arrow");
}

/** One letter or sign without Ctrl or Alt: what may be switched off (WCAG 2.1.4). */
export const single = (pressed: string): boolean => /^(Shift\+)?[^+]$/.test(pressed) || pressed === "+";

export function onKey(event: KeyboardEvent): void {
  const pressed = chord(event), s = get();
  if (pressed === "F1") event.preventDefault(); // the browser's own help, also over a dialog
  if (event.defaultPrevented && pressed !== "F1") return;
  if (pressed === "Escape" && typedInto(event.target) && !inDialog(event.target)) return (event.target as HTMLElement).blur(); // the field is one level, too
  if (taken(event.target, pressed) || (!s.letters && single(pressed) && pressed !== "?")) return;
  const command = COMMANDS.find((c) => c.keys.includes(pressed) && possible(c, s));
  if (!command) return;
  event.preventDefault();
  command.run();
}

/** A key as it is printed on keyboards. */
export const shownKey = (key: string): string =>
  key.replace("Shift+", "⇧ ").replace("Ctrl+", "Ctrl ").replace("Alt+", "Alt ").replace("ArrowRight", "→").replace("ArrowLeft", "←").replace("ArrowUp", "↑").replace("ArrowDown", "↓").replace("Delete", "Del").replace("Escape", "Esc").replace("-", "–");
