/** The marker set as one who stands, from the front and from the back; which markers are there, and which is selected. */
import { RotateCw } from "lucide-react";
import { useMemo, useState } from "react";
import type { MarkerSetRow } from "../api/types";
import { lookAtTrack, nameTrack } from "../state/labels";
import { get, useStore } from "../state/store";
import styles from "./Figure.module.css";

/** Of the body's height; chosen to fill two views of 100 × 220. */
const SCALE = 196, MIDDLE = 50, FLOOR = 208;
/** As the report draws the body (kinemark/report/marker_figure.py): width, and places to the left and up. */
const LIMBS: readonly (readonly [number, readonly (readonly [number, number])[]])[] = [
  [0.085, [[0.05, 0.5], [0.07, 0.29], [0.085, 0.05]]], [0.05, [[0.07, 0.29], [0.085, 0.045], [0.098, 0.022]]], [0.052, [[0.112, 0.79], [0.15, 0.635]]],
  [0.042, [[0.15, 0.635], [0.187, 0.49], [0.203, 0.44]]], [0.06, [[0, 0.8], [0, 0.9]]],
];
const TRUNK: readonly (readonly [number, number])[] = [[0.125, 0.812], [0.1, 0.64], [0.105, 0.5], [0, 0.47]];

export function Figure({ set }: { set: MarkerSetRow }): React.JSX.Element {
  const [back, setBack] = useState(false), placed = set.names.filter((name) => set.places[name]), rest = set.names.filter((name) => !set.places[name]);
  return (
    <div className={styles.figure}>
      {placed.length > 0 && <button type="button" className={`button ${styles.turn}`} onClick={() => setBack(!back)}><RotateCw size={13} aria-hidden />From the {back ? "front" : "back"}</button>}
      {placed.length > 0 && <div className={styles.views} data-back={back}>{(["front", "back"] as const).map((view) => <View key={view} set={set} view={view} />)}</div>}
      {rest.length > 0 && <ul className={styles.rest}>{rest.map((name) => <li key={name}><Name name={name} /></li>)}</ul>}
      <Counts set={set} />
    </div>
  );
}

function Counts({ set }: { set: MarkerSetRow }): React.JSX.Element {
  const tracks = useStore((s) => s.header?.tracks), there = new Set(tracks?.filter((t) => t.samples > 0).map((t) => t.name)), missing = set.names.filter((name) => !there.has(name));
  return <p className={styles.counts}><i className={styles.there} />{set.names.length - missing.length} there{missing.length > 0 && <><i className={styles.absent} />{missing.length} without a track: {missing.slice(0, 8).join(", ")}{missing.length > 8 && " …"}</>}</p>;
}

function View({ set, view }: { set: MarkerSetRow; view: "front" | "back" }): React.JSX.Element {
  const tracks = useStore((s) => s.header?.tracks), selected = useStore((s) => s.selected), there = useMemo(() => new Set(tracks?.filter((t) => t.samples > 0).map((t) => t.name)), [tracks]);
  const side = view === "front" ? 1 : -1; // seen from the front, the subject's left is on the right
  const at = (left: number, up: number): [number, number] => [MIDDLE + side * left * SCALE, FLOOR - up * SCALE];
  const line = (points: readonly (readonly [number, number])[], flip: number): string => points.map(([l, u]) => at(flip * l, u).map((v) => v.toFixed(1)).join(",")).join(" ");
  const shown = set.names.filter((name) => set.places[name] && (set.faces[name] === undefined || set.faces[name] === "both" || set.faces[name] === view));
  const x = (name: string): number => at(set.places[name]![1], 0)[0], lefts = spread(shown.filter((n) => x(n) < MIDDLE - 0.1), set, FLOOR), rights = spread(shown.filter((n) => x(n) >= MIDDLE - 0.1), set, FLOOR);
  return (
    <svg viewBox="-32 0 164 222" className={styles.view} role="group" aria-label={`From the ${view}`}>
      <g className={styles.body}>
        {[1, -1].flatMap((flip) => LIMBS.map(([width, points], i) => <polyline key={`${flip} ${i}`} points={line(points, flip)} strokeWidth={width * SCALE} />))}
        <polygon points={`${line(TRUNK, 1)} ${line([...TRUNK].reverse(), -1)}`} />
        <ellipse cx={MIDDLE} cy={FLOOR - 0.93 * SCALE} rx={0.052 * SCALE} ry={0.068 * SCALE} />
      </g>
      {[...lefts, ...rights].map(({ name, y }) => {
        const [px, py] = at(set.places[name]![1], set.places[name]![2]), left = px < MIDDLE - 0.1, tx = left ? -8 : 108, on = selected.includes(name);
        return (
          <g key={name} className={`${styles.marker} ${there.has(name) ? styles.there : styles.absent} ${on ? styles.on : ""}`} onClick={() => chosen(name)}>
            <title>{set.meaning[name] ?? name}</title>
            <line x1={left ? tx + 1 : tx - 1} y1={y - 1.6} x2={px} y2={py} />
            <circle cx={px} cy={py} r={2.4} />
            <text x={tx} y={y} textAnchor={left ? "end" : "start"}>{name}</text>
          </g>
        );
      })}
      <text x={MIDDLE} y={220} className={styles.caption} textAnchor="middle">{view}</text>
    </svg>
  );
}

/** Names below one another, none over another. */
function spread(names: readonly string[], set: MarkerSetRow, floor: number): { name: string; y: number }[] {
  const rows = [...names].sort((a, b) => set.places[b]![2] - set.places[a]![2]).map((name) => ({ name, y: floor - set.places[name]![2] * SCALE + 2 }));
  const least = Math.min(6.6, 200 / Math.max(1, rows.length));
  for (let i = 1; i < rows.length; i++) rows[i]!.y = Math.max(rows[i]!.y, rows[i - 1]!.y + least);
  const over = (rows.at(-1)?.y ?? 0) - 212;
  for (let i = rows.length - 1, bound = 212; over > 0 && i >= 0; i--, bound -= least) rows[i]!.y = Math.min(rows[i]!.y, bound);
  return rows;
}

/** A marker of the figure: selected where it is there; else the name of the track that is asked about. */
function chosen(name: string): void {
  const { header, selected } = get(), track = header?.tracks.find((t) => t.name === name && t.samples > 0);
  if (track) lookAtTrack(name);
  else if (selected[0]?.startsWith("*")) void nameTrack(name, selected[0]);
}

/** A marker that has no place on the figure. */
function Name({ name }: { name: string }): React.JSX.Element {
  const there = useStore((s) => s.header?.tracks.some((t) => t.name === name && t.samples > 0)), on = useStore((s) => s.selected.includes(name));
  return <button type="button" className={`button ${styles.name} ${there ? "" : styles.free}`} aria-pressed={on} title={there ? `Look at ${name}` : `No track is ${name} yet: a click names the selected track so`} onClick={() => chosen(name)}>{name}</button>;
}
