/** What is selected: what is known of it, and what can be done with it by mouse. */
import { ArrowLeftRight, Crosshair, Eraser, PenLine, Scissors, Spline, TagIcon, TrendingDown, X } from "lucide-react";
import { byId, possible } from "../keys/commands";
import { shownKey } from "../keys/bind";
import { frames, many, percent } from "../model/format";
import { dropping } from "../state/acts";
import { playhead, set, useSeen } from "../state/store";
import styles from "./Inspector.module.css";
import { PutPanel } from "./PutPanel";

const TOOLS = [
  ["name", PenLine, "Name"], ["exchange", ArrowLeftRight, "Exchange"], ["cut", Scissors, "Cut here"], ["unname", TagIcon, "Unname"],
  ["drop", Eraser, "Not a marker"], ["fill", Spline, "Fill"], ["put", Crosshair, "Put"], ["smooth", TrendingDown, "Smooth"],
] as const;

export function Inspector(): React.JSX.Element {
  const state = useSeen(), { selected, header, first, last, clicks } = state;
  return (
    <section className={styles.section} aria-label="Selection">
      <header><h2>Selection</h2>{selected.length > 0 && <button type="button" className="icon-button" aria-label="Select nothing" onClick={() => set({ selected: [], first: null, last: null })}><X size={14} aria-hidden /></button>}</header>
      {!selected.length && <p className="soft">Click a marker in any view; with Ctrl a second one. By keys <kbd>.</kbd> selects one, <kbd>&gt;</kbd> a second. <kbd>[</kbd> and <kbd>]</kbd> mark a stretch.</p>}
      <ul className={styles.tracks}>
        {selected.slice(0, 3).map((name) => {
          const t = header?.tracks.find((one) => one.name === name);
          return <li key={name}><b>{name}</b>{t && <span className="soft number">{t.first !== null && t.last !== null ? frames(t.first, t.last) : "no samples"} · {many(t.samples, "sample")}{t.probability != null && ` · ${percent(t.probability)}`}</span>}</li>;
        })}
      </ul>
      {(first !== null || last !== null) && (
        <p className={styles.stretch}>Marked <b className="number">{first ?? "start"} – {last ?? "end"}</b><button type="button" className="icon-button" aria-label="Mark nothing" onClick={() => set({ first: null, last: null })}><X size={13} aria-hidden /></button></p>
      )}
      {selected.length > 0 && (
        <ul className={styles.tools}>
          {TOOLS.map(([id, Icon, words]) => {
            const command = byId(id), does = id === "drop" ? dropping(state)?.words : undefined, title = does && !does.includes("no marker") ? "Erase" : words;
            return <li key={id}><button type="button" className="button" title={does ?? command.title} aria-pressed={id === "put" ? clicks !== null : undefined} disabled={!possible(command, { ...state, screen: "tracks" })} onClick={command.run}><Icon size={14} aria-hidden />{title}<kbd>{shownKey(command.keys[0]!)}</kbd></button></li>;
          })}
          <li><button type="button" className="button" onClick={() => set({ first: playhead.frame })}>From here<kbd>[</kbd></button></li>
          <li><button type="button" className="button" onClick={() => set({ last: playhead.frame })}>To here<kbd>]</kbd></button></li>
        </ul>
      )}
      {clicks && <PutPanel key={selected[0]} />}
    </section>
  );
}
