import * as api from "../api/client";
import type { TrialHeader } from "../api/types";
import { count, many } from "../model/format";
import { act } from "../state/acts";
import { runTrial, say, tried } from "../state/load";
import { get, set, useStore } from "../state/store";
import { Modal } from "./Modal";
import styles from "./Modal.module.css";

/** Write a file of the trial as it is, that of a session's by a run; nothing that was given is written over. */
export async function write(): Promise<void> {
  const { id, header } = get();
  if (!id || !header) return;
  if (header.session_id && header.stale) return runTrial();
  const written = await tried(() => api.exportTrial(id));
  if (written) say("done", [`Written: ${written.name}`, ...written.words].join(". "));
}

/** The frames that all named markers reach, of how many. */
function common(header: TrialHeader | null): string {
  const named = header?.tracks.filter((t) => t.named && !t.computed && t.first != null && t.last != null) ?? [];
  const first = Math.max(...named.map((t) => t.first!)), last = Math.min(...named.map((t) => t.last!));
  return named.length && first <= last ? ` (${first}–${last}: ${count(last - first + 1)} of ${count(header!.n_frames)})` : "";
}

export function Finish(): React.JSX.Element {
  const { header, problems } = useStore(), unnamed = header?.tracks.filter((t) => !t.named).length ?? 0, left = problems?.errors;
  const finish = async (e: React.FormEvent): Promise<void> => {
    e.preventDefault();
    set({ dialog: null });
    if (await act({ kind: "finish" }, "Finished")) await write();
  };
  return (
    <Modal title="Finish the trial">
      <form className={styles.body} onSubmit={(e) => void finish(e)}>
        <p>{unnamed ? `${many(unnamed, "track")} without a name ${unnamed === 1 ? "is" : "are"} left out` : "Every track has a name"}, all markers begin and end at the frames that all of them have{common(header)}, and a C3D is written beside the trial. One act: Ctrl+Z takes it back.</p>
        {left != null && <p>Errors expected: <b>{left.toFixed(1)}</b>.</p>}
        <div className={styles.actions}>
          <button type="button" className="button" onClick={() => (set({ dialog: null }), void write())}>Only write</button>
          <button className="button strong" autoFocus>Finish and write</button>
        </div>
      </form>
    </Modal>
  );
}
