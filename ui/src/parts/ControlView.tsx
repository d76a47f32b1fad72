/** Control balls in the images of the cameras: the white pixels of a threshold, clicked in order, the reference marker last. */
import { EyeOff, Undo2 } from "lucide-react";
import { useEffect, useRef, useState } from "react";
import * as api from "../api/sessions";
import { palette } from "../draw/palette";
import { answer, asked, back, choose, fetchWhite, keepThreshold, put, spotsOf, useSessions } from "../state/sessions";
import { useStore } from "../state/store";
import { Asked } from "./Shown";
import styles from "./ControlView.module.css";

export function ControlView(): React.JSX.Element {
  const { control, camera, point, given } = useSessions();
  if (!control) return <Asked words="The images are read …" />;
  const own = control.cameras.find((c) => c.name === camera), files = control.reference_files;
  return (
    <div className={styles.screen}>
      <section className={styles.image} aria-label="Image">
        <p className={styles.question} role="status">{!own ? "Choose a camera." : asked(own).some((b) => b.point === point && b.seen !== null) ? <><b>{camera}</b>: <b>{point}</b> is said. A click at another spot moves it; <kbd>N</kbd> goes to the next ball.</> : <><b>{camera}</b>: where is <b>{point}</b>? Click any white pixel of it, or choose a spot with <kbd>.</kbd> and point at it with <kbd>Space</kbd>.</>}</p>
        <Picture />
        <Threshold />
      </section>
      <aside className={styles.side} aria-label="Balls" tabIndex={0}>
        <div className={styles.acts}>
          <button type="button" className="button" onClick={() => void answer({ seen: false })}><EyeOff size={14} aria-hidden />Not seen<kbd>B</kbd></button>
          <button type="button" className="button" disabled={!given.length} onClick={() => void back()}><Undo2 size={14} aria-hidden />Take back<kbd>⌫</kbd></button>
        </div>
        {point === control.reference && files.length > 0 && <label>By file <select className="field" value="" onChange={(e) => void answer({ file: e.target.value })}><option value="">…</option>{files.map((f) => <option key={f}>{f}</option>)}</select></label>}
        {control.cameras.map((c) => (
          <div key={c.name} className={styles.camera}>
            <h2>{c.name} <span className="soft number">{c.balls.filter((b) => b.seen !== null).length} of {c.balls.length}</span></h2>
            <ul>{asked(c).map((b) => (
              <li key={b.point}><button type="button" className={styles.ball} data-ball={`${c.name} ${b.point}`} data-seen={b.seen ?? "asked"} aria-current={c.name === camera && b.point === point ? "step" : undefined} onClick={() => choose({ camera: c.name, point: b.point })}>
                {b.point}<span className="hidden-words">{b.seen === null ? ", still to be said" : b.seen ? ", found" : ", not seen"}</span><span aria-hidden>{b.seen === null ? "?" : b.seen ? "✓" : "–"}</span></button></li>
            ))}</ul>
          </div>
        ))}
        <p className="soft">Answers are kept in {control.file}, which kinemark calibrate reads; the reference marker, a mark that never moves, in session.toml. It may be left out.</p>
      </aside>
    </div>
  );
}

function Threshold(): React.JSX.Element {
  const { level, white, inverted, camera } = useSessions(), value = level ?? white?.threshold ?? 128;
  const change = (some: { level?: number; inverted?: boolean }): void => (put(some), void fetchWhite());
  return (
    <div className={styles.threshold}>
      <label>Threshold <input type="range" min={0} max={255} step={1} value={value} onChange={(e) => change({ level: Number(e.target.value) })} /> <output className="number">{Math.round(value)}</output></label>
      <label><input type="checkbox" checked={inverted} onChange={(e) => change({ inverted: e.target.checked })} /> black on white</label>
      <span className="soft number">{white ? `${white.centroids.length} markers` : "…"}</span>
      <button type="button" className="button" onClick={() => void keepThreshold(false)}>Keep for {camera}</button>
      <button type="button" className="button" onClick={() => void keepThreshold(true)}>Keep for all</button>
    </div>
  );
}

