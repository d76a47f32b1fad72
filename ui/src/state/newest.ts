/** Answers that come late: what was asked for before something else of its kind must not be taken for what is. */

const turns = new Map<string, number>();

/** Ask for something of a kind: whether nothing of that kind was asked for since. */
export function asking(kind: string): () => boolean {
  const turn = (turns.get(kind) ?? 0) + 1;
  turns.set(kind, turn);
  return () => turns.get(kind) === turn;
}
