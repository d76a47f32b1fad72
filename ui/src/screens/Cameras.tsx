/** The cameras of a session: how they are calibrated, how good that is, what is lost with a camera, and control balls. */
import { Crosshair, Gauge, Loader2, ScanSearch } from "lucide-react";
import { useEffect, useRef, useState } from "react";
import * as api from "../api/sessions";
import type { CalibrationShown, SessionCameras } from "../api/sessions";
import { Flat } from "../draw/Flat";
import { rigDrawn, span } from "../draw/rig";
import { mm } from "../model/format";
import { ChangeWay } from "../parts/ChangeWay";
import { Asked } from "../parts/Shown";
import { FoundTarget } from "../parts/FoundTarget";
import { ControlView } from "../parts/ControlView";
import { Findings, WordTable } from "../parts/Tables";
import { say, tried } from "../state/load";
import { calibrate, put, useSessions } from "../state/sessions";
import { useStore } from "../state/store";
import styles from "./Cameras.module.css";

export function Cameras(): React.JSX.Element {
  const { cameras, control, pointing } = useSessions(), open = pointing === true, [changing, setChanging] = useState(false), [looking, setLooking] = useState(false);
  if (!cameras) return <div className={styles.waiting}><h1>Cameras & calibration</h1><Asked words="The calibration is read …" /></div>;
  return (
    <div className={styles.screen}>
      <header className={styles.head}>
        <h1>Cameras & calibration</h1><span className="soft">{cameras.title} · by {cameras.way_words}</span>
        {control && <button type="button" className="button" aria-pressed={open} onClick={() => put({ pointing: !open })}><Crosshair size={14} aria-hidden />Point at the balls</button>}
        {cameras.calibration && <a className="button" href={api.calibrationPage(cameras.id)} target="_blank" rel="noreferrer">Whole page, to print</a>}
        <button type="button" className="button" aria-pressed={looking} onClick={() => setLooking(!looking)}><ScanSearch size={14} aria-hidden />As found</button>
        <button type="button" className="button" aria-expanded={changing} onClick={() => setChanging(!changing)}>Another way …</button>
        <Run id={cameras.id} />
      </header>
      {changing && <ChangeWay id={cameras.id} done={() => setChanging(false)} />}
      {looking ? <FoundTarget id={cameras.id} cameras={cameras.names} /> : open && control ? <ControlView /> : <Judged of={cameras} />}
    </div>
  );
}

function Run({ id }: { id: string }): React.JSX.Element {
  const job = useStore((s) => s.jobs[id]);
  if (job?.state === "running") return <span className={styles.run} role="status"><Loader2 size={14} className={styles.spin} aria-hidden />{job.stage || "calibrating"} <progress max={1} value={job.progress ?? undefined} aria-label="Progress of the calibration" /></span>;
  return <button type="button" className="button strong" onClick={() => void calibrate()}><Gauge size={14} aria-hidden />Calibrate now<kbd>⇧ Enter</kbd></button>;
}

function Judged({ of }: { of: SessionCameras }): React.JSX.Element {
  const job = useStore((s) => s.jobs[of.id]), shown = of.calibration;
  return (
    <div className={styles.body}>
      <section className={styles.left} aria-label="In space">{shown ? <Space of={shown} /> : <p className={styles.none}>The cameras are not calibrated yet.</p>}</section>
      <section className={styles.right} aria-label="How good it is" tabIndex={0}>
        {job?.state === "failed" && <p className={styles.failed} role="alert">{job.words}</p>}
        {shown && <Verdict of={shown} />}
        <Numbers of={of} />
        {shown?.tables.map((table) => <WordTable key={table.title} of={table} />)}
        {of.earlier.length > 0 && <h2>Former calibrations, against the one that counts now</h2>}
        {of.earlier.map((one) => <WordTable key={one.made} of={one.table} />)}
      </section>
    </div>
  );
}

