/** Requests that got no answer: what was asked for is asked for again when the server answers, and by no click. */
import { known, Refused } from "../api/client";
import { get } from "./store";

/** ms before the server is asked whether it is there, the first time and at most; chosen. */
const SOON_MS = 500, LATE_MS = 8000;

let wait = SOON_MS, waiting = false;

/** A request was answered. */
export const answered = (): void => void (wait = SOON_MS);

/** Where an error means that there was no answer: wait for the server, then do `again`. While the page's socket is closed
 * as well, it is this that waits. */
export function unanswered(error: unknown, again: () => Promise<void>): void {
  if (waiting || !(error instanceof Refused) || error.status !== 0) return;
  waiting = true;
  setTimeout(() => void look(error, again), wait);
  wait = Math.min(LATE_MS, 2 * wait);
}

async function look(error: Refused, again: () => Promise<void>): Promise<void> {
  const there = get().connected ? await known() : false;
  waiting = false;
  if (there) await again();
  else if (there === null) unanswered(error, again);
}
