/** The start-up of digitising: which markers are asked for, until which frame, and how much the operator is asked. */
import { useEffect, useState } from "react";
import * as api from "../api/client";
import type { SetupBody, StartUp as Choices } from "../api/types";
import { leaveOff, setUp } from "../state/digitise";
import { useStore } from "../state/store";
import styles from "./StartUp.module.css";

/** Most markers of a frame, as UM²AS has it; most frames of which one is taken, as a session has it. */
const MOST = 30, MOST_SKIPPED = 1000;

/** Names from what was typed: apart by commas or spaces, or a number, which says how many there are. */
export function namesOf(typed: string): string[] {
  const names = typed.split(/[\s,;]+/).filter(Boolean), n = Number(names[0]);
  return names.length === 1 && Number.isInteger(n) && n > 0 && n <= MOST ? Array.from({ length: n }, (_, i) => String(i + 1)) : names;
}

export function StartUp({ done }: { done: () => void }): React.JSX.Element | null {
  const id = useStore((s) => s.id), [choices, setChoices] = useState<Choices | null>(null);
  useEffect(() => {
    if (id) void api.startUp(id).then(setChoices, () => null); // why it cannot be had stands there already
  }, [id]);
  return choices && <Form key={choices.now.markers?.join(" ")} choices={choices} done={done} />;
}

function Form({ choices, done }: { choices: Choices; done: () => void }): React.JSX.Element {
  const [typed, setTyped] = useState(choices.now.markers.join(" ")), [said, setSaid] = useState<SetupBody>(choices.now);
  const names = namesOf(typed), taken = Math.ceil(choices.frames / (said.every || 1)), reference = said.reference && names.includes(said.reference) ? said.reference : null, say = (some: Partial<SetupBody>): void => setSaid({ ...said, ...some });
  const submit = async (e: React.FormEvent): Promise<void> => {
    e.preventDefault();
    if (await setUp({ ...said, markers: names, reference, reference_files: reference ? said.reference_files : null })) done();
  };
  return (
    <form className={styles.form} aria-label="Start-up information" onSubmit={(e) => void submit(e)}>
      <h2>Start-up information</h2>
      <label className={styles.line}>Markers, in the order in which they are asked for, or how many
        <input className="field" value={typed} onChange={(e) => setTyped(e.target.value)} placeholder="ACR1 ACR2 ARM3 ELB4 … or 8" />
      </label>
      <div className={styles.two}>
        <label className={styles.line}>Reference marker, which does not move
          <select className="field" value={reference ?? ""} onChange={(e) => say({ reference: e.target.value || null })}><option value="">none</option>{names.map((name, i) => <option key={`${name} ${i}`}>{name}</option>)}</select>
        </label>
        {reference && choices.reference_files.length > 0 && (
          <label className={styles.line}>Its place at the calibration
            <select className="field" value={said.reference_files ?? ""} onChange={(e) => say({ reference_files: e.target.value || null })}><option value="">as session.toml says</option>{choices.reference_files.map((name) => <option key={name} value={name}>{name}.rf1 …</option>)}</select>
          </label>
        )}
      </div>
      <label className={styles.check}><input type="checkbox" checked={said.confirm_reference} disabled={!reference} onChange={(e) => say({ confirm_reference: e.target.checked })} />ask in every frame whether it is the reference marker</label>
      <label className={styles.check}><input type="checkbox" checked={said.take_proposals} onChange={(e) => say({ take_proposals: e.target.checked })} />take what the other cameras say without asking</label>
      <label>remember a hidden marker for <input className={`field ${styles.short}`} type="number" min={2} max={100} value={said.history} onChange={(e) => say({ history: e.target.valueAsNumber || 2 })} /> frames</label>
      <label>frames skipped: one frame of every <input className={`field ${styles.short}`} type="number" min={1} max={Math.min(choices.frames, MOST_SKIPPED)} value={said.every} onChange={(e) => say({ every: e.target.valueAsNumber || 1, last_frame: null })} /> of the recording is taken</label>
      <label>last frame to be digitised <input className={`field ${styles.short}`} type="number" min={1} max={taken} value={said.last_frame ?? taken} onChange={(e) => say({ last_frame: e.target.valueAsNumber >= taken ? null : e.target.valueAsNumber || null })} /> of {taken}</label>
      <label>recorded on <input className="field" type="date" value={said.recorded ?? ""} onChange={(e) => say({ recorded: e.target.value || null })} /></label>
      <div className={styles.row}>
        <button type="submit" className="button strong" disabled={!names.length}>Begin to digitise</button>
        {choices.operated && <button type="button" className="button" onClick={() => void leaveOff()}>Find them by themselves</button>}
      </div>
    </form>
  );
}
