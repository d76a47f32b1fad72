import { CircleAlert, CircleCheck, Info } from "lucide-react";
import { byId, footLine } from "../keys/commands";
import { shownKey } from "../keys/bind";
import { useStore } from "../state/store";
import styles from "./Foot.module.css";

const ICON = { done: CircleCheck, refused: CircleAlert, news: Info };

/** Never cut off, however much there is to say. */
const ALWAYS: readonly string[] = ["help", "up"];

/** Who goes by keys presses the key itself, so that Tab passes over those that may be cut off. */
const key = ({ key, words, id }: ReturnType<typeof footLine>[number]): React.JSX.Element => (
  <li key={id}><button type="button" tabIndex={ALWAYS.includes(id) ? 0 : -1} onClick={byId(id).run}><kbd>{shownKey(key)}</kbd><span>{words}</span></button></li>
);

/** What the next key would do, and what the last one did. */
export function Foot(): React.JSX.Element {
  const state = useStore(), line = footLine(state), note = state.note, Icon = ICON[note?.kind ?? "news"];
  return (
    <footer className={styles.foot}>
      <ul className={styles.keys} aria-label="What keys would do now">
        {line.filter((one) => !ALWAYS.includes(one.id)).map(key)}
      </ul>
      <p className={`${styles.note} ${note ? styles[note.kind] : ""}`} role="status" data-note={note?.kind ?? ""}>{note && <><Icon size={14} aria-hidden /><span className={styles.said} title={note.words}>{note.words}</span></>}</p>
      <ul className={`${styles.keys} ${styles.always}`} aria-label="What keys do everywhere">{line.filter((one) => ALWAYS.includes(one.id)).map(key)}</ul>
    </footer>
  );
}
