/** The start-up of digitising: which markers are asked for, and how much the operator wants to be asked. */
import { useState } from "react";
import type { DigitisingNow } from "../api/types";
import { setUp } from "../state/digitise";
import styles from "./StartUp.module.css";

/** Names from what was typed: apart by commas or spaces, or a number, which says how many there are. */
export function namesOf(typed: string): string[] {
  const names = typed.split(/[\s,;]+/).filter(Boolean), n = Number(names[0]);
  return names.length === 1 && Number.isInteger(n) && n > 0 && n <= 30 ? Array.from({ length: n }, (_, i) => String(i + 1)) : names;
}

export function StartUp({ now, done }: { now: DigitisingNow | null; done: () => void }): React.JSX.Element {
  const [typed, setTyped] = useState(now?.markers.join(" ") ?? ""), [reference, setReference] = useState(now?.reference ?? "");
  const [confirm, setConfirm] = useState(now?.confirm_reference ?? true), [take, setTake] = useState(now?.take_proposals ?? false), [history, setHistory] = useState(now?.history ?? 2);
  const names = namesOf(typed), known = names.includes(reference) ? reference : "";
  const submit = async (e: React.FormEvent): Promise<void> => {
    e.preventDefault();
    if (await setUp({ markers: names, reference: known || null, confirm_reference: confirm, take_proposals: take, history })) done();
  };
  return (
    <form className={styles.form} aria-label="Start-up information" onSubmit={(e) => void submit(e)}>
      <h2>Start-up information</h2>
      <label className={styles.line}>Markers, in the order in which they are asked for, or how many
        <input className="field" value={typed} onChange={(e) => setTyped(e.target.value)} placeholder="ACR1 ACR2 ARM3 ELB4 … or 8" />
      </label>
      <label className={styles.line}>Reference marker, which does not move
        <select className="field" value={known} onChange={(e) => setReference(e.target.value)}><option value="">none</option>{names.map((name, i) => <option key={`${name} ${i}`}>{name}</option>)}</select>
      </label>
      <label><input type="checkbox" checked={confirm} disabled={!known} onChange={(e) => setConfirm(e.target.checked)} />ask in every frame whether it is the reference marker</label>
      <label><input type="checkbox" checked={take} onChange={(e) => setTake(e.target.checked)} />take what the other cameras say without asking</label>
      <label>remember a hidden marker for <input className={`field ${styles.short}`} type="number" min={2} max={100} value={history} onChange={(e) => setHistory(e.target.valueAsNumber || 2)} /> frames</label>
      <div><button type="submit" className="button strong" disabled={!names.length}>Begin to digitise</button></div>
    </form>
  );
}
