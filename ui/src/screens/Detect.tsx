/** Detection: the images of all cameras in one frame, what is found in them and what is not, and why. */
import { Brush, Maximize2, Minimize2, Play, RotateCcw, Save, Trash2 } from "lucide-react";
import * as api from "../api/client";
import type { CameraFound, DetectParameter, Mark } from "../api/types";
import { HistogramView } from "../draw/Histogram";
import { label, type Box, type Over } from "../draw/Picture";
import { whitePixels } from "../draw/white";
import { many } from "../model/format";
import { FrameBar } from "../parts/FrameBar";
import { PictureView } from "../parts/PictureView";
import { RunState } from "../parts/RunState";
import { Unshown } from "../parts/Unshown";
import * as d from "../state/detect";
import { runTrial } from "../state/load";
import { get, useStore } from "../state/store";
import styles from "./Detect.module.css";

/** Colours on images, which are dark in every theme; each state has its shape, too. */
const INK: Record<Mark["state"], string> = { marker: "#4ade9a", "too small": "#f6c453", "too large": "#ff8b6b", "not round": "#8fc7ff", "at edge": "#d8a6ff", masked: "#a9b4be" };
const SHORT: Record<Mark["state"], string> = { marker: "marker", "too small": "too small", "too large": "too large", "not round": "not round", "at edge": "at the edge", masked: "masked" };
/** px of the screen that a ring is wider than its marker. */
const ROOM = 2.5;
/** px of the screen a pixel, from which reasons are written beside their marks; chosen: nearer they would cover the image. */
const NAMED = 0.4;

export function Detect(): React.JSX.Element {
  const t = useStore((s) => s.detect);
  if (!t) return <Unshown title="Detect" />;
  const shown = t.large ? t.about.cameras.filter((c) => c.name === t.large) : t.about.cameras;
  return (
    <div className={styles.screen} data-frame={t.frame} data-found={t.found.length === t.about.cameras.length ? "yes" : "no"}>
      <section className={styles.left} aria-label="Images">
        <div className={styles.tiles} style={{ "--columns": Math.ceil(Math.sqrt(shown.length)) } as React.CSSProperties}>
          {shown.map((c) => <Tile key={c.name} name={c.name} />)}
        </div>
        <Legend />
        <FrameBar first={t.about.first} last={t.about.last} frame={t.frame} go={d.goToFrame} />
      </section>
      <aside className={styles.side} aria-label="Detection">
        <header className={styles.head}><h1>Detect</h1><span className="soft">{t.about.session} · {t.about.trial}</span></header>
        {t.about.words && <p className={styles.note}>{t.about.words}</p>}
        <Settings t={t} />
        <Why t={t} />
        <Masks t={t} />
        <Apply t={t} />
      </aside>
    </div>
  );
}

function Tile({ name }: { name: string }): React.JSX.Element {
  const t = useStore((s) => s.detect)!, id = useStore((s) => s.id)!, camera = t.about.cameras.find((c) => c.name === name)!, found = t.found.find((c) => c.name === name);
  const n = found?.marks.filter((m) => m.state === "marker").length ?? 0, refused = (found?.marks.length ?? 0) - n;
  const box = ({ x, y, width, height }: Box): void => {
    const [l, r, o, u] = [x - 0.5, x + width - 0.5, y - 0.5, y + height - 0.5].map((v, i) => Math.min(Math.max(v, -0.5), (i < 2 ? camera.width : camera.height) - 0.5)) as [number, number, number, number];
    d.setMasks(name, [...d.masksOf(t, name), [[l, o], [r, o], [r, u], [l, u]]]);
  };
  return (
    <section className={styles.tile} aria-label={name} data-markers={found ? n : ""} data-refused={refused}>
      <header>
        <b>{name}</b>
        {!found && <span className="soft">{t.about.learned ? "learning from its recording …" : "…"}</span>}
        {found && <span>{many(n, "marker")}{refused > 0 && `, ${refused} refused`}</span>}
        {found?.ground && <span className={styles.ground} title="The static ground of this camera is subtracted before">ground subtracted</span>}
        <button type="button" className={styles.size} aria-label={t.large ? "All cameras" : `${name} alone`} title={t.large ? "All cameras" : `${name} alone`} onClick={() => d.showLarge(t.large ? null : name)}>{t.large ? <Minimize2 size={14} aria-hidden /> : <Maximize2 size={14} aria-hidden />}</button>
      </header>
      <PictureView label={`Image of ${name}`} address={api.pictureAddress(id, name, t.frame, t.about.every)} tall={camera.tall ? 2 : 1} over={over(t, name, found)} onClick={(u, v) => void d.ask(name, u, v)} onBox={t.painting ? box : null} />
      {found?.refused && <p className={styles.refused}>{found.refused}</p>}
    </section>
  );
}

