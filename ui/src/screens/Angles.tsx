/** Joint angles: curves with their bands, over time or over cycles; the limb from any side; what made a leap. */
import { FileDown, SearchCheck } from "lucide-react";
import { useEffect, useRef, useState } from "react";
import { unpacked, type Angles as Shown } from "../api/sessions";
import { AngleCurves, type Row } from "../draw/AngleCurves";
import { Flat, type Dot, type Line, type Place } from "../draw/Flat";
import { palette } from "../draw/palette";
import { Asked } from "../parts/Shown";
import { Findings, WordTable } from "../parts/Tables";
import { Waiting } from "../parts/Waiting";
import { say } from "../state/load";
import { askSpike, fetchAngles, lookAtSpike, useSessions, writeEuler } from "../state/sessions";
import { get, playhead, useStore } from "../state/store";
import styles from "./Angles.module.css";

/** Standard deviations of a band that holds 95 %. */
const BAND = 1.96;

export function Angles(): React.JSX.Element {
  const header = useStore((s) => s.header), angles = useSessions((s) => s.angles), [cycles, setCycles] = useState(false);
  if (!header) return <Waiting />;
  if (!angles) return <div className={styles.none}><h1>Angles</h1><Asked words="The angles are worked out …" /></div>;
  const over = cycles && angles.joints.some((j) => j.curves.some((c) => c.cycles));
  return (
    <div className={styles.screen}>
      <Choices of={angles} over={over} onOver={setCycles} />
      {angles.words ? <p className={styles.words} role="status">{angles.words}</p> : (
        <div className={styles.body}>
          <Curves of={angles} over={over} />
          <section className={styles.side} aria-label="Limb and verdict" tabIndex={0}>
            <Limb of={angles} />
            <Leap />
            <h2>{angles.headline}</h2>
            {angles.sentences.map((one) => <p key={one} className="soft">{one}</p>)}
            <Findings of={angles.findings} />
            {angles.tables.map((table) => <WordTable key={table.title} of={table} />)}
          </section>
        </div>
      )}
    </div>
  );
}

function Choices({ of, over, onOver }: { of: Shown; over: boolean; onOver: (over: boolean) => void }): React.JSX.Element {
  const { model, smoothing, cutoff_hz, marker_sd_mm, cycle_event, cycle_side, inverse_cosines } = of.chosen, event = cycle_event ? `${cycle_event}|${cycle_side ?? ""}` : "";
  const cycle = (value: string): void => (onOver(value !== ""), void fetchAngles({ cycle_event: value.split("|")[0] || null, cycle_side: value.split("|")[1] || null }));
  return (
    <header className={styles.head}>
      <h1>Angles</h1>
      <label>Model <select className="field" value={model ?? ""} onChange={(e) => void fetchAngles({ model: e.target.value })}>{!model && <option value="">choose …</option>}{of.models.map((m) => <option key={m.name} value={m.name}>{m.name}{m.fits ? "" : ` (lacks ${m.wants.length})`}</option>)}</select></label>
      <label>Smoothing <select className="field" value={smoothing ?? "none"} onChange={(e) => void fetchAngles({ smoothing: e.target.value as "none" })}><option>none</option><option>butterworth</option><option>woltring</option></select></label>
      {smoothing && smoothing !== "none" && <Stated words="Cut-off, Hz" of={cutoff_hz} onStated={(v) => void fetchAngles({ cutoff_hz: v })} />}
      {!of.errors_stated && <Stated words="Markers’ SD, mm" title="Standard deviation of a marker along an axis, as the laboratory knows it; where none is stated it is estimated from how unsteady each is" of={marker_sd_mm} onStated={(v) => void fetchAngles({ marker_sd_mm: v })} />}
      <label>Cycles <select className="field" value={event} onChange={(e) => cycle(e.target.value)}><option value="">none</option>{of.events.filter((e) => e.times > 1).map((e) => <option key={`${e.label}|${e.side}`} value={`${e.label}|${e.side}`}>{e.label} {e.side} ({e.times})</option>)}</select></label>
      {event && <button type="button" className="button" aria-pressed={over} onClick={() => onOver(!over)}>0–100 %</button>}
      {of.euler && <label><input type="checkbox" checked={inverse_cosines ?? false} onChange={(e) => void fetchAngles({ inverse_cosines: e.target.checked })} /> without sign, as UM²AS</label>}
      {of.euler && <button type="button" className="button" onClick={() => void writeEuler()}><FileDown size={14} aria-hidden />.shd .elb .wst</button>}
    </header>
  );
}

/** A number above nothing that the data give where it is not stated. */
function Stated({ words, title, of, onStated }: { words: string; title?: string; of: number | null | undefined; onStated: (value: number | null) => void }): React.JSX.Element {
  const stated = (e: React.FocusEvent<HTMLInputElement>): void => {
    const said = e.target.value.trim().replace(",", "."), value = said ? Number(said) : null;
    if (value === (of ?? null)) return;
    if (value === null || value > 0) return onStated(value);
    e.target.value = String(of ?? "");
    say("refused", `${words}: ${said} is no number above 0.`);
  };
  return <label title={title}>{words} <input className={`field ${styles.hz}`} inputMode="decimal" defaultValue={of ?? ""} placeholder="by data" onKeyDown={(e) => { if (e.key === "Enter") e.currentTarget.blur(); }} onBlur={stated} /></label>;
}

