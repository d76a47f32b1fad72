import { Loader2 } from "lucide-react";
import { useStore } from "../state/store";
import { goTo } from "../state/load";
import * as api from "../api/client";
import { tried } from "../state/load";
import styles from "./Waiting.module.css";

/** While a trial is read; and where it cannot be, what to do. */
export function Waiting(): React.JSX.Element {
  const { busy, note, unshown, runs, id, jobs } = useStore(), job = id ? jobs[id] : undefined;
  if (busy && !job) return <div className={styles.waiting}><h1 className="hidden-words">Reading the trial</h1><Loader2 className={styles.spin} aria-hidden /><p>Reading the trial …</p></div>;
  return (
    <div className={styles.waiting}>
      <h1>{runs ? "This trial cannot be shown yet" : "This file cannot be shown"}</h1>
      <p>{job?.state === "running" ? `${job.stage || "Running"} ${Math.round(100 * (job.progress ?? 0))} % ${job.words}` : unshown || note?.words}</p>
      <div>
        {runs && <><button type="button" className="button strong" disabled={job?.state === "running"} onClick={() => void tried(() => api.run(id!))}>Run it</button>{" "}</>}
        <button type="button" className="button" onClick={() => goTo("home")}>Home</button>
      </div>
    </div>
  );
}
