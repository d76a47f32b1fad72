import { Aperture, CircleAlert, CircleCheck, CircleDashed, CircleDot, FileUp, FolderPlus, Footprints, PenLine, Play, RotateCw, Square } from "lucide-react";
import { Fragment, useEffect, useRef, useState } from "react";
import * as api from "../api/client";
import { gaitPage, makeGait } from "../api/sessions";
import type { SessionCard, TrialCard } from "../api/types";
import { count, when } from "../model/format";
import { goTo, say, tried } from "../state/load";
import { Asked } from "../parts/Shown";
import { cameraAddress } from "../state/sessions";
import { set, useStore } from "../state/store";
import styles from "./Home.module.css";

const STATES: Record<TrialCard["state"], { icon: typeof Play; tone: string }> = {
  "not run": { icon: CircleDashed, tone: "" }, tracked: { icon: CircleDot, tone: "info" }, filled: { icon: CircleDot, tone: "info" }, done: { icon: CircleCheck, tone: "good" },
  signed: { icon: PenLine, tone: "good" }, failed: { icon: CircleAlert, tone: "bad" }, stale: { icon: RotateCw, tone: "warn" },
};

async function dropped(files: FileList): Promise<void> {
  for (const file of files) {
    const got = await tried(() => api.drop(file));
    if (!got) continue;
    const home = await tried(api.home);
    if (home) set({ home });
    const tell = (): void => say("done", [`${file.name} is there`, ...got.words].join(". "));
    tell();
    if (files.length > 1) continue;
    addEventListener("hashchange", tell, { once: true }); // what was said before is not said of what comes
    goTo("tracks", got.id);
  }
}

export function Home(): React.JSX.Element {
  const home = useStore((s) => s.home), [over, setOver] = useState(false);
  const onDrop = (e: React.DragEvent): void => (e.preventDefault(), setOver(false), void dropped(e.dataTransfer.files));
  return (
    <div className={styles.screen} onDragOver={(e) => (e.preventDefault(), setOver(true))} onDragLeave={() => setOver(false)} onDrop={onDrop} tabIndex={0} role="region" aria-label="Sessions and files">
      <div className={styles.page}>
        <div className={styles.top}><h1>Sessions</h1><button type="button" className="button" onClick={() => goTo("new")}><FolderPlus size={14} aria-hidden />New session …</button>{home && <span className="soft">Kinemark {home.version}{home.by && ` · ${home.by}`}</span>}</div>
        {!home && <div className={styles.none}><Asked words="The folders are looked through …" /></div>}
        {home?.sessions.map((session) => (
          <section key={session.id} className={styles.card} aria-label={session.title}>
            <header><h2>{session.title}</h2><span className="soft">{session.folder}</span><button type="button" className="button" aria-label={`Cameras of ${session.title}`} onClick={() => (location.hash = cameraAddress(session.id))}><Aperture size={14} aria-hidden />Cameras</button><Gait of={session} /><RunAll trials={session.trials} /></header>
            {session.words ? <p className={styles.wrong}>{session.words}</p> : <Trials trials={session.trials} />}
          </section>
        ))}
        {home && home.files.length > 0 && <section className={styles.card} aria-label="Files"><header><h2>Files</h2><span className="soft">trajectories of any system, looked at and mended the same way</span></header><Trials trials={home.files} file /></section>}
        {home && !home.sessions.length && !home.files.length && <p className={styles.none}>There is no session here yet. <b>New session …</b> makes one from recordings; or drop a file below.</p>}
        <label className={`${styles.drop} ${over ? styles.over : ""}`}>
          <FileUp size={22} aria-hidden /><span><b>Drop a file to look at it</b>: C3D, TDF or TRC of any system, TSV of Qualisys. Its swaps, spikes and gaps are listed; the file itself is never changed.</span>
          <input type="file" className="hidden-words" accept=".c3d,.tdf,.trc,.tsv" onChange={(e) => e.target.files && void dropped(e.target.files)} />
        </label>
      </div>
    </div>
  );
}

/** The gait report of a session: shown where it is there, else made. */
function Gait({ of }: { of: SessionCard }): React.JSX.Element | null {
  const busy = useStore((s) => s.busy > 0);
  const make = async (): Promise<void> => {
    const made = await tried(() => makeGait(of.id)), home = made && (await tried(api.home));
    if (home) set({ home }), say("done", `The gait report is there. ${made.words}`);
  };
  if (of.gait === "there") return <a className="button" href={gaitPage(of.id)} target="_blank" rel="noreferrer" aria-label={`Gait report of ${of.title}`}><Footprints size={14} aria-hidden />Gait report</a>;
  return of.gait === "possible" ? <button type="button" className="button" disabled={busy} onClick={() => void make()}><Footprints size={14} aria-hidden />Make gait report</button> : null;
}

