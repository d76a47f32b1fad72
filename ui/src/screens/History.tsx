/** What was said of the trial: who, when, why, and what became of it; the difference of two versions; signatures. */
import { FileDown, GitCompare, PenLine, Undo2 } from "lucide-react";
import { useState } from "react";
import * as api from "../api/client";
import type { Difference, HistoryRow } from "../api/types";
import { write } from "../parts/Finish";
import { Waiting } from "../parts/Waiting";
import { count, frames, many, mm, when, wayOf } from "../model/format";
import { act } from "../state/acts";
import { tried } from "../state/load";
import { set, useStore } from "../state/store";
import styles from "./History.module.css";

const TONE: Record<string, string> = { held: "good", thin: "warn", moot: "", overruled: "", orphan: "bad" };

export function History(): React.JSX.Element {
  const { header, history } = useStore(), [typed, setTyped] = useState(""), [shown, setShown] = useState<Difference | null>(null), id = useStore((s) => s.id);
  if (!header) return <Waiting />;
  const all = history?.entries ?? [], rows = [...all].reverse().filter((e) => `${e.words} ${e.by} ${e.why} ${e.kinds.join(" ")}`.toLowerCase().includes(typed.toLowerCase()));
  const compare = async (of: number, to: number): Promise<void> => setShown(await tried(() => api.difference(id!, of, to)));
  return (
    <div className={styles.screen}>
      <section className={styles.list} aria-label="Entries">
        <header className={styles.head}>
          <h1>History</h1>
          <input className="field" type="search" aria-label="Filter by who, marker or words" placeholder="Filter: who, marker, words" value={typed} onChange={(e) => setTyped(e.target.value)} />
          <button type="button" className="button" onClick={() => set({ dialog: "sign" })}><PenLine size={14} aria-hidden />Sign</button>
          <button type="button" className="button" onClick={() => void write()}><FileDown size={14} aria-hidden />Write C3D</button>
        </header>
        <Outcomes entries={all} />
        {history?.faults.map((f) => <p key={f.line} className={styles.fault}>Line {f.line} of the journal: {f.words}</p>)}
        <div className={styles.rows} tabIndex={0} role="region" aria-label="Entries of the journal">
          {history && !all.length && <p className={styles.none}>Nothing has been said of this trial yet.</p>}
          <ol>{rows.map((e) => <Row key={e.id} entry={e} compare={compare} last={all.at(-1)?.id ?? 0} />)}</ol>
        </div>
      </section>
      <Diff shown={shown} all={all} compare={compare} />
    </div>
  );
}

function Outcomes({ entries }: { entries: readonly HistoryRow[] }): React.JSX.Element {
  const live = entries.filter((e) => !e.undone && e.outcome), counts = new Map<string, number>();
  for (const e of live) counts.set(e.outcome!, (counts.get(e.outcome!) ?? 0) + 1);
  return <p className={styles.outcomes}>{[...counts].map(([word, n]) => <span key={word} className={`pill ${TONE[word]}`}>{word} {n}</span>)}{!counts.size && <span className="soft">no edit counts now</span>}</p>;
}

function Row({ entry: e, compare, last }: { entry: HistoryRow; compare: (of: number, to: number) => Promise<void>; last: number }): React.JSX.Element {
  const reasons = e.outcomes.filter((o) => o.reason).map((o) => o.reason);
  return (
    <li className={`${styles.row} ${e.undone ? styles.undone : ""}`} data-entry={e.id}>
      <span className={`${styles.number} number`}>{e.id}</span>
      <div className={styles.what}>
        <p><b>{e.short}</b>{e.undone && <span className="soft"> – undone</span>}{e.signed && <span className="pill good"><PenLine size={11} aria-hidden />signed</span>}</p>
        {e.short !== e.words && <details><summary className="soft">All of it</summary><ul>{e.words.split("; ").map((one, i) => <li key={i}>{one}</li>)}</ul></details>}
        <p className="soft">{e.by} · {when(e.at)} · {e.version}{e.why && <> · “{e.why}”</>}</p>
        {reasons.map((r) => <p key={r} className={styles.reason}>{r}</p>)}
      </div>
      {e.outcome && !e.undone && <span className={`pill ${TONE[e.outcome]}`}>{e.outcome}</span>}
      <button type="button" className="icon-button" aria-label={`Difference that entry ${e.id} made`} title="What it changed" onClick={() => void compare(e.id - 1, e.id)}><GitCompare size={15} aria-hidden /></button>
      {!e.undone && !e.signed && !e.kinds.includes("undo") && <button type="button" className="icon-button" aria-label={`Undo entry ${e.id}`} title="Undo this one" onClick={() => void act({ kind: "undo", of: e.id }, `Entry ${e.id} undone`).then(() => void compare(0, last + 1))}><Undo2 size={15} aria-hidden /></button>}
    </li>
  );
}

