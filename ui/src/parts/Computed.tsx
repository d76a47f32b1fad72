/** Points of a file that are no markers: how many are put aside, and the button that shows them. */
import { byId } from "../keys/commands";
import { many } from "../model/format";
import { computedNames } from "../model/paths";
import { useParts } from "../state/store";
import styles from "./Computed.module.css";

export function Computed({ className = "" }: { className?: string }): React.JSX.Element | null {
  const { header, computed } = useParts("header", "computed"), n = computedNames(header).length;
  if (!n) return null;
  const what = many(n, "computed point");
  return (
    <button type="button" className={`button ${styles.computed} ${className}`} aria-pressed={computed} title="Axes of segments, centres of joints, midpoints: worked out of markers by the program that wrote the file" onClick={byId("computed").run}>
      {computed ? `Put ${what} aside` : `Show ${what}, which ${n === 1 ? "is no marker" : "are no markers"}`}<kbd>J</kbd>
    </button>
  );
}
