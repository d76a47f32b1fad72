import { ChevronFirst, ChevronLast, StepBack, StepForward } from "lucide-react";
import styles from "./FrameBar.module.css";

interface Props { first: number; last: number; frame: number; go: (frame: number) => void; children?: React.ReactNode }

/** The controls of a recorder, frame by frame. */
export function FrameBar({ first, last, frame, go, children }: Props): React.JSX.Element {
  const entered = (e: React.KeyboardEvent<HTMLInputElement>): void => {
    if (e.key !== "Enter" || !Number(e.currentTarget.value)) return;
    go(Number(e.currentTarget.value));
    e.currentTarget.blur();
  };
  const buttons = [
    ["First frame", ChevronFirst, first], ["1 frame back (←)", StepBack, frame - 1], ["1 frame on (→)", StepForward, frame + 1], ["Last frame", ChevronLast, last],
  ] as const;
  return (
    <section className={styles.bar} aria-label="Frames">
      {buttons.map(([label, Icon, to]) => <button key={label} type="button" className="icon-button" aria-label={label} title={label} onClick={() => go(to)}><Icon size={16} aria-hidden /></button>)}
      <label className="number">f <input key={frame} className={styles.field} inputMode="numeric" aria-label="Frame" defaultValue={frame} onKeyDown={entered} /> <span className="soft">/ {last}</span></label>
      <input type="range" className={styles.slider} aria-label="Frame, slider" min={first} max={last} value={frame} onChange={(e) => go(Number(e.target.value))} />
      {children}
    </section>
  );
}
