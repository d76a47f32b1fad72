/** Gaps, each with the error that is expected of every way to fill it. */
import { ArrowDown, ArrowUp, Crosshair, SkipForward, Spline } from "lucide-react";
import { useEffect, useMemo, useRef } from "react";
import { VList, type VListHandle } from "virtua";
import type { GapRow } from "../api/types";
import { CamerasView, CurvesView, SceneView } from "../parts/views";
import { Name } from "../parts/Name";
import { PutPanel } from "../parts/PutPanel";
import { Waiting } from "../parts/Waiting";
import { frames, many, mm, wayOf } from "../model/format";
import { nextOrder, sameGap, type GapColumn } from "../model/gaps";
import { acceptable, fillAll, fillGap, lookAtGap, tabled, undecided } from "../state/acts";
import { set, useStore } from "../state/store";
import styles from "./Gaps.module.css";

export function Gaps(): React.JSX.Element {
  const { header, gaps } = useStore();
  if (!header) return <Waiting />;
  return (
    <div className={styles.screen}>
      <section className={styles.left} aria-label="Gaps">
        <header className={styles.head}><h1>Gaps</h1><span className="soft number">{gaps ? `${gaps.gaps.filter(undecided).length} undecided of ${gaps.gaps.length}${gaps.pending ? ", being judged …" : ""}` : "…"}</span></header>
        <Accept />
        <Table />
      </section>
      <section className={styles.right} aria-label="The gap">
        <Ways />
        <div className={styles.curves}><CurvesView /></div>
        {header.cameras.length ? <div className={styles.below}><SceneView /><CamerasView /></div> : <div className={styles.scene}><SceneView /></div>}
      </section>
    </div>
  );
}

const TONE: Record<GapRow["state"], string> = { "not judged": "", fillable: "info", "above limit": "warn", open: "", chosen: "good", "no way": "bad" };

/** All gaps below a limit at once. */
function Accept(): React.JSX.Element {
  const limit = useStore((s) => s.limit), n = useStore(() => acceptable().length);
  return (
    <div className={styles.accept}>
      <label>Limit <input className="field" type="number" min={0} step={0.5} value={limit} onChange={(e) => set({ limit: Number(e.target.value) })} /> mm</label>
      <button type="button" className="button strong" disabled={!n} onClick={() => void fillAll()}><Spline size={14} aria-hidden />Fill {many(n, "gap")} below it<kbd>⇧ Enter</kbd></button>
    </div>
  );
}

function Table(): React.JSX.Element {
  const { gaps, gap, limit, gapOrder } = useStore(), rows = useMemo(() => tabled(useStore.getState()), [gaps, gapOrder]), list = useRef<VListHandle>(null);
  const at = gap ? rows.findIndex((g) => sameGap(g, gap)) : -1;
  useEffect(() => void (at >= 0 && list.current?.scrollToIndex(at, { align: "nearest" })), [at]);
  if (gaps && !rows.length) return <p className={styles.none}>No named marker has a gap. Tracks without a name are not filled: name them first.</p>;
  return (
    <div className={styles.table} role="table" aria-label="Gaps of all markers" aria-rowcount={rows.length + 1}>
      <div role="rowgroup"><div role="row" className={styles.titles}>
        <Title by="marker">Marker</Title><Title by="frames">Frames</Title><span role="columnheader">Method</span><Title by="expected">Expected</Title><span role="columnheader">State</span>
      </div></div>
      <VList ref={list} className={styles.list} role="rowgroup" tabIndex={0} aria-label="Rows">
        {rows.map((g, i) => <Row key={`${g.marker} ${g.first}`} gap={g} at={i} on={i === at} limit={limit} />)}
      </VList>
    </div>
  );
}

