import { ArrowLeftRight, CircleCheck, CopyX, FastForward, Ghost, Link2, Move3d, Repeat, Spline, Tag, Unlink, Users, Vibrate, Zap } from "lucide-react";
import { useEffect, useRef } from "react";
import type { Alternative, Problem } from "../api/types";
import { frames, many, mm, percent, tenths } from "../model/format";
import { withoutSubject } from "../model/names";
import { about, asItIs, changes, keepOf, unlikely, worthALook } from "../model/problems";
import { choose, lookAt } from "../state/acts";
import { drawInstead } from "../state/instead";
import { set, useParts, useStore } from "../state/store";
import styles from "./ProblemList.module.css";

const KINDS: Record<Problem["kind"], { word: string; icon: typeof Tag }> = {
  swap: { word: "Exchange?", icon: ArrowLeftRight }, join: { word: "One marker?", icon: Link2 }, gap: { word: "Gap", icon: Spline }, ghost: { word: "Ghost?", icon: Ghost },
  spike: { word: "Spike?", icon: Zap }, filled: { word: "Measured?", icon: CopyX }, label: { word: "Name?", icon: Tag }, sides: { word: "Left and right?", icon: Users }, edit: { word: "Edit lost its place", icon: Unlink },
  lost: { word: "Frames lost?", icon: FastForward }, repeated: { word: "Frames repeated?", icon: Repeat }, moved: { word: "World moved?", icon: Move3d }, shaken: { word: "World off?", icon: Vibrate },
};

export function ProblemList(): React.JSX.Element {
  const { problems, problem, later, unlikely: more } = useParts("problems", "problem", "later", "unlikely"), list = useRef<HTMLDivElement>(null);
  const first = worthALook(problems, later), rest = unlikely(problems, later), shown = more ? [...first, ...rest] : first, worth = first.length;
  useEffect(() => void list.current?.querySelector('[aria-current="true"]')?.scrollIntoView({ block: "nearest" }), [problem]);
  return (
    <section className={styles.section} aria-label="Problems">
      <header className={styles.head}><h2>Problems</h2><span className="soft number">{problems && `${worth} worth a look`}</span></header>
      <div ref={list} className={styles.list} tabIndex={0} role="region" aria-label="List of problems">
        {!problems && <p className={styles.none} role="status">Problems are being looked for …</p>}
        {problems && !worth && <p className={styles.none}><CircleCheck size={26} aria-hidden />{rest.length ? "Nothing is left that is worth a look." : "Nothing is left to look at."}</p>}
        <ol>
          {shown.map((p, i) => (
            <li key={p.id} data-problem={p.kind} data-id={p.id}>
              {p.id === problem ? <Open problem={p} number={i + 1} /> : <Row problem={p} number={i + 1} later={later.includes(p.id)} />}
            </li>
          ))}
        </ol>
        {rest.length > 0 && (
          <button type="button" className={styles.stop} aria-expanded={more} onClick={() => set({ unlikely: !more })}>
            {more ? "Hide" : "Show"} {many(rest.length, "more", "more")} below 5 %, with {errors(problems?.errors_left)} in all <kbd>⇧ U</kbd>
          </button>
        )}
      </div>
      {problems && <p className={styles.rule}>Errors expected: <b className="number">{tenths(problems.errors)}</b>{worth ? <>, and <b className="number">{tenths(problems.errors_left)}</b> when {worth === 1 ? "it is" : "these are"} settled</> : ". Looking on is not worth it."}</p>}
    </section>
  );
}

const errors = (n: number | null | undefined): string => (n == null ? "few errors" : `${n.toFixed(1)} errors`);

/** How probable, and how much is at stake. */
function Weight({ problem: p }: { problem: Problem }): React.JSX.Element {
  return <span className={`${styles.weight} number`}>{p.wrong !== null && <b>{percent(p.wrong)}</b>}{p.cost_mm !== null && <span>{mm(p.cost_mm)} mm</span>}</span>;
}

function Row({ problem: p, number, later }: { problem: Problem; number: number; later: boolean }): React.JSX.Element {
  const { word, icon: Icon } = KINDS[p.kind], header = useStore((s) => s.header);
  return (
    <button type="button" className={`${styles.row} ${later ? styles.later : ""}`} onClick={() => lookAt(p)}>
      <span className={`${styles.number} number`}>{number}</span><Icon size={15} aria-hidden />
      <span className={styles.words}><b>{word}</b> {about(p, (name) => withoutSubject(header, name))}<small>{frames(p.first, p.last)}{later && " · put off"}</small></span>
      <Weight problem={p} />
    </button>
  );
}

/** How probable a way is, what comes of it, and how far off each sample at stake is to be expected then. */
function Consequence({ of: a, stake }: { of: Alternative; stake: number }): React.JSX.Element | null {
  const parts = [a.probability == null ? "" : `${percent(a.probability)} right`, a.consequence ?? "", a.cost == null || !stake || a.cost / stake < 0.005 ? "" : `${mm(a.cost / stake)} mm off expected`].filter(Boolean);
  return parts.length ? <small className="number">{parts.join(" · ")}</small> : null;
}

/** The problem that is looked at: what may be wrong, and the ways to go, each with its key and what it costs. */
function Open({ problem: p, number }: { problem: Problem; number: number }): React.JSX.Element {
  const { word, icon: Icon } = KINDS[p.kind], keep = keepOf(p), shown = useStore((s) => s.instead), first = p.alternatives.find(changes)?.key;
  const drawn = shown?.problem === p.id ? shown.key : first;
  return (
    <div className={styles.open} aria-current="true">
      <div className={styles.title}><span className={`${styles.number} number`}>{number}</span><Icon size={15} aria-hidden /><b>{word}</b><span className="soft number">{frames(p.first, p.last)}</span>{p.wrong !== null && <span className={`${styles.weight} number`}><b>{percent(p.wrong)}</b></span>}</div>
      <p data-words>{p.words}</p>
      <p className="soft number">{many(p.at_stake, "sample")} at stake{p.cost_mm !== null && `, ${mm(p.cost_mm)} mm off each ${p.kind === "gap" ? "where filled" : "if it is wrong"}`}</p>
      <ul className={styles.ways}>
        {p.alternatives.map((a, i) => (
          <li key={a.key}>
            <button type="button" className={styles.way} data-key={a.key} data-first={i === 0 ? "yes" : ""} onPointerEnter={() => void drawInstead(p, a.key)} onFocus={() => void drawInstead(p, a.key)} onClick={() => void choose(p, a.key)}>
              <kbd>{i === 0 ? "Enter" : i + 1}</kbd>
              <span><b>{a.words}</b><Consequence of={a} stake={p.at_stake} /></span>
              {(asItIs(a) || a.key === drawn) && <i className={asItIs(a) ? styles.a : styles.b} aria-hidden>{asItIs(a) ? "A" : "B"}</i>}
            </button>
          </li>
        ))}
      </ul>
      <p className={styles.more}>{keep && <><kbd>Y</kbd> {keep.action === "keep" ? "right as it is" : keep.words} </>}<kbd>–</kbd> later <kbd>Space</kbd> play</p>
    </div>
  );
}
