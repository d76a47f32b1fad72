/** Digitising and verifying: one large image, a question in words, and what the other cameras say of it. */
import { CircleCheck, CircleDashed, EyeOff, Hand, Play, RotateCcw, Save, Undo2, ZoomIn, ZoomOut } from "lucide-react";
import { useEffect, useRef, useState } from "react";
import * as api from "../api/client";
import type { DigitisingNow, PlacedMarker } from "../api/types";
import { bitmapAt, label, plus, type Over, type Picture } from "../draw/Picture";
import { fit } from "../draw/palette";
import { FrameBar } from "../parts/FrameBar";
import { PictureView } from "../parts/PictureView";
import { RunState } from "../parts/RunState";
import { StartUp } from "../parts/StartUp";
import { Unshown } from "../parts/Unshown";
import * as g from "../state/digitise";
import { runTrial } from "../state/load";
import { useStore } from "../state/store";
import styles from "./Digitise.module.css";

/** Colours on images, which are dark in every theme. */
const HERE = "#ff7ac6", KNOWN = "#4ade9a", SAID = "#f6c453", LINES = ["#8fc7ff", "#f6a36b", "#d8a6ff", "#7fe3d0"] as const;
/** px of the image in half a loupe; times that the buttons enlarge. Chosen. */
const LOUPE = 14, LARGER = 1.6;

export function Digitise(): React.JSX.Element {
  const d = useStore((s) => s.digitise), id = useStore((s) => s.id)!, [at, setAt] = useState<[number, number] | null>(null), picture = useRef<Picture | null>(null);
  useEffect(() => setAt(null), [d?.now.camera, d?.now.kept]); // until the cursor moves, the loupe is where the next one is expected
  const [starting, setStarting] = useState(false), fresh = d !== null && d.now.kept === 0 && !d.now.can_undo;
  if (!d) return <Unshown title="Digitise & verify"><StartUp done={() => setStarting(false)} /></Unshown>;
  const { now } = d, camera = now.cameras.find((c) => c.name === now.camera)!, frame = d.shown ?? now.question.frame, address = api.pictureAddress(id, now.camera, frame, now.every);
  const click = (u: number, v: number): void => void (g.pointing(d) && g.answer({ kind: "point", u, v }));
  return (
    <div className={styles.screen} data-phase={d.shown === null ? now.question.phase : "looking"} data-frame={frame} data-camera={now.camera} data-kept={now.kept}>
      <section className={styles.left} aria-label="Image">
        <div className={styles.image}>
          <PictureView label={`Image of ${now.camera}`} address={address} tall={camera.tall ? 2 : 1} over={over(d)} onClick={click} onMove={(u, v) => setAt([u, v])} handle={(made) => (picture.current = made)} />
          <p className={styles.where}><b>{now.camera}</b> frame {frame} of {now.frames}{d.shown !== null && <> · the question is of frame {now.question.frame}</>}</p>
          <div className={styles.zoom}>
            <button type="button" className="icon-button" aria-label="Larger" title="Larger (wheel)" onClick={() => picture.current?.larger(LARGER)}><ZoomIn size={16} aria-hidden /></button>
            <button type="button" className="icon-button" aria-label="All of the image" title="All of the image (double click)" onClick={() => picture.current?.whole()}><ZoomOut size={16} aria-hidden /></button>
          </div>
          {g.pointing(d) && <button type="button" className={styles.absent} onClick={() => void g.answer({ kind: "absent" })}><EyeOff size={14} aria-hidden />Not present<kbd>B</kbd></button>}
        </div>
        <FrameBar first={1} last={now.frames} frame={frame} go={(f) => void g.showFrame(f)} />
      </section>
      <aside className={styles.side} aria-label="Question and markers">
        <header className={styles.head}><h1>Digitise &amp; verify</h1><span className="soft">{now.session} · {now.trial}</span>{fresh && <button type="button" className="button" aria-expanded={starting} onClick={() => setStarting(!starting)}>Start up</button>}</header>
        {starting && fresh ? <StartUp done={() => setStarting(false)} /> : <Question d={d} />}
        <div className={styles.middle}><Loupe address={address} at={loupeAt(d, at)} tall={camera.tall ? 2 : 1} /><Cameras now={now} /></div>
        <Markers d={d} />
      </aside>
    </div>
  );
}

const loupeAt = (d: g.Digitised, at: [number, number] | null): readonly [number, number] | null =>
  at ?? (g.pointing(d) ? d.now.question.spots[d.spot] : null) ?? d.now.question.at;