/** A title by which the table can be ordered: N goes through it in that order. */
function Title({ by, children }: { by: GapColumn; children: string }): React.JSX.Element {
  const order = useStore((s) => s.gapOrder), on = order?.by === by, Arrow = order?.down ? ArrowDown : ArrowUp;
  return (
    <span role="columnheader" aria-sort={on ? (order.down ? "descending" : "ascending") : "none"}>
      <button type="button" className={styles.order} title={`Order by ${children.toLowerCase()}`} onClick={() => set({ gapOrder: nextOrder(order, by) })}>{children}{on && <Arrow size={12} aria-hidden />}</button>
    </span>
  );
}

/** What fills it: as somebody chose, of the best what that is where it is known. */
const methodOf = (g: GapRow): string | undefined => (g.choice === "best" ? (g.method ?? g.choice) : (g.choice ?? g.method)) ?? undefined;

function Row({ gap: g, at, on, limit }: { gap: GapRow; at: number; on: boolean; limit: number }): React.JSX.Element {
  const over = g.expected_mm != null && g.expected_mm > limit;
  return (
    <div role="row" aria-rowindex={at + 2} className={styles.row} aria-selected={on} data-gap={`${g.marker} ${g.first}`} data-state={g.state} onClick={() => void lookAtGap(g)} title={[g.words, g.cameras_alone.length ? `${g.cameras_alone.join(", ")} saw it alone` : ""].filter(Boolean).join(" · ") || undefined}>
      <span role="cell"><Name of={g.marker} /></span>
      <span role="cell" className="number">{g.frames} <small className="soft">{frames(g.first, g.last)}</small></span>
      <span role="cell" title={methodOf(g)}>{wayOf(methodOf(g) ?? "–")}</span>
      <span role="cell" className={`number ${over ? styles.over : ""}`}>{g.expected_mm == null ? "–" : `${mm(g.expected_mm)} mm`}{over && <span title="above the limit"> ▲</span>}</span>
      <span role="cell"><span className={`pill ${TONE[g.state]}`}>{g.choice === "open" ? "left open" : g.state}</span></span>
    </div>
  );
}

/** The ways to fill the gap that is looked at, best first. */
function Ways(): React.JSX.Element {
  const { header, gaps, gap, candidates, method, clicks } = useStore();
  if (!gap && gaps && !gaps.gaps.length) return <div className={styles.ways}><p className="soft">{header?.cameras.length ? "No named marker has a gap between its first and its last sample." : "No named marker has a gap. Frames before a marker is first seen, or after it is last seen, do not count as gaps."}</p></div>;
  if (!gap) return <div className={styles.ways}><p className="soft">Choose a gap on the left, or press <kbd>N</kbd>. Each way to fill it is drawn with its band{header?.cameras.length ? "; the + in the images shows where the fill would be: a free image on the + proves it" : ""}.</p></div>;
  return (
    <div className={styles.ways}>
      <h2>{gap.marker} <span className="soft number">{frames(gap.first, gap.last)} · {many(gap.frames, "frame")}{gap.cameras_alone.length > 0 && ` · ${gap.cameras_alone.join(", ")} saw it alone`}</span></h2>
      <div className={styles.methods} role="group" aria-label="Ways to fill">
        {candidates?.candidates.map((c) => (
          <button key={c.method} type="button" className="button" aria-pressed={c.method === method} title={c.method} onClick={() => set({ method: c.method, picked: true })}>{wayOf(c.method)} <span className="number soft">{c.expected_mm == null ? "–" : `${mm(c.expected_mm)} mm`}</span></button>
        ))}
        {(!candidates || candidates.pending) && <span className="soft" role="status">others are being computed …</span>}
      </div>
      <div className={styles.acts}>
        <button type="button" className="button strong" onClick={() => void fillGap()}>Fill by {wayOf(method ?? "best")}<kbd>Enter</kbd></button>
        <button type="button" className="button" onClick={() => void fillGap("open")}><SkipForward size={14} aria-hidden />Leave open<kbd>O</kbd></button>
        <button type="button" className="button" aria-pressed={clicks !== null} onClick={() => set({ clicks: clicks ? null : [] })}><Crosshair size={14} aria-hidden />Put a point<kbd>P</kbd></button>
      </div>
      {clicks && <PutPanel key={`${gap.marker} ${method}`} />}
    </div>
  );
}
