import { again } from "../state/load";
import { useStore } from "../state/store";

/** What stands where something is asked for that is not there yet; and where it could not be had, that it is asked for again. */
export function Asked({ words }: { words: string }): React.JSX.Element {
  const busy = useStore((s) => s.busy > 0), refused = useStore((s) => s.note?.kind === "refused");
  if (busy || !refused) return <p className="soft" role="status">{words}</p>;
  return <p role="alert">This could not be had; the line below says why. <button type="button" className="button" onClick={() => void again()}>Ask again</button></p>;
}
