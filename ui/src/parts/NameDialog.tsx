import { mm } from "../model/format";
import { nameChoices } from "../model/labels";
import { askJoin, claim } from "../state/acts";
import { nameTrack } from "../state/labels";
import { set, useStore } from "../state/store";
import { Chooser, type Choice } from "./Chooser";
import { Modal } from "./Modal";
import styles from "./Modal.module.css";

/** A name for the selected track; where another track has it, whether the two go together. */
export function NameDialog(): React.JSX.Element {
  const { header, selected, first, last, join, labels, screen } = useStore(), track = selected[0] ?? "";
  const choices = nameChoices(header, labels, track), names = choices.map((c) => c.id);
  const find = (typed: string): Choice[] => {
    const found = choices.filter((c) => c.id.toLowerCase().includes(typed.toLowerCase())), own = typed.trim();
    return own && !names.includes(own) && !own.startsWith("*") ? [...found, { id: own, words: own, beside: "a new name" }] : found;
  };
  const take = (name: string): void => (set({ dialog: null }), void (screen === "labels" ? nameTrack(name, track) : claim(name, track)));
  const about = first === null && last === null ? "all of it" : `frames ${first ?? "from the start"} to ${last ?? "the end"}`;
  return (
    <Modal title={`Which marker is ${track}? (${about})`}>
      <div className={styles.body}>
        <Chooser label="Name of the marker" find={find} onTake={take} onPoint={(name) => void askJoin(track, name)} />
        {join && join.track === track && (
          <p role="status" className={`${styles.join} ${join.join.connectable ? "" : styles.not}`}>
            <b>{join.join.connectable ? "They go together" : "They do not go together"}: </b>
            {join.join.overlap ? `both have ${join.join.overlap} frames, ` : `${join.join.gap} frames between them, `}
            {mm(join.join.off_mm)} mm apart where {mm(join.join.sd_mm)} mm are expected
            {!join.join.overlap && Number.isFinite(join.join.speed_mm_s) && `; ${(join.join.speed_mm_s / 1000).toFixed(2)} m/s across`}.
          </p>
        )}
      </div>
    </Modal>
  );
}
