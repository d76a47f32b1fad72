/** The menu of UM²AS as the thesis has it: levels and tasks, how far each is, and the tasks that are done here. */
import { CircleAlert, CircleCheck, CircleDashed, CircleDot, CornerUpLeft, Play, RotateCw } from "lucide-react";
import { useEffect, useRef } from "react";
import type { MenuRow } from "../api/um2as";
import { Asked } from "../parts/Shown";
import { AspectBar } from "../parts/AspectBar";
import { FilePageView } from "../parts/FilePageView";
import { choose, enter, menuUp, pathTo, process, rowOf, rowsIn, shownFile, useMenu } from "../state/um2as";
import styles from "./Um2as.module.css";

const STATES: Record<MenuRow["state"], { icon: typeof Play; tone: string; words: string }> = {
  "": { icon: CircleDashed, tone: "", words: "" }, done: { icon: CircleCheck, tone: "good", words: "done" }, open: { icon: CircleDot, tone: "info", words: "to be done" },
  again: { icon: RotateCw, tone: "warn", words: "do it again" }, waits: { icon: CircleAlert, tone: "", words: "waits" },
};
const ELSEWHERE: Partial<Record<MenuRow["place"], string>> = { cameras: "Cameras & calibration", detect: "Detect", digitise: "Digitise & verify", angles: "Angles" };

export function Um2as(): React.JSX.Element {
  const { menu, level, task } = useMenu();
  if (!menu) return <div className={styles.waiting}><h1>UM²AS</h1><Asked words="The menu is read …" /></div>;
  const row = rowOf(task), here = row ?? rowOf(level);
  return (
    <div className={styles.screen} data-level={level} data-task={task}>
      <header className={styles.head}>
        <h1>{here ? here.title : "UM²AS"}</h1>
        <ol aria-label="Levels above" className={styles.path}>{["UM²AS", ...pathTo(level).map((one) => one.title)].slice(0, here && !row ? -1 : undefined).map((one) => <li key={one}>{one}</li>)}</ol>
        <Trial />
      </header>
      <div className={styles.body}>
        <Entries />
        <section className={styles.task} aria-label={here ? here.title : "The menu"} tabIndex={0}>
          {row ? <Task row={row} /> : <Overview level={level} />}
        </section>
      </div>
      <button type="button" className={styles.box} onClick={menuUp} title="One level up (Escape)"><CornerUpLeft size={14} aria-hidden />{task || level ? "One level up" : "Leave UM²AS"}<kbd>Esc</kbd></button>
    </div>
  );
}

/** Which trial the menu is of; it is chosen at the top. */
function Trial(): React.JSX.Element {
  const { menu, level, task, session } = useMenu(), top = !level && !task;
  const go = (name: string): void => void (location.hash = `#/session/${encodeURIComponent(session!)}/um2as/${encodeURIComponent(name)}`);
  return (
    <label className={styles.trial}><span className="soft">{menu!.title}</span>Trial
      <select className="field" value={menu!.trial} disabled={!top} onChange={(e) => go(e.target.value)}>{menu!.trials.map((one) => <option key={one.id}>{one.name}</option>)}</select>
    </label>
  );
}

const State = ({ of }: { of: MenuRow }): React.JSX.Element | null => {
  const { icon: Icon, tone, words } = STATES[of.state];
  return of.state ? <span className={`pill ${tone}`} data-state={of.state}><Icon size={12} aria-hidden />{words}</span> : null;
};

function Entries(): React.JSX.Element {
  const { level, task } = useMenu(), list = useRef<HTMLOListElement>(null), rows = rowsIn(level);
  useEffect(() => {
    const buttons = list.current?.querySelectorAll("button");
    if (!task) buttons?.[Math.max(0, rows.findIndex((row) => row.state !== "done" && row.state !== ""))]?.focus(); // the entry that is next is highlighted
  }, [level, task]); // eslint-disable-line react-hooks/exhaustive-deps
  return (
    <nav className={styles.entries} aria-label="Menu">
      <ol ref={list}>
        {rows.map((row) => (
          <li key={row.key}>
            <button type="button" data-entry={row.key} aria-current={row.key === task ? "step" : undefined} onClick={() => enter(row)}>
              <b>{row.title}</b><State of={row} />
              <span className="soft">{row.about}{row.place in ELSEWHERE ? ` On the screen ${ELSEWHERE[row.place]}.` : ""}</span>
              {row.words && <span className={styles.words}>{row.words}</span>}
            </button>
          </li>
        ))}
      </ol>
    </nav>
  );
}