/** White pixels, masks, marks, and the place that was asked about. */
function over(t: d.Tried, name: string, found: CameraFound | undefined): Over {
  const picture = api.pictureAddress(get().id!, name, t.frame, t.about.every);
  return (c, to, s, redraw) => {
    if (t.white && found && found.threshold !== null && !found.ground) whitePixels(c, picture, found.threshold, found.inverted, s, redraw);
    for (const polygon of d.masksOf(t, name)) mask(c, polygon.map(([u, v]) => to(u, v)));
    for (const m of found?.marks ?? []) mark(c, m, to(m.u, m.v), s.by, s.tall);
    if (t.why?.camera !== name) return;
    const [x, y] = to(t.why.u, t.why.v);
    c.strokeStyle = "#fff";
    c.lineWidth = 1;
    c.strokeRect(x - 9, y - 9, 18, 18);
  };
}

function mask(c: CanvasRenderingContext2D, corners: readonly (readonly [number, number])[]): void {
  c.beginPath();
  for (const [x, y] of corners) c.lineTo(x, y);
  c.closePath();
  c.fillStyle = "rgb(120 150 190 / 38%)";
  c.fill();
  c.strokeStyle = "#a9c8ee";
  c.lineWidth = 1;
  c.stroke();
}

/** A ring is a marker, a cross is none; two rings lie on each other. */
function mark(c: CanvasRenderingContext2D, m: Mark, [x, y]: readonly [number, number], by: number, tall: number): void {
  const rx = (m.width / 2) * by + ROOM, ry = (m.height / 2) * by * tall + ROOM;
  for (const [ink, width] of [["rgb(0 0 0 / 80%)", 3.4], [INK[m.state], 1.6]] as const) {
    c.strokeStyle = ink;
    c.lineWidth = width;
    c.beginPath();
    if (m.state === "marker") c.ellipse(x, y, rx, ry, 0, 0, 7);
    else c.rect(x - rx, y - ry, 2 * rx, 2 * ry);
    if (m.merged) c.moveTo(x + rx + 3, y), c.ellipse(x, y, rx + 3, ry + 3, 0, 0, 7);
    if (m.state !== "marker") c.moveTo(x - 4, y - 4), c.lineTo(x + 4, y + 4), c.moveTo(x + 4, y - 4), c.lineTo(x - 4, y + 4);
    c.stroke();
  }
  if (m.state === "marker" || by < NAMED) return;
  const wide = c.measureText(SHORT[m.state]).width, right = x + rx + 4;
  label(c, right + wide > c.canvas.clientWidth ? x - rx - wide - 4 : right, y + 3, SHORT[m.state], INK[m.state]);
}

const Legend = (): React.JSX.Element => (
  <ul className={styles.legend} aria-label="What is drawn on the images">
    {(Object.keys(INK) as Mark["state"][]).map((state) => <li key={state}><svg width="14" height="14" viewBox="0 0 14 14" aria-hidden><Sign state={state} /></svg>{SHORT[state]}</li>)}
    <li><svg width="16" height="14" viewBox="0 0 16 14" aria-hidden><g fill="none" stroke={INK.marker} strokeWidth="1.4"><circle cx="8" cy="7" r="3.4" /><circle cx="8" cy="7" r="6" /></g></svg>on each other</li>
  </ul>
);

function Sign({ state }: { state: Mark["state"] }): React.JSX.Element {
  const line = { fill: "none", stroke: INK[state], strokeWidth: 1.6 };
  return state === "marker" ? <circle cx="7" cy="7" r="5" {...line} /> : <g {...line}><rect x="1.5" y="1.5" width="11" height="11" /><path d="M4 4 10 10M10 4 4 10" /></g>;
}

const WORDS: Record<string, string> = { threshold: "Threshold", min_area: "Least area", max_area: "Greatest area", min_width: "Least width", max_aspect: "Longest by widest", inverted: "Dark markers on bright ground" };
/** The sliders' ends where a parameter has none of its own. */
const MOST: Record<string, number> = { threshold: 255, min_area: 200, max_area: 4000, min_width: 12, max_aspect: 8 };

function Settings({ t }: { t: d.Tried }): React.JSX.Element {
  return (
    <section className={styles.section} aria-label="Parameters">
      <label className={styles.of}>For
        <select className="field" aria-label="For which cameras" value={t.of ?? ""} onChange={(e) => d.chooseOf(e.target.value || null)}>
          <option value="">all cameras</option>
          {t.about.cameras.map((c) => <option key={c.name} value={c.name}>{c.name} alone</option>)}
        </select>
      </label>
      <HistogramView found={d.foundOf(t, t.of ?? t.large)} onThreshold={(level) => d.tryValue("threshold", level)} />
      {t.about.parameters.map((p) => (p.flag ? <Flag key={p.name} t={t} p={p} /> : <Figure key={p.name} t={t} p={p} />))}
      {t.about.parameters.some((p) => !p.flag && d.valueOf(t, p.name) === null) && <p className="soft"><i>Slanted</i>: {t.of ? "as for all cameras" : t.about.learned ? "learned from each camera's recording" : "the usual value"}.</p>}
    </section>
  );
}

function Flag({ t, p }: { t: d.Tried; p: DetectParameter }): React.JSX.Element {
  return <label className={styles.flag} title={p.meaning}><input type="checkbox" checked={Boolean(d.valueOf(t, p.name))} onChange={(e) => d.tryValue(p.name, e.target.checked)} />{WORDS[p.name] ?? p.name}</label>;
}

