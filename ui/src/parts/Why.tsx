import { useState } from "react";
import { get, set } from "../state/store";
import { Modal } from "./Modal";
import styles from "./Modal.module.css";

/** A reason that is kept with the next act. */
export function Why(): React.JSX.Element {
  const [why, setWhy] = useState(get().why);
  const done = (e: React.FormEvent): void => (e.preventDefault(), set({ why, dialog: null }));
  return (
    <Modal title="Why: kept with what you do next">
      <form className={styles.body} onSubmit={done}>
        <input className="field" autoFocus aria-label="Reason" value={why} maxLength={2000} onChange={(e) => setWhy(e.target.value)} />
        <div className={styles.actions}><button className="button strong">Keep</button></div>
      </form>
    </Modal>
  );
}
