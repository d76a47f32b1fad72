import { COMMANDS, type Group } from "../keys/commands";
import { shownKey } from "../keys/bind";
import { keep, set, useStore } from "../state/store";
import { Modal } from "./Modal";
import styles from "./Modal.module.css";

const GROUPS: readonly Group[] = ["Cameras", "Detection", "Digitising", "Problems", "Names", "Gaps and places", "Time", "View", "Trial", "Go to"];
const keys = (all: readonly string[]): string[] => all.map((key) => shownKey(key));

export function Help(): React.JSX.Element {
  const letters = useStore((s) => s.letters);
  const flip = (): void => (keep("letters", letters ? "off" : "on"), set({ letters: !letters }));
  return (
    <Modal title="Keys" wide>
      <div className={styles.keys} tabIndex={0} role="region" aria-label="All keys">
        {GROUPS.map((group) => (
          <section key={group}>
            <h3>{group}</h3>
            <ul>
              {COMMANDS.filter((c) => c.group === group).map((c) => (
                <li key={c.id}>{c.title}<span>{keys(c.keys).map((key) => <kbd key={key}>{key}</kbd>)}</span></li>
              ))}
            </ul>
          </section>
        ))}
      </div>
      <div className={styles.body}>
        <label className={styles.row}><input type="checkbox" checked={letters} onChange={flip} />Single letters do something (without them, use Ctrl K)</label>
      </div>
    </Modal>
  );
}