/** The image on which the question is put: what is known, what is asked for, and what the other cameras say. */
function over(d: g.Digitised): Over {
  const { question: q, draft } = d.now;
  return (c, to, s) => {
    const placed = d.shown === null ? draft : d.saved;
    for (const m of placed) if (m.u !== null && m.v !== null && (d.shown !== null || m.name !== q.marker)) marker(c, to(m.u, m.v), m.name, KNOWN);
    if (d.shown !== null) return;
    for (const [i, line] of q.lines.entries()) polyline(c, line.points.map(([u, v]) => to(u, v)), LINES[i % LINES.length]!, `from ${line.camera}`);
    if (g.pointing(d)) {
      if (q.at && q.search > 0) square(c, to(...q.at), q.search * s.by);
      if (q.said?.at) plus(c, to(...q.said.at), 11, SAID, 3);
      const spot = q.spots[d.spot];
      if (spot) ring(c, to(...spot), HERE);
    } else if (q.at) plus(c, to(...q.at), 12, HERE, 3), label(c, to(...q.at)[0] + 12, to(...q.at)[1] - 8, q.marker, HERE);
  };
}

function marker(c: CanvasRenderingContext2D, [x, y]: readonly [number, number], name: string, colour: string): void {
  plus(c, [x, y], 5, colour);
  label(c, x + 8, y - 5, name, colour);
}

function ring(c: CanvasRenderingContext2D, [x, y]: readonly [number, number], colour: string): void {
  for (const [ink, width] of [["#000", 3.6], [colour, 1.8]] as const) {
    c.strokeStyle = ink;
    c.lineWidth = width;
    c.beginPath();
    c.arc(x, y, 14, 0, 7);
    c.stroke();
  }
}

function square(c: CanvasRenderingContext2D, [x, y]: readonly [number, number], side: number): void {
  c.strokeStyle = "rgb(255 255 255 / 70%)";
  c.lineWidth = 1;
  c.setLineDash([3, 4]);
  c.strokeRect(x - side / 2, y - side / 2, side, side);
  c.setLineDash([]);
}

function polyline(c: CanvasRenderingContext2D, points: readonly (readonly [number, number])[], colour: string, words: string): void {
  c.strokeStyle = colour;
  c.lineWidth = 1.3;
  c.beginPath();
  for (const [x, y] of points) c.lineTo(x, y);
  c.stroke();
  const { width, height } = c.canvas, inside = points.find(([x, y]) => x > 20 && y > 40 && x < width - 120 && y < height - 20);
  if (inside) label(c, inside[0] + 4, inside[1] - 4, words, colour);
}

const ICON = { yes: CircleCheck, no: RotateCcw, save: Save };

function Answer({ kind, words, keys, strong, icon }: { kind: "yes" | "no" | "save" | "verify" | "hand"; words: string; keys: string; strong?: boolean; icon?: keyof typeof ICON }): React.JSX.Element {
  const Icon = icon && ICON[icon];
  return <button type="button" className={`button ${strong ? "strong" : ""}`} onClick={() => void g.answer({ kind })}>{Icon && <Icon size={14} aria-hidden />}{words}<kbd>{keys}</kbd></button>;
}

function Question({ d }: { d: g.Digitised }): React.JSX.Element {
  const { now, shown } = d, q = now.question, looking = shown !== null;
  return (
    <section className={styles.question} aria-label="Question" aria-live="polite">
      <p className={styles.of}>{looking ? `Frame ${shown} is ${g.isSaved(now, shown) ? "saved" : "not saved yet"}` : q.phase === "done" ? now.camera : `${now.camera} · frame ${q.frame} of ${now.frames}`}</p>
      <h2>{looking ? (g.isSaved(now, shown) ? "Change this frame?" : "The question is of another frame.") : q.words}</h2>
      <div className={styles.answers}>
        {looking && g.isSaved(now, shown) && <button type="button" className="button strong" onClick={() => void g.answer({ kind: "frame", frame: shown })}><RotateCcw size={14} aria-hidden />Change frame {shown}<kbd>R</kbd></button>}
        {looking && <button type="button" className="button" onClick={() => void g.showFrame(q.frame)}>Back to the question<kbd>Home</kbd></button>}
        {!looking && (q.phase === "reference" || q.phase === "verify") && <><Answer kind="yes" words="Yes" keys="Y" strong icon="yes" /><Answer kind="no" words="No" keys="N" icon="no" /></>}
        {!looking && q.phase === "point" && q.said && <Answer kind="yes" words={q.said.seen ? "It is at the +" : "It is hidden"} keys="Y" strong icon="yes" />}
        {!looking && q.phase === "review" && <><Answer kind="save" words={`Save frame ${q.frame}`} keys="Enter" strong icon="save" /><Answer kind="verify" words="Verify" keys="V" /><button type="button" className="button" onClick={() => void g.answer({ kind: "hand" })}><Hand size={14} aria-hidden />By hand<kbd>H</kbd></button></>}
        {!looking && q.phase === "done" && <button type="button" className="button strong" onClick={() => void runTrial()}><Play size={14} aria-hidden />Run the trial</button>}
        {!looking && now.can_undo && <button type="button" className="button" onClick={() => void g.answer({ kind: "undo" })}><Undo2 size={14} aria-hidden />Undo<kbd>⌫</kbd></button>}
      </div>
      {!looking && q.phase === "done" && <RunState otherwise={now.finished ? "All cameras are digitised." : ""} />}
      {g.pointing(d) && <p className="soft">{q.phase === "correct" ? "Click where its centre is." : "Click any white pixel of it; the centroid counts."} Or choose a spot by <kbd>,</kbd> <kbd>.</kbd> and take it by <kbd>Space</kbd>.</p>}
    </section>
  );
}

