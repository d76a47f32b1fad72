import { useState } from "react";
import type { SmoothingFunction } from "../api/types";
import { smoothBy } from "../state/acts";
import { get, set } from "../state/store";
import { Modal } from "./Modal";
import styles from "./Modal.module.css";

const WAYS: Record<SmoothingFunction, string> = {
  butterworth: "Butterworth, fourth order, without lag",
  woltring: "Woltring's quintic spline",
  moving_average: "Moving average",
};
/** Hz, that is offered: the usual cut-off of markers in gait. */
const USUAL_HZ = 6;

export function SmoothForm(): React.JSX.Element {
  const { selected, first, last } = get(), [way, setWay] = useState<SmoothingFunction>("butterworth"), [hz, setHz] = useState(USUAL_HZ);
  const smooth = (e: React.FormEvent): void => {
    e.preventDefault();
    set({ dialog: null });
    smoothBy(way, hz);
  };
  return (
    <Modal title={`Smooth ${selected[0]} in frames ${first}–${last}`}>
      <form className={styles.body} onSubmit={smooth}>
        <label className={styles.row}>Function <select className={`field ${styles.grow}`} autoFocus value={way} onChange={(e) => setWay(e.target.value as SmoothingFunction)}>{Object.entries(WAYS).map(([name, words]) => <option key={name} value={name}>{words}</option>)}</select></label>
        <label className={styles.row}>Cut-off, Hz <input className={`field ${styles.grow}`} type="number" min={0.1} step="any" required value={Number.isNaN(hz) ? "" : hz} onChange={(e) => setHz(e.target.valueAsNumber)} /></label>
        <div className={styles.actions}><button className="button strong">Smooth</button></div>
      </form>
    </Modal>
  );
}