/** A number: what is stated, or else what was learned, which is shown as such. */
function Figure({ t, p }: { t: d.Tried; p: DetectParameter }): React.JSX.Element {
  const value = d.valueOf(t, p.name) as number | null, used = d.usedOf(t, p.name), known = value ?? used, now = known ?? 0, words = WORDS[p.name] ?? p.name;
  const step = p.whole ? 1 : p.name === "threshold" ? 1 : 0.1, least = p.low ?? 0, most = Math.max(MOST[p.name] ?? 100, now);
  const change = (n: number): void => (Number.isFinite(n) ? d.tryValue(p.name, Math.min(p.high === null ? n : Math.min(n, p.high === 255 ? 254 : p.high), Math.max(least, n))) : undefined);
  return (
    <div className={styles.figure} title={p.meaning} data-parameter={p.name} data-open={value === null ? "yes" : "no"}>
      <span>{words}</span>
      <input type="range" aria-label={`${words}, slider`} min={least} max={most} step={step} value={now} onChange={(e) => change(e.target.valueAsNumber)} />
      <input type="number" className="field number" aria-label={value === null ? `${words}, left open` : words} min={least} max={p.high ?? undefined} step={step} value={known === null ? "" : round(known)} onChange={(e) => change(e.target.valueAsNumber)} />
      <button type="button" className="icon-button" aria-label={`${words}: leave it open`} title={t.of ? "As for all cameras" : "Leave it open"} disabled={value === null} onClick={() => d.tryValue(p.name, null)}><RotateCcw size={13} aria-hidden /></button>
    </div>
  );
}

const round = (n: number): number => Math.round(10 * n) / 10;

function Why({ t }: { t: d.Tried }): React.JSX.Element {
  const why = t.why, take = why?.parameter && why.value != null ? { name: why.parameter, value: why.value } : null;
  return (
    <section className={styles.section} aria-label="Why" aria-live="polite">
      <h2>Why is this a marker, or none?</h2>
      {!why && <p className="soft">Click on a place in an image.</p>}
      {why && <p data-why={why.parameter}><b>{why.camera} ({Math.round(why.u)}, {Math.round(why.v)})</b> {why.words}</p>}
      {take && <button type="button" className="button" onClick={() => d.tryValue(take.name, take.value)}>Try {WORDS[take.name]?.toLowerCase() ?? take.name} {round(take.value)}</button>}
    </section>
  );
}

function Masks({ t }: { t: d.Tried }): React.JSX.Element {
  const all = t.about.cameras.flatMap((c) => d.masksOf(t, c.name).map((polygon, i) => ({ camera: c.name, polygon, i })));
  return (
    <section className={styles.section} aria-label="Masks">
      <div className={styles.row}><h2>Masks</h2><button type="button" className="button" aria-pressed={t.painting} onClick={d.flipPainting}><Brush size={13} aria-hidden />Paint<kbd>M</kbd></button></div>
      {t.painting && <p className="soft">Drag a rectangle over what is never a marker: a lamp, a reflection.</p>}
      {!all.length && !t.painting && <p className="soft">None is drawn.</p>}
      <ul className={styles.masks}>
        {all.map(({ camera, polygon, i }) => (
          <li key={`${camera} ${i}`}>{camera} <span className="number soft">{extent(polygon)}</span><button type="button" className="icon-button" aria-label={`Remove mask ${i + 1} of ${camera}`} onClick={() => d.setMasks(camera, d.masksOf(t, camera).filter((_, k) => k !== i))}><Trash2 size={13} aria-hidden /></button></li>
        ))}
      </ul>
    </section>
  );
}

function extent(polygon: d.Polygon): string {
  const u = polygon.map((p) => p[0]), v = polygon.map((p) => p[1]);
  return `${Math.round(Math.max(...u) - Math.min(...u))} × ${Math.round(Math.max(...v) - Math.min(...v))} px at ${Math.round(Math.min(...u) + 0.5)}, ${Math.round(Math.min(...v) + 0.5)}`;
}

function Apply({ t }: { t: d.Tried }): React.JSX.Element {
  const id = useStore((s) => s.id), job = useStore((s) => (id ? s.jobs[id] : undefined)), on = d.changed(t), running = job?.state === "running";
  return (
    <section className={`${styles.section} ${styles.apply}`} aria-label="Apply">
      {on ? <p className="soft" role="status">This is tried in this frame alone; nothing is written yet.</p> : <RunState otherwise="All frames are detected as session.toml says." />}
      <div className={styles.row}>
        <button type="button" className="button strong" disabled={!on} onClick={() => void d.applyDraft()}><Save size={14} aria-hidden />Apply to all<kbd>Enter</kbd></button>
        <button type="button" className="button" disabled={!on} onClick={d.forgetDraft}>Forget</button>
        <button type="button" className="button" disabled={running} onClick={() => void runTrial()}><Play size={13} aria-hidden />Run</button>
      </div>
    </section>
  );
}
