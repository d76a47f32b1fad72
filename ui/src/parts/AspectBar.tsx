/** The aspect ratio of pixels: a recording of the bar is chosen, what it says of each camera is shown, then stated. */
import { Ruler } from "lucide-react";
import { useEffect, useState } from "react";
import * as api from "../api/um2as";
import type { Bars, BarMeasured } from "../api/um2as";
import { say, tried } from "../state/load";
import { useStore } from "../state/store";
import { fetchMenu, useMenu } from "../state/um2as";
import { Asked } from "./Shown";
import styles from "./AspectBar.module.css";

export function AspectBar(): React.JSX.Element {
  const session = useMenu((g) => g.session)!, returns = useStore((s) => s.returns), [bars, setBars] = useState<Bars | null>(null), [images, setImages] = useState(""), [threshold, setThreshold] = useState(""), [found, setFound] = useState<BarMeasured | null>(null), [busy, setBusy] = useState(false);
  useEffect(() => void tried(() => api.bars(session)).then((got) => got && (setBars(got), setImages((now) => now || (got.images.find((one) => /bar/i.test(one)) ?? got.images[0] ?? "")))), [session, returns]);
  if (!bars) return <Asked words="Recordings are looked for …" />;
  const measure = async (): Promise<void> => {
    setBusy(true);
    setFound(await tried(() => api.bar(session, images, threshold.trim() ? Number(threshold) : null)));
    setBusy(false);
  };
  const state = async (value: number | null): Promise<void> => {
    const got = await tried(() => api.factor(session, value));
    if (!got) return;
    setBars(got);
    await fetchMenu();
    say("done", value === null ? "Pixels count as square." : `V is multiplied by ${value} in all files that are written from now on: process and save them again.`);
  };
  if (!bars.images.length) return <p>No recording of all cameras is in the session's folder. Put in images of the bar, called as bar_cam1.mkv, or a folder bar_cam1 of pictures.</p>;
  return (
    <>
      <p className={styles.line}>
        <label>Recording of the bar <select className="field" value={images} onChange={(e) => setImages(e.target.value)}>{bars.images.map((one) => <option key={one}>{one}</option>)}</select></label>
        <label>Threshold <input className={`field ${styles.short}`} inputMode="decimal" placeholder="by image" value={threshold} onChange={(e) => setThreshold(e.target.value)} /></label>
        <button type="button" className="button strong" disabled={busy} onClick={() => void measure()}><Ruler size={14} aria-hidden />Measure</button>
      </p>
      {busy && <p role="status">The bar is measured …</p>}
      {found && !busy && (
        <>
          <ul className={styles.rows}>{found.cameras.map((one) => <li key={one.camera} data-camera={one.camera} data-factor={one.factor ?? ""}><b>{one.camera}</b> {one.words}</li>)}</ul>
          {found.factor !== null && <p><button type="button" className="button strong" onClick={() => void state(found.factor)}>Multiply V by {found.factor}</button></p>}
        </>
      )}
      {bars.factor !== null && <p>V is multiplied by <b className="number">{bars.factor}</b> now. <button type="button" className="button" onClick={() => void state(null)}>Take it away</button></p>}
    </>
  );
}