/** What is under the cursor, or where the marker is expected, enlarged. */
function Loupe({ address, at, tall }: { address: string; at: readonly [number, number] | null; tall: number }): React.JSX.Element {
  const canvas = useRef<HTMLCanvasElement>(null), [u, v] = at ?? [null, null];
  useEffect(() => {
    let gone = false;
    void bitmapAt(address).then((bitmap) => {
      const element = canvas.current;
      if (gone || !element) return;
      const side = element.clientWidth, ratio = fit(element, side, side), c = element.getContext("2d")!;
      c.setTransform(ratio, 0, 0, ratio, 0, 0);
      c.clearRect(0, 0, side, side);
      if (u === null || v === null) return;
      c.imageSmoothingEnabled = false;
      const n = 2 * LOUPE + 1;
      c.drawImage(bitmap, u - LOUPE, v - LOUPE / tall, n, n / tall, 0, 0, side, side);
      plus(c, [side / 2, side / 2], 13, HERE, 5);
    }).catch(() => null);
    return () => void (gone = true);
  }, [address, u, v, tall]);
  return <canvas ref={canvas} className={styles.loupe} role="img" aria-label="Loupe" />;
}

function Cameras({ now }: { now: DigitisingNow }): React.JSX.Element {
  return (
    <ul className={styles.cameras} aria-label="Cameras">
      {now.cameras.map((c) => (
        <li key={c.name} aria-current={c.name === now.camera ? "true" : undefined} data-saved={c.saved}>
          <b>{c.name}</b><span className="number soft">{c.saved === now.frames ? "done" : `${c.saved}/${now.frames}`}</span>
          <progress max={now.frames} value={c.saved} aria-label={`Frames of ${c.name} that are saved`} />
        </li>
      ))}
    </ul>
  );
}

const TONE: Record<PlacedMarker["how"], string> = { open: "", "not present": "", automatic: "info", pointed: "good", placed: "good", proposed: "info", ambiguous: "warn" };

/** The draft of the frame, before it is saved; or what is saved of the one that is looked at. */
function Markers({ d }: { d: g.Digitised }): React.JSX.Element {
  const rows = d.shown === null ? d.now.draft : d.saved;
  return (
    <section className={styles.markers} aria-label="Markers of the frame" tabIndex={0}>
      <table>
        <thead><tr><th scope="col">Marker</th><th scope="col">u, px</th><th scope="col">v, px</th><th scope="col">{d.shown === null && d.now.question.phase !== "done" ? "Not saved yet" : "Saved"}</th></tr></thead>
        <tbody>
          {rows.map((m) => (
            <tr key={m.name} aria-current={d.shown === null && m.name === d.now.question.marker ? "true" : undefined} data-how={m.how}>
              <th scope="row">{m.name}{m.name === d.now.reference && <small className="soft"> reference</small>}</th>
              <td className="number">{m.u === null ? "–" : m.u.toFixed(2)}</td><td className="number">{m.v === null ? "–" : m.v.toFixed(2)}</td>
              <td><span className={`pill ${TONE[m.how]}`}>{m.how === "open" ? <CircleDashed size={11} aria-hidden /> : null}{m.how}</span></td>
            </tr>
          ))}
        </tbody>
      </table>
      {!rows.length && <p className="soft">Nothing is saved of this frame.</p>}
    </section>
  );
}
