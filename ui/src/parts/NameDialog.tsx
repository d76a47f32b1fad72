import { frames, mm } from "../model/format";
import { askJoin, claim } from "../state/acts";
import { set, useStore } from "../state/store";
import { Chooser, type Choice } from "./Chooser";
import { Modal } from "./Modal";
import styles from "./Modal.module.css";

/** A name for the selected track; where another track has it, whether the two go together. */
export function NameDialog(): React.JSX.Element {
  const { header, selected, first, last, join, labels } = useStore(), track = selected[0] ?? "";
  const taken = new Map(header?.tracks.filter((t) => t.named && !t.computed).map((t) => [t.name, t]));
  const names = [...new Set([...(header?.marker_set?.names ?? []), ...taken.keys()])].filter((name) => name !== track);
  const proposal = labels?.proposals.find((p) => p.track === track)?.name;
  const choices = names.map((name): Choice => {
    const other = taken.get(name);
    return { id: name, words: name, beside: name === proposal ? "proposed" : other ? `has ${frames(other.first ?? 0, other.last ?? 0)}` : "free" };
  });
  choices.sort((a, b) => Number(b.id === proposal) - Number(a.id === proposal) || Number(taken.has(a.id)) - Number(taken.has(b.id)));
  const find = (typed: string): Choice[] => {
    const found = choices.filter((c) => c.id.toLowerCase().includes(typed.toLowerCase())), own = typed.trim();
    return own && !names.includes(own) && !own.startsWith("*") ? [...found, { id: own, words: own, beside: "a new name" }] : found;
  };
  const take = (name: string): void => (set({ dialog: null }), claim(name, track));
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
            {Number.isFinite(join.join.speed_mm_s) && `; ${(join.join.speed_mm_s / 1000).toFixed(2)} m/s across`}.
          </p>
        )}
      </div>
    </Modal>
  );
}