/** The image with its white pixels, as large as fits. */
function Picture(): React.JSX.Element {
  const { session, camera, control, white, level, inverted, point, spot } = useSessions(), theme = useStore((s) => s.theme);
  const canvas = useRef<HTMLCanvasElement>(null), place = useRef<HTMLDivElement>(null), [image, setImage] = useState<{ of: string; picture: HTMLImageElement } | null>(null), [size, setSize] = useState([1, 1]);
  const address = session ? api.controlImage(session, camera) : "", own = control?.cameras.find((c) => c.name === camera);
  useEffect(() => {
    const picture = new Image();
    picture.onload = (): void => setImage({ of: address, picture });
    picture.src = address;
  }, [address]);
  useEffect(() => {
    const watch = new ResizeObserver(() => setSize([place.current!.clientWidth, place.current!.clientHeight]));
    watch.observe(place.current!);
    return () => watch.disconnect();
  }, []);
  const ready = image?.of === address ? image.picture : null, w = own?.width ?? 1, h = own?.height ?? 1, scale = Math.min(size[0]! / w, size[1]! / h);
  useEffect(() => {
    if (ready && own) paint(canvas.current!, ready, level ?? white?.threshold ?? 256, inverted, spotsOf(white), asked(own), point, spot);
  }, [ready, own, level, white, inverted, point, spot, theme]);
  const click = (e: React.MouseEvent): void => {
    const box = canvas.current!.getBoundingClientRect();
    void answer({ u: ((e.clientX - box.left) / box.width) * w - 0.5, v: ((e.clientY - box.top) / box.height) * h - 0.5 });
  };
  return <div ref={place} className={styles.place}><canvas ref={canvas} data-camera={ready ? camera : ""} data-spot={spotsOf(white)[spot]?.join(" ") ?? ""} style={{ width: w * scale, height: h * scale }} onClick={click} role="img" aria-label={`Image of ${camera}; white pixels are tinted`} /></div>;
}

/** Canvas pixels an image pixel; so that marks are drawn finer than the image. */
const FINE = 3;

function paint(canvas: HTMLCanvasElement, image: HTMLImageElement, level: number, inverted: boolean, centroids: readonly (readonly [number, number])[], balls: readonly { point: string; u?: number | null; v?: number | null }[], point: string, spot: number): void {
  const w = image.naturalWidth, h = image.naturalHeight, c = canvas.getContext("2d")!, p = palette();
  const plain = new OffscreenCanvas(w, h), o = plain.getContext("2d", { willReadFrequently: true })!;
  o.drawImage(image, 0, 0);
  const pixels = o.getImageData(0, 0, w, h), data = pixels.data;
  for (let i = 0; i < data.length; i += 4) if (inverted ? data[i]! < level : data[i]! > level) (data[i] = 90), (data[i + 1] = 235), (data[i + 2] = 190);
  o.putImageData(pixels, 0, 0);
  canvas.width = FINE * w, canvas.height = FINE * h;
  c.imageSmoothingEnabled = false;
  c.drawImage(plain, 0, 0, FINE * w, FINE * h);
  c.fillStyle = "#ffffff";
  for (const [u, v] of centroids) c.fillRect(FINE * (u + 0.5) - 1, FINE * (v + 0.5) - 1, 3, 3);
  const chosen = centroids[spot];
  if (chosen) {
    c.strokeStyle = p.select;
    c.lineWidth = 4;
    c.strokeRect(FINE * (chosen[0] + 0.5) - 26, FINE * (chosen[1] + 0.5) - 26, 52, 52);
  }
  c.font = "bold 30px sans-serif";
  for (const b of balls) {
    if (b.u == null || b.v == null) continue;
    const x = FINE * (b.u + 0.5), y = FINE * (b.v + 0.5);
    c.strokeStyle = c.fillStyle = b.point === point ? p.select : "#ffd166";
    c.lineWidth = 3;
    c.beginPath();
    c.arc(x, y, 22, 0, 7);
    c.stroke();
    c.fillText(b.point, x + 26, y - 14);
  }
}
