/** Names of markers where there is little room. */
import type { TrialHeader } from "../api/types";

/** Without the subject, as in `Anna:LASI`. */
const own = (name: string): string => name.slice(name.lastIndexOf(":") + 1);

const known = new WeakMap<object, ReadonlyMap<string, string>>();

/** The name of a marker without its subject's, where no two markers are then called alike: it is the same before most names
 * of a file, and what tells them apart is cut off. */
export function withoutSubject(header: TrialHeader | null, name: string): string {
  if (!header || !name.includes(":")) return name;
  let names = known.get(header.tracks);
  if (!names) known.set(header.tracks, (names = shorter(header.tracks.map((track) => track.name))));
  return names.get(name) ?? name;
}

function shorter(names: readonly string[]): ReadonlyMap<string, string> {
  const times = new Map<string, number>();
  for (const name of names) times.set(own(name), (times.get(own(name)) ?? 0) + 1);
  return new Map(names.map((name) => [name, own(name) && times.get(own(name)) === 1 ? own(name) : name]));
}