/** What a run says of its trial, as its report does. */
const GRADES: Record<string, string> = { green: "good to use", amber: "usable with care", red: "not usable as it is", unknown: "not known" };

function RunAll({ trials }: { trials: readonly TrialCard[] }): React.JSX.Element | null {
  const todo = trials.filter((t) => t.state === "not run" || t.state === "stale" || t.state === "failed");
  if (!todo.length) return null;
  const run = async (): Promise<void> => {
    for (const t of todo) await tried(() => api.run(t.id));
  };
  return <button type="button" className="button" onClick={() => void run()}><Play size={13} aria-hidden />Run {todo.length === 1 ? todo[0]!.name : `all ${todo.length} that need it`}</button>;
}

function Trials({ trials, file }: { trials: readonly TrialCard[]; file?: boolean }): React.JSX.Element {
  return (
    <div className={styles.scroll}><table className={styles.table}>
      <thead><tr><th scope="col">{file ? "File" : "Trial"}</th><th scope="col" className={styles.figure}>Frames</th><th scope="col" className={styles.figure} title={file ? "With a name, of all points in the file. Those that are computed, and no markers, are put aside when it is opened." : "With a name, of all trajectories"}>{file ? "Points" : "Markers"}</th><th scope="col">State</th><th scope="col">Verdict</th><th scope="col" className={styles.figure} title="Problems that are worth a look, as Tracks lists them; – until they were looked for there">To look at</th><th scope="col" className={styles.figure}>Edits</th><th scope="col">Last</th><th scope="col"><span className="hidden-words">Run</span></th></tr></thead>
      <tbody>{trials.map((t) => <Trial key={t.id} trial={t} file={file} />)}</tbody>
    </table></div>
  );
}

function Trial({ trial: t, file }: { trial: TrialCard; file?: boolean }): React.JSX.Element {
  const job = useStore((s) => s.jobs[t.id]), running = job?.state === "running", { icon: Icon, tone } = STATES[t.state];
  const name = useRef<HTMLButtonElement>(null), marked = useStore((s) => s.marked === t.id);
  useEffect(() => void (marked && name.current!.focus()), [marked]);
  return (
    <tr>
      <th scope="row"><button type="button" ref={name} className={styles.name} onFocus={() => set({ marked: t.id })} onClick={() => goTo("tracks", t.id)}>{t.name.split(/(?=\.)|(?<=_)/).map((part, i) => <Fragment key={i}>{i > 0 && <wbr />}{part}</Fragment>)}</button>{t.state === "failed" && t.words && <small className={styles.why}>{t.words}</small>}</th>
      <td className={styles.figure}>{count(t.frames)}</td>
      <td className={styles.figure}>{t.markers == null ? "–" : `${t.named ?? 0}/${t.markers}`}</td>
      <td>{running ? <Progress share={job.progress ?? 0} words={`${job.stage} ${job.seconds_left != null ? `${Math.ceil(job.seconds_left)} s left` : ""}`} /> : <span className={`pill ${tone}`} title={t.words || undefined}><Icon size={12} aria-hidden />{file && t.state === "failed" ? "not readable" : t.state}</span>}</td>
      <td><Verdict of={t} /></td>
      <td className={styles.figure}>{t.problems == null ? "–" : t.problems > 0 ? <b>{t.problems}</b> : t.problems}</td>
      <td className={styles.figure}>{t.edits || <span className="soft">0</span>}</td>
      <td className="soft">{t.last ? `${t.last.by} ${when(t.last.at)}` : ""}</td>
      <td className={styles.run}>{!file && (running
        ? <button type="button" className="icon-button" aria-label={`Cancel the run of ${t.name}`} title="Cancel" onClick={() => void tried(() => api.cancel(t.id))}><Square size={13} aria-hidden /></button>
        : <button type="button" className="icon-button" aria-label={`Run ${t.name}`} title="Run" onClick={() => void tried(() => api.run(t.id))}><Play size={14} aria-hidden /></button>)}</td>
    </tr>
  );
}

/** What the run that was finished last says; where a later one failed or is wanted, that it is of before. */
function Verdict({ of: t }: { of: TrialCard }): React.JSX.Element {
  const words = t.verdict ? (GRADES[t.verdict] ?? t.verdict) : "–";
  return t.verdict && (t.state === "failed" || t.state === "stale") ? <span className="soft">before: {words}</span> : <span className={t.verdict ? "" : "soft"}>{words}</span>;
}

const Progress = ({ share, words }: { share: number; words: string }): React.JSX.Element => (
  <span className={styles.progress}><progress max={1} value={share} aria-label="Progress of the run" /><small className="number">{Math.round(100 * share)} % {words}</small></span>
);
