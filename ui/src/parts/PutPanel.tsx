import { useEffect, useRef, useState } from "react";
import { putHere } from "../state/acts";
import { get, playhead, set, useStore } from "../state/store";
import styles from "./PutPanel.module.css";

const AXES = ["X", "Y", "Z"] as const;

/** Where the marker would be now: its sample, else the way to fill that is shown, else between its neighbours in time. */
function guess(): [string, string, string] {
  const { paths, selected, candidates, method } = get(), path = paths?.byName.get(selected[0] ?? ""), i = playhead.frame - (paths?.firstFrame ?? 0);
  const shown = candidates?.candidates.find((c) => c.method === method)?.xyz[playhead.frame - (candidates?.first ?? 0)];
  if (shown) return shown.map((v) => v.toFixed(1)) as [string, string, string];
  if (!path) return ["", "", ""];
  let a = i, b = i;
  while (a >= 0 && !path.origin[a]) a--;
  while (b < path.origin.length && !path.origin[b]) b++;
  const at = (j: number, k: number): number => path.xyz[3 * j + k]!, share = b > a ? (i - a) / (b - a) : 0;
  const one = a < 0 ? b : a, other = b >= path.origin.length ? one : b;
  return [0, 1, 2].map((k) => (at(one, k) + share * (at(other, k) - at(one, k))).toFixed(1)) as [string, string, string];
}

/** A place for the selected marker: by X, Y and Z separately, or by clicks in two images or more. */
export function PutPanel(): React.JSX.Element {
  const [xyz, setXyz] = useState(guess), { clicks, selected, header } = useStore(), frame = useRef<HTMLElement>(null), numbers = xyz.map(Number) as [number, number, number];
  useEffect(() => playhead.on((f) => (frame.current!.textContent = String(f))), []);
  const fine = xyz.every((text) => text.trim() !== "" && Number.isFinite(Number(text))), clicked = clicks?.length ?? 0;
  const change = (k: number, text: string): void => setXyz((now) => now.map((old, j) => (j === k ? text : old)) as typeof now);
  return (
    <form className={styles.put} onSubmit={(e) => (e.preventDefault(), fine && putHere(numbers))} aria-label="Put a point">
      <h3>Put {selected[0]} in frame <b ref={frame}>{playhead.frame}</b></h3>
      <div className={styles.axes}>
        {AXES.map((axis, k) => <label key={axis}>{axis}<input className="field" autoFocus={k === 0} inputMode="decimal" value={xyz[k]} onChange={(e) => change(k, e.target.value)} aria-label={`${axis} in mm`} /></label>)}
        <button className="button strong" disabled={!fine}>Put</button>
      </div>
      {header && header.cameras.length > 1 && (
        <p>or click it in two images: {clicked ? clicks!.map((c) => c.camera).join(", ") : "none yet"}{" "}
          <button type="button" className="button" disabled={clicked < 2} onClick={() => putHere(null)}>Put where they meet</button>{" "}
          {clicked > 0 && <button type="button" className="button" onClick={() => set({ clicks: [] })}>Anew</button>}
        </p>
      )}
    </form>
  );
}