function rowsOf(of: Shown, over: boolean): Row[] {
  const frames = Array.from({ length: of.n_frames }, (_, i) => of.first_frame + i), percents = Array.from({ length: 101 }, (_, i) => i);
  return of.joints.flatMap((j) => j.curves.map((c): Row => {
    const title = `${j.name}: ${c.positive} +${c.negative ? `, ${c.negative} −` : ""}`, own = { joint: j.index, turn: c.turn, title, normal: c.normal };
    if (!over || !c.cycles) return { ...own, x: frames, y: unpacked(c.deg), band: unpacked(c.sd).map((v) => BAND * v), thin: [], locked: j.locked };
    const each = unpacked(c.cycles.each);
    return { ...own, x: percents, y: unpacked(c.cycles.mean), band: unpacked(c.cycles.spread), thin: Array.from({ length: c.cycles.n }, (_, k) => each.subarray(101 * k, 101 * k + 101)), locked: [] };
  }));
}

function Curves({ of, over }: { of: Shown; over: boolean }): React.JSX.Element {
  const place = useRef<HTMLDivElement>(null), [curves, setCurves] = useState<AngleCurves | null>(null), theme = useStore((s) => s.theme);
  useEffect(() => {
    const made = new AngleCurves(place.current!);
    setCurves(made);
    return () => made.dispose();
  }, []);
  useEffect(() => {
    if (!curves) return;
    curves.onPoint = (joint, turn, x): void => void (over || askSpike(joint, turn, Math.round(x)));
    curves.set(rowsOf(of, over));
    const off = playhead.on((frame) => curves.show(over ? null : frame));
    playhead.draw();
    return off;
  }, [curves, of, over, theme]);
  return (
    <section className={styles.curves} aria-label="Curves" tabIndex={0}>
      <p className={styles.legend}>{over ? "Mean, ± SD over the cycles, each cycle thin; 0 to 100 %" : "Shaded: 95 %. Between dashed lines: normal motion. Click a leap: what made it?"}</p>
      <div ref={place} role="img" aria-label={`${of.joints.map((j) => j.name).join(", ")}: angles ${over ? "over cycles" : "over time"}`} />
    </section>
  );
}

function Leap(): React.JSX.Element | null {
  const spike = useSessions((s) => s.spike);
  if (!spike) return null;
  return (
    <div className={styles.leap} role="status" data-marker={spike.marker} data-frame={spike.frame}>
      <p>{spike.words}</p>
      <button type="button" className="button strong" onClick={lookAtSpike}><SearchCheck size={14} aria-hidden />Look at {spike.marker}<kbd>Enter</kbd></button>
    </div>
  );
}

const SIDES = [["front", "Front"], ["side", "Side"], ["top", "Above"], ["oblique", "Between"]] as const;
/** s of path behind each point; chosen. */
const TAIL_S = 0.6;

function Limb({ of }: { of: Shown }): React.JSX.Element {
  const canvas = useRef<HTMLCanvasElement>(null), [flat, setFlat] = useState<Flat | null>(null), theme = useStore((s) => s.theme);
  useEffect(() => {
    const made = new Flat(canvas.current!);
    setFlat(made);
    return () => made.dispose();
  }, []);
  useEffect(() => {
    if (!flat || !of.limb.length) return;
    const points = of.limb.map((one) => ({ name: one.name, xyz: unpacked(one.xyz) })), p = palette();
    const at = (k: number, i: number): Place | null => { const v = points[k]!.xyz.subarray(3 * i, 3 * i + 3); return Number.isFinite(v[0]! + v[1]! + v[2]!) ? [v[0]!, v[1]!, v[2]!] : null; };
    const all = points.flatMap((_, k) => Array.from({ length: of.n_frames }, (__, i) => at(k, i)).filter((a): a is Place => a !== null));
    const ends = (pick: (a: number, b: number) => number): Place => all.reduce((x, y) => [pick(x[0], y[0]), pick(x[1], y[1]), pick(x[2], y[2])] as const, all[0] ?? [0, 0, 0]);
    flat.frame(ends(Math.min), ends(Math.max), get().header?.up);
    const tail = Math.round(TAIL_S * of.rate);
    const off = playhead.on((frame) => {
      const i = frame - of.first_frame, lines: Line[] = [];
      for (const k of points.keys()) for (let f = Math.max(0, i - tail); f < i; f++) { const a = at(k, f), b = at(k, f + 1); if (a && b) lines.push({ a, b, colour: p.line }); }
      for (const [m, n] of of.links) { const a = at(m, i), b = at(n, i); if (a && b) lines.push({ a, b, colour: p.measured, width: 3 }); }
      flat.show(lines, points.flatMap(({ name }, k): Dot[] => { const a = at(k, i); return a ? [{ at: a, colour: p.ink, size: 4, words: name }] : []; }));
    });
    playhead.draw();
    return off;
  }, [flat, of, theme]);
  return (
    <div className={styles.limb}>
      <canvas ref={canvas} role="img" aria-label="The limb in space, in the frame that is shown" />
      <div className={styles.sides}>{SIDES.map(([side, words]) => <button key={side} type="button" className="button" onClick={() => flat?.orbit.side(side)}>{words}</button>)}</div>
    </div>
  );
}
