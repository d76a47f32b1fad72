import { useState } from "react";
import { act } from "../state/acts";
import { playhead, set } from "../state/store";
import { Modal } from "./Modal";
import styles from "./Modal.module.css";

const LABELS = ["Foot Strike", "Foot Off", "General"], SIDES = ["Left", "Right", "General"];

export function EventForm(): React.JSX.Element {
  const [label, setLabel] = useState(LABELS[0]!), [side, setSide] = useState(SIDES[0]!);
  const add = (e: React.FormEvent): void => {
    e.preventDefault();
    set({ dialog: null });
    void act({ kind: "event", label, side, time_s: (playhead.frame - 1) / playhead.rate }, `${side} ${label} added`);
  };
  return (
    <Modal title={`An event in frame ${playhead.frame}`}>
      <form className={styles.body} onSubmit={add}>
        <label className={styles.row}>What <select className={`field ${styles.grow}`} autoFocus value={label} onChange={(e) => setLabel(e.target.value)}>{LABELS.map((one) => <option key={one}>{one}</option>)}</select></label>
        <label className={styles.row}>Side <select className={`field ${styles.grow}`} value={side} onChange={(e) => setSide(e.target.value)}>{SIDES.map((one) => <option key={one}>{one}</option>)}</select></label>
        <div className={styles.actions}><button className="button strong">Add</button></div>
      </form>
    </Modal>
  );
}
