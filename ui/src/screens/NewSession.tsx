/** A session from recordings: folders that hold some, what they propose, and what the person says instead. */
import { FolderPlus, Play } from "lucide-react";
import type { Proposed, Role } from "../api/sessions";
import { many } from "../model/format";
import { Asked } from "../parts/Shown";
import { makeSession, propose, useSessions } from "../state/sessions";
import { set, useStore } from "../state/store";
import styles from "./NewSession.module.css";

export function NewSession(): React.JSX.Element {
  const { folder, proposed } = useSessions();
  return (
    <div className={styles.screen} tabIndex={0} role="region" aria-label="New session">
      <div className={styles.page}>{!folder ? <Folders /> : proposed ? <Form of={proposed} /> : <><h1>New session</h1><Asked words="The recordings are looked at …" /></>}</div>
    </div>
  );
}

function Folders(): React.JSX.Element {
  const folders = useSessions((s) => s.folders), marked = useStore((s) => s.marked);
  return (
    <>
      <h1>New session</h1>
      <p className="soft">Folders that hold recordings and no session yet. Choose the one of a day: all its trials, and what calibrates the cameras.</p>
      {!folders && <Asked words="The folders are looked through …" />}
      {folders?.length === 0 && <p className={styles.card}>There is none below the folders that the studio was started with. Copy recordings there: a video or a folder of images for each camera and trial, named after the cameras.</p>}
      <ul className={styles.folders}>
        {folders?.map((one) => (
          <li key={one.id}><button type="button" ref={(button) => void (button && one.id === marked && button.focus())} className={styles.folder} onFocus={() => set({ marked: one.id })} onClick={() => (location.hash = `#/new/${encodeURIComponent(one.id)}`)}><FolderPlus size={18} aria-hidden /><b>{one.title}</b><span className="soft">{one.folder}</span><span className="number">{one.words}</span></button></li>
        ))}
      </ul>
    </>
  );
}

const FIELDS = [["whole", "whole frames"], ["top", "two fields, the upper first"], ["bottom", "two fields, the lower first"]] as const;

function Form({ of }: { of: Proposed }): React.JSX.Element {
  const said = useSessions((s) => s.said);
  return (
    <form className={styles.form} onSubmit={(e) => (e.preventDefault(), void makeSession(false))}>
      <div className={styles.top}><h1>New session in {of.folder}</h1>
        <button type="button" className="button" onClick={() => (location.hash = "#/new")}>Another folder</button>
        <button type="submit" className="button" disabled={of.lacking !== ""}>Make it, then calibrate<kbd>⇧ Enter</kbd></button>
        <button type="button" className="button strong" disabled={of.lacking !== ""} onClick={() => void makeSession(true)}><Play size={14} aria-hidden />Make it and run</button>
      </div>
      {of.lacking && <p className={styles.lacking} role="status">{of.lacking}</p>}
      <section className={styles.card} aria-label="The session">
        <div className={styles.fields}>
          <label>Name<input className="field" defaultValue={of.name} maxLength={100} onBlur={(e) => void propose({ name: e.target.value || null })} /></label>
          <label>Date<input className="field" type="date" defaultValue={of.date} onChange={(e) => void propose({ date: e.target.value })} /></label>
          <label>Rate, Hz<input className="field" type="number" min={0} step="any" defaultValue={of.rate ?? ""} onBlur={(e) => void propose({ rate: Number(e.target.value) || null })} /><small className="soft">{of.rate_why}</small></label>
          <label>Images<select className="field" value={of.fields} onChange={(e) => void propose({ fields: e.target.value as Proposed["fields"] })}>{FIELDS.map(([key, words]) => <option key={key} value={key}>{words}</option>)}</select><small className="soft">{of.fields_why}</small></label>
          <p className={styles.cameras}><b>{many(of.cameras.length, "camera")}</b> {of.cameras.join(", ")}<small className="soft">{of.cameras_why}</small></p>
        </div>
      </section>
      {of.questions.length > 0 && (
        <section className={styles.card} aria-label="What no file tells">
          <h2>What no file tells</h2>
          {of.questions.map((one) => (
            <label key={one.key} className={styles.question}>{one.words}{one.optional && <span className="soft"> (may be left out)</span>}
              {one.choices.length
                ? <select className="field" value={one.answer} onChange={(e) => void propose({ answers: { ...said.answers, [one.key]: e.target.value } })}><option value="">…</option>{one.choices.map((c) => <option key={c}>{c}</option>)}</select>
                : <input className="field" defaultValue={one.answer} inputMode="decimal" onBlur={(e) => void propose({ answers: { ...said.answers, [one.key]: e.target.value } })} />}
              {one.wrong && <span className={styles.wrong}>{one.wrong}</span>}
            </label>
          ))}
        </section>
      )}
      <Recordings of={of} />
      {of.notes.length > 0 && <ul className={styles.notes}>{of.notes.map((note) => <li key={note}>{note}</li>)}</ul>}
      <details className={styles.card}><summary>The file that is written: session.toml</summary><pre tabIndex={0} role="region" aria-label="session.toml" className={styles.text}>{of.text}</pre></details>
    </form>
  );
}

function Recordings({ of }: { of: Proposed }): React.JSX.Element {
  const said = useSessions((s) => s.said);
  return (
    <section className={styles.card} aria-label="Recordings">
      <h2>What each recording is</h2>
      <div className={styles.scroll} tabIndex={0} role="region" aria-label="Table of recordings">
      <table className={styles.table}>
        <thead><tr><th scope="col">Recording</th><th scope="col">Is</th><th scope="col">Name</th><th scope="col">Frames</th><th scope="col">Hz</th><th scope="col">Why</th></tr></thead>
        <tbody>{of.recordings.map((one) => (
          <tr key={one.id} data-role={one.role}>
            <th scope="row">{one.file}{of.way === one.id && <span className="pill info">calibrates</span>}{one.unequal && <span className="pill warn">unequal lengths</span>}</th>
            <td><select className="field" aria-label={`What ${one.file} is`} value={one.role} onChange={(e) => void propose({ roles: { ...said.roles, [one.id]: e.target.value as Role } })}>{of.roles.map((r) => <option key={r.key} value={r.key}>{r.words}</option>)}</select></td>
            <td>{(one.role === "trial" || one.role === "static") && <input className="field" aria-label={`Name of ${one.file}`} defaultValue={one.name} maxLength={100} onBlur={(e) => e.target.value !== one.name && void propose({ names: { ...said.names, [one.id]: e.target.value } })} />}</td>
            <td className="number">{one.frames ?? "–"}</td><td className="number">{one.rate?.toFixed(1).replace(/\.0$/, "") ?? "–"}</td><td className="soft">{one.why}</td>
          </tr>
        ))}</tbody>
      </table>
      </div>
    </section>
  );
}