/** What is below a level, and how far it is. */
function Overview({ level }: { level: string }): React.JSX.Element {
  const rows = rowsIn(level), below = rows.filter((row) => row.place === "menu");
  return (
    <>
      {below.map((row) => <div key={row.key} className={styles.card}><h2>{row.title} <State of={row} /></h2><ul>{rowsIn(row.key).map((one) => <li key={one.key}><State of={one} />{one.title}<span className="soft">{one.words}</span></li>)}</ul></div>)}
      {!below.length && <div className={styles.card}><h2>What comes next</h2><p>{next(rows)}</p><Files of={rows.flatMap((row) => (row.key.endsWith("-view") || row.key.endsWith("-display") ? [] : row.files))} /></div>}
      <p className="soft">Choose by the mouse, or by the arrow keys and Enter. A task may be done again as often as it is wanted. Escape, or the box at the lower right, goes one level up; UM²AS is left from its top.</p>
    </>
  );
}

function next(rows: readonly MenuRow[]): string {
  const row = rows.find((one) => one.state === "open" || one.state === "again") ?? rows.find((one) => one.state === "waits");
  return row ? `${row.title}. ${row.words}` : "All of it is done.";
}

function Files({ of }: { of: readonly string[] }): React.JSX.Element | null {
  const folder = useMenu((g) => g.menu!.folder), names = [...new Set(of)];
  return names.length ? <p className={styles.files}><span className="soft">Files, in {folder}:</span> {names.map((name) => <code key={name}>{name}</code>)}</p> : null;
}

const PROCESS: Record<string, string> = { "calibration-process": "Process L Parameters", "digitising-save": "Save Data", "xyz-process": "Process Coordinates", "euler-process": "Process" };

function Task({ row }: { row: MenuRow }): React.JSX.Element {
  const place = useRef<HTMLDivElement>(null), file = shownFile(), verb = PROCESS[row.key];
  useEffect(() => place.current?.focus(), [row.key]); // so that Enter and the space bar are the task's
  return (
    <div ref={place} tabIndex={-1} className={styles.card} role="group" aria-label={row.title}>
      <h2>{row.title} <State of={row} /></h2>
      <p className="soft">{row.about} (Thesis: {row.figure})</p>
      {row.words && <p role="status" data-words={row.key}>{row.words}</p>}
      <Choices task={row.key} />
      {verb && <p><button type="button" className="button strong" disabled={row.state === "waits"} onClick={() => void process()}><Play size={14} aria-hidden />{verb}<kbd>Enter</kbd></button></p>}
      <Files of={row.files} />
      {file && <FilePageView files={row.files} />}
    </div>
  );
}

/** What may be said in a task. */
function Choices({ task }: { task: string }): React.JSX.Element | null {
  const { menu, made, inverse, tdc } = useMenu();
  if (task === "calibration-start" || task === "calibration-process") return <label className={styles.line}>Date, for camera 1's file <input type="date" className="field" value={made} onChange={(e) => e.target.value && void choose({ made: e.target.value })} /></label>;
  if (task === "aspect") return <AspectBar />;
  if (task === "xyz-start" || task === "xyz-process") return <Cameras />;
  if (task === "euler-process") return <label className={styles.line}><input type="checkbox" checked={inverse} onChange={(e) => void choose({ inverse: e.target.checked })} /> By inverse cosines, without the sign of the first and third angle, as UM²AS has them</label>;
  if (task !== "euler-input" || !menu!.tdcs.length) return null;
  return <label className={styles.line}>Places <select className="field" value={tdc} onChange={(e) => void choose({ tdc: e.target.value })}>{menu!.tdcs.map((name) => <option key={name}>{name}</option>)}</select></label>;
}

/** All cameras, or any two of them or more. */
function Cameras(): React.JSX.Element {
  const { menu, chosen } = useMenu(), names = menu!.cameras, on = chosen.length ? chosen : names;
  const turn = (name: string): void => {
    const found = names.filter((one) => (one === name ? !on.includes(one) : on.includes(one)));
    if (found.length >= 2) void choose({ chosen: found.length === names.length ? [] : found });
  };
  return (
    <fieldset className={styles.cameras}><legend>How many cameras are being used? <b>{on.length}</b></legend>
      {names.map((name) => <label key={name}><input type="checkbox" checked={on.includes(name)} disabled={on.length === 2 && on.includes(name)} onChange={() => turn(name)} /> {name}</label>)}
    </fieldset>
  );
}