/** How a gap is filled, in words. */
const filledBy = (method: string | null): string => (method === null ? "not said" : method === "open" ? "left open" : wayOf(method));

function Diff({ shown, all, compare }: { shown: Difference | null; all: readonly HistoryRow[]; compare: (of: number, to: number) => Promise<void> }): React.JSX.Element {
  const last = all.at(-1)?.id ?? 0, [of, setOf] = useState(0), [to, setTo] = useState<number | null>(null), versions = [0, ...all.map((e) => e.id)];
  const pick = (value: number, change: (n: number) => void, label: string): React.JSX.Element => (
    <select className="field" aria-label={label} value={value} onChange={(e) => change(Number(e.target.value))}>{versions.map((v) => <option key={v} value={v}>{v ? `after ${v}` : "before all edits"}</option>)}</select>
  );
  return (
    <aside className={styles.diff} aria-label="Difference of two versions">
      <header className={styles.head}><h2>Difference</h2>{pick(of, setOf, "Older version")}<span className="soft">to</span>{pick(to ?? last, setTo, "Newer version")}<button type="button" className="button" disabled={of === (to ?? last)} onClick={() => void compare(of, to ?? last)}>Show</button></header>
      {!shown && <p className={styles.none}>Choose two versions, or an entry on the left: names that changed come first, then samples.</p>}
      {shown && (
        <div className={styles.tables} tabIndex={0} role="region" aria-label="What differs">
          <h3>{shown.of ? `After ${shown.of}` : "Before all edits"} → {shown.other ? `after ${shown.other}` : "before all edits"}: {many(shown.identities.length, "change")} of names, {many(new Set(shown.samples.map((d) => d.marker)).size, "marker")} with other samples{shown.fills.length > 0 && `, ${many(shown.fills.length, "gap")} filled otherwise`}</h3>
          {shown.identities.length > 0 && <table><thead><tr><th scope="col">Was</th><th scope="col">Is</th><th scope="col">Frames</th><th scope="col">Samples</th></tr></thead><tbody>
            {shown.identities.map((d, i) => <tr key={i}><td>{d.before}</td><td><b>{d.after}</b></td><td className="number">{frames(d.first, d.last)}</td><td className="number">{count(d.samples)}</td></tr>)}
          </tbody></table>}
          {shown.samples.length > 0 && <table><thead><tr><th scope="col">Marker</th><th scope="col">Samples</th><th scope="col">Frames</th><th scope="col">At most</th></tr></thead><tbody>
            {shown.samples.map((d, i) => <tr key={i}><td><b>{d.marker}</b></td><td className="number">{count(d.samples)} {d.what}</td><td className="number">{frames(d.first, d.last)}</td><td className="number">{d.max_mm === null ? "" : `${mm(d.max_mm)} mm`}</td></tr>)}
          </tbody></table>}
          {shown.fills.length > 0 && <table><thead><tr><th scope="col">Gap of</th><th scope="col">Frames</th><th scope="col">Was</th><th scope="col">Is</th></tr></thead><tbody>
            {shown.fills.map((d) => <tr key={`${d.marker} ${d.first}`}><td><b>{d.marker}</b></td><td className="number">{frames(d.first, d.last)}</td><td>{filledBy(d.before)}</td><td>{filledBy(d.after)}</td></tr>)}
          </tbody></table>}
          {!shown.identities.length && !shown.samples.length && !shown.fills.length && <p className="soft">Nothing differs.</p>}
        </div>
      )}
    </aside>
  );
}
