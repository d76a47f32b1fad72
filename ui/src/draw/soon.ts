/** What is drawn anew at once, not with the next picture of the screen, whose time is short: once for all that changed together. */
const waiting = new WeakSet<object>();

export function soon(owner: object, draw: () => void): void {
  if (waiting.has(owner)) return;
  waiting.add(owner);
  queueMicrotask(() => {
    waiting.delete(owner);
    draw();
  });
}
