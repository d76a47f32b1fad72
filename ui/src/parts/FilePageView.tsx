import { useEffect, useRef, useState } from "react";
import { Flat, type Dot, type Place } from "../draw/Flat";
import { palette } from "../draw/palette";
import { useStore } from "../state/store";
import { fetchPage, turnPage, useMenu } from "../state/um2as";
import { Asked } from "./Shown";
import { FrameBar } from "./FrameBar";
import styles from "./FilePageView.module.css";

/** mm in a cm, which the files have; mm about the markers of the first frame, in which they move. Chosen. */
const CM = 10, ABOUT = 250;

/** A file of UM²AS frame by frame: its numbers, and places also in space. */
export function FilePageView({ files }: { files: readonly string[] }): React.JSX.Element {
  const page = useMenu((g) => g.page);
  if (!page) return <Asked words="The file is read …" />;
  const spatial = page.name.endsWith(".tdc");
  return (
    <div className={styles.view} data-file={page.name} data-frame={page.frame}>
      {files.length > 1 && <div className={styles.files} role="group" aria-label="Files">{files.map((name) => <button key={name} type="button" className="button" aria-pressed={name === page.name} onClick={() => void fetchPage(page.frame, name)}>{name}</button>)}</div>}
      {page.frames > 1 && <FrameBar first={1} last={page.frames} frame={page.frame} go={(f) => void fetchPage(f)}><span className={styles.turn}><button type="button" className="button" disabled={page.frame === 1} onClick={() => turnPage(-1)}>Back<kbd>⌫</kbd></button><button type="button" className="button" disabled={page.frame === page.frames} onClick={() => turnPage(1)}>Next<kbd>Space</kbd></button></span></FrameBar>}
      <div className={styles.both}>
        <table>
          <caption className="hidden-words">{page.name}{page.frames > 1 ? `, frame ${page.frame} of ${page.frames}` : ""}</caption>
          <thead><tr>{page.head.map((cell) => <th key={cell} scope="col">{cell}</th>)}</tr></thead>
          <tbody>{page.rows.map((row, i) => <tr key={i}>{row.map((cell, k) => <td key={k} className="number">{cell === null ? <span className="soft" title="not there">999</span> : Number.isInteger(cell) && k === 0 ? cell : cell.toFixed(page.head[0] === "L" ? 7 : 2)}</td>)}</tr>)}</tbody>
        </table>
        {spatial && <Space />}
      </div>
    </div>
  );
}

const wider = ([x, y, z]: Place, by: number): Place => [x + by, y + by, z + by];

function Space(): React.JSX.Element {
  const canvas = useRef<HTMLCanvasElement>(null), [flat, setFlat] = useState<Flat | null>(null), page = useMenu((g) => g.page)!, theme = useStore((s) => s.theme), placed = useRef("");
  useEffect(() => {
    const made = new Flat(canvas.current!);
    setFlat(made);
    return () => made.dispose();
  }, []);
  useEffect(() => {
    if (!flat) return;
    const p = palette(), dots = page.rows.flatMap((row): Dot[] => (row[1] == null || row[2] == null || row[3] == null ? [] : [{ at: [CM * row[1], CM * row[2], CM * row[3]], colour: p.measured, size: 5, words: String(row[0]) }]));
    const end = (pick: (a: number, b: number) => number): Place => dots.map((dot) => dot.at).reduce((a, b) => [pick(a[0], b[0]), pick(a[1], b[1]), pick(a[2], b[2])], dots[0]?.at ?? [0, 0, 0]);
    if (placed.current !== page.name && dots.length) flat.frame(wider(end(Math.min), -ABOUT), wider(end(Math.max), ABOUT)), (placed.current = page.name);
    flat.show([], dots);
  }, [flat, page, theme]);
  return <canvas ref={canvas} className={styles.space} role="img" aria-label={`Markers of frame ${page.frame} in space; drag to turn`} />;
}
