/** A calibration target as it is found on the images: rods, wand and grid recognised, the L-frame where the calibration has it. */
import { useEffect, useState } from "react";
import * as api from "../api/targets";
import type { FoundInImage } from "../api/targets";
import { label, type Over } from "../draw/Picture";
import { tried } from "../state/load";
import { useStore } from "../state/store";
import { Asked } from "./Shown";
import { FrameBar } from "./FrameBar";
import { PictureView } from "./PictureView";
import styles from "./FoundTarget.module.css";

/** Colours on images, which are dark in every theme. */
const HERE = "#4ade9a", OTHER = "#8fc7ff";

export function FoundTarget({ id, cameras }: { id: string; cameras: readonly string[] }): React.JSX.Element {
  const returns = useStore((s) => s.returns), [kinds, setKinds] = useState<Record<string, string> | null>(null), [kind, setKind] = useState(""), [camera, setCamera] = useState(cameras[0] ?? ""), [frame, setFrame] = useState(1), [got, setGot] = useState<{ of: string; found: FoundInImage } | null>(null);
  const shown = `${kind} ${camera} ${frame}`, found = got?.of === shown ? got.found : null; // nothing of another image is drawn over this one
  useEffect(() => void tried(() => api.targets(id)).then((got) => got && (setKinds(got.kinds), setKind((now) => now || (Object.keys(got.kinds)[0] ?? "")))), [id, returns]);
  useEffect(() => {
    let gone = false;
    if (kind && camera) void tried(() => api.found(id, kind, camera, frame)).then((one) => void (gone || !one || setGot({ of: `${kind} ${camera} ${frame}`, found: one })));
    return () => void (gone = true);
  }, [id, kind, camera, frame, returns]);
  if (!kinds) return <Asked words="Targets are looked for …" />;
  if (!kind) return <p className={styles.words}>Nothing that calibrates this session has images: its cameras come from a file, or its points were pointed at.</p>;
  return (
    <div className={styles.screen} data-found={found ? shown : ""} data-points={found?.points.length ?? ""}>
      <p className={styles.choose}>
        {Object.entries(kinds).map(([key, words]) => <button key={key} type="button" className="button" aria-pressed={key === kind} onClick={() => (setKind(key), setFrame(1))}>{words}</button>)}
        <label>Camera <select className="field" value={camera} onChange={(e) => setCamera(e.target.value)}>{cameras.map((name) => <option key={name}>{name}</option>)}</select></label>
        <span role="status">{found?.words ?? "It is looked for …"}</span>
      </p>
      <div className={styles.image}><PictureView label={`Image of ${camera}`} address={api.targetImage(id, kind, camera, frame)} tall={1} over={over(found)} /></div>
      {got && got.found.frames > 1 && <FrameBar first={1} last={got.found.frames} frame={frame} go={(f) => setFrame(Math.min(got.found.frames, Math.max(1, Math.round(f))))} />}
    </div>
  );
}

function over(found: FoundInImage | null): Over {
  return (c, to) => {
    if (!found) return;
    for (const [u, v] of found.spots) circle(c, to(u, v), 9, OTHER);
    c.strokeStyle = HERE;
    c.lineWidth = 2;
    for (const [a, b] of found.lines) {
      const p = found.points[a], q = found.points[b];
      if (!p || !q) continue;
      c.beginPath();
      c.moveTo(...to(p.u, p.v));
      c.lineTo(...to(q.u, q.v));
      c.stroke();
    }
    for (const p of found.points) {
      const [x, y] = to(p.u, p.v);
      circle(c, [x, y], 5, HERE);
      if (p.name) label(c, x + 8, y - 6, p.name, HERE);
    }
  };
}

function circle(c: CanvasRenderingContext2D, [x, y]: readonly [number, number], r: number, colour: string): void {
  c.strokeStyle = colour;
  c.lineWidth = 1.5;
  c.beginPath();
  c.arc(x, y, r, 0, 7);
  c.stroke();
}
