import { ChevronFirst, ChevronLast, Pause, Play, StepBack, StepForward, ZoomIn, ZoomOut } from "lucide-react";
import { useEffect, useRef, useState, useSyncExternalStore } from "react";
import { Lanes } from "../draw/Lanes";
import { byId } from "../keys/commands";
import { clock } from "../model/format";
import { lookAt } from "../state/acts";
import { get, playhead, set, useStore, useParts, useShownPaths } from "../state/store";
import styles from "./Transport.module.css";

/** The time bar of what is open: playing, the frame, and the lanes of all markers. */
export function Transport(): React.JSX.Element {
  return (
    <section className={styles.bar} aria-label="Time">
      <div className={styles.keys}>
        <Frame />
        <div className={styles.buttons}>
          <Button label="First frame (Home)" icon={ChevronFirst} run={() => playhead.go(playhead.first)} />
          <Button label="1 frame back (←)" icon={StepBack} run={() => playhead.step(-1)} />
          <PlayButton />
          <Button label="1 frame on (→)" icon={StepForward} run={() => playhead.step(1)} />
          <Button label="Last frame (End)" icon={ChevronLast} run={() => playhead.go(playhead.last)} />
        </div>
        <Legend />
      </div>
      <LanesView />
    </section>
  );
}

function Button({ label, icon: Icon, run }: { label: string; icon: typeof Play; run: () => void }): React.JSX.Element {
  return <button type="button" className="icon-button" aria-label={label} title={label} onClick={run}><Icon size={16} aria-hidden /></button>;
}

function PlayButton(): React.JSX.Element {
  const playing = useSyncExternalStore((done) => playhead.onState(done), () => playhead.playing);
  return <Button label={playing ? "Pause (Space)" : "Play (Space)"} icon={playing ? Pause : Play} run={() => playhead.toggle()} />;
}

/** The clock and the frame; written past React, as often as the screen is drawn. */
function Frame(): React.JSX.Element {
  const time = useRef<HTMLSpanElement>(null), field = useRef<HTMLInputElement>(null);
  useEffect(() => {
    const off = playhead.on((frame) => {
      time.current!.textContent = clock((frame - 1) / playhead.rate);
      if (document.activeElement !== field.current) field.current!.value = String(frame);
    });
    playhead.draw();
    return off;
  }, []);
  const entered = (e: React.KeyboardEvent<HTMLInputElement>): void => {
    if (e.key !== "Enter" || !Number(e.currentTarget.value)) return;
    playhead.go(Number(e.currentTarget.value));
    e.currentTarget.blur();
  };
  const last = useStore((s) => (s.header ? s.header.first_frame + s.header.n_frames - 1 : 0));
  return (
    <div className={styles.frame}>
      <div className={styles.top}><span ref={time} className={styles.clock} /><Button label="Wider (Ctrl ↓, wheel)" icon={ZoomOut} run={byId("wider").run} /><Button label="Closer (Ctrl ↑, wheel)" icon={ZoomIn} run={byId("closer").run} /></div>
      <label>f <input ref={field} className={styles.field} inputMode="numeric" aria-label="Frame" defaultValue="1" onKeyDown={entered} /> <span className="soft">/ {last}</span></label>
    </div>
  );
}

const Legend = (): React.JSX.Element => (
  <ul className={styles.legend} aria-label="Colours of samples">
    <li><i className={styles.measured} />measured</li>
    <li><i className={styles.filled} />filled</li>
    <li><i className={styles.edited} />edited</li>
    <li><i className={styles.missing} />missing</li>
  </ul>
);

function LanesView(): React.JSX.Element {
  const place = useRef<HTMLDivElement>(null), [lanes, setLanes] = useState<Lanes | null>(null);
  const paths = useShownPaths(), { header, problems, selected, first, last, problem, span } = useParts("header", "problems", "selected", "first", "last", "problem", "span");
  useEffect(() => {
    const made = new Lanes(place.current!);
    made.onFrame = (frame): void => (playhead.pause(), playhead.go(frame));
    made.onSelect = (name, more): void => set((s) => ({ selected: more ? [...s.selected.filter((n) => n !== name), name] : [name] }));
    made.onStretch = (a, b): void => set({ first: a, last: b });
    made.onSpan = (shown): void => set({ span: shown });
    made.onProblem = (id): void => {
      const found = get().problems?.problems.find((p) => p.id === id);
      if (found && get().screen === "tracks") lookAt(found);
    };
    const off = playhead.on((frame) => made.show(frame));
    setLanes(made);
    return () => (off(), made.dispose());
  }, []);
  useEffect(() => {
    if (lanes && header && paths) lanes.set(header, paths, problems?.problems ?? [], problems?.worth_looking ?? 0);
  }, [lanes, header, paths, problems]);
  useEffect(() => lanes?.mark({ selected, first, last, problem, span }), [lanes, selected, first, last, problem, span]);
  return <div ref={place} className={styles.lanes} data-span={span?.join("–") ?? ""} />;
}