const GRADES = { green: ["good", "good"], amber: ["warn", "usable with care"], unknown: ["warn", "not known"], red: ["bad", "not to be used"] } as const;

function Verdict({ of }: { of: CalibrationShown }): React.JSX.Element {
  const [tone, words] = GRADES[of.grade];
  return (
    <div className={styles.card} data-grade={of.grade}>
      <p className={styles.made}><span className={`pill ${tone}`}>{words}</span><span className="soft">made {of.made}{of.current ? "" : " · something it depends on changed since: calibrate again"}</span></p>
      <h2>{of.headline}</h2>
      <dl className={styles.tiles}>{of.tiles.map((tile) => <div key={tile.name}><dt>{tile.name}</dt><dd className="number">{tile.value}</dd><dd className={styles.more}>{tile.more}</dd></div>)}</dl>
      {of.sentences.map((one) => <p key={one} className="soft">{one}</p>)}
      {of.findings.length > 0 && <Findings of={of.findings} />}
    </div>
  );
}

/** The rig, its volume, and the error in it: of all cameras, or without one of them. */
function Space({ of }: { of: CalibrationShown }): React.JSX.Element {
  const canvas = useRef<HTMLCanvasElement>(null), [flat, setFlat] = useState<Flat | null>(null), lost = useSessions((s) => s.lost), theme = useStore((s) => s.theme);
  const [least, most] = span(of, lost);
  useEffect(() => {
    const made = new Flat(canvas.current!), { low, high, up } = rigDrawn(of, null);
    made.frame(low, high, up);
    setFlat(made);
    return () => made.dispose();
  }, [of]);
  useEffect(() => {
    const { lines, dots } = rigDrawn(of, lost);
    flat?.show(lines, dots);
  }, [flat, of, lost, theme]);
  return (
    <>
      <div className={styles.space}><canvas ref={canvas} role="img" aria-label={`Cameras and volume in space; standard deviation per axis ${mm(least)} to ${mm(most)} mm${lost ? ` without ${lost}` : ""}`} /></div>
      <div className={styles.scale}><span className="number">{mm(least)} mm</span><i aria-hidden /><span className="number">{mm(most)} mm</span><span className="soft">σ per axis{lost ? ` without ${lost}, in the middle level` : ""} · drag to turn</span></div>
      <ul className={styles.cameras} aria-label="Cameras">
        {of.cameras.map((c) => (
          <li key={c.name}><b>{c.name}</b><span className="number" data-residual={c.name}>{of.residual_px[c.name]?.toFixed(3) ?? "–"} px</span>
            <button type="button" className="button" aria-pressed={lost === c.name} onClick={() => put({ lost: lost === c.name ? null : c.name })}>What if it is lost</button></li>
        ))}
      </ul>
    </>
  );
}

/** What people measured, to be stated anew. */
function Numbers({ of }: { of: SessionCameras }): React.JSX.Element | null {
  if (!of.numbers.length) return null;
  const state = async (key: string, text: string): Promise<void> => {
    const values = text.trim() ? text.trim().split(/[\s,;]+/).map(Number) : [];
    if (values.some((v) => !(v > 0))) return say("refused", "Numbers above 0 are wanted, in mm.");
    const got = await tried(() => api.numbers(of.id, { [key]: values }));
    if (got) put({ cameras: got }), say("done", "Stated. Calibrate again.");
  };
  return (
    <div className={styles.card}>
      <h2>What was measured</h2>
      {of.numbers.map((one) => (
        <label key={one.key} className={styles.stated}>{one.words}<input key={one.values.join(" ")} className="field" inputMode="decimal" defaultValue={one.values.join(", ")} onKeyDown={(e) => e.key === "Enter" && e.currentTarget.blur()} onBlur={(e) => e.target.value !== one.values.join(", ") && void state(one.key, e.target.value)} /></label>
      ))}
    </div>
  );
}
