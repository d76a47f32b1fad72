import { useState } from "react";
import * as api from "../api/client";
import type { TrialHeader } from "../api/types";
import { count, many } from "../model/format";
import { ends, marked, usual } from "../model/finish";
import { gapsOf, leftOpen } from "../model/paths";
import { act } from "../state/acts";
import { goTo, runTrial, say, tried } from "../state/load";
import { get, set, useStore } from "../state/store";
import { Modal } from "./Modal";
import styles from "./Modal.module.css";

/** Write a file of the trial as it is, that of a session's by a run; nothing that was given is written over. */
export async function write(): Promise<void> {
  const { id, header } = get();
  if (!id || !header) return;
  if (header.session_id && header.stale) return runTrial();
  say("news", "The file is being written …"); // gaps are filled anew for it, which takes seconds where there are many
  const written = await tried(() => api.exportTrial(id));
  if (written) say("done", [`Written: ${written.name}`, ...written.words.map((one) => one.charAt(0).toUpperCase() + one.slice(1))].join(". "));
}

/** Why all markers are cut to these frames, and which two they are of. */
function Common({ header }: { header: TrialHeader | null }): React.JSX.Element | null {
  const all = ends(header);
  if (!header || !all.length) return null;
  const late = all.reduce((a, b) => (b.first > a.first ? b : a)), soon = all.reduce((a, b) => (b.last < a.last ? b : a)), n = soon.last - late.first + 1;
  if (n > 0) return <p className="soft">All markers are there from frame {late.first} to {soon.last}: {count(n)} of {count(header.n_frames)}.</p>;
  return <p>There are no frames that all markers have: <b>{late.name}</b> begins in frame {late.first} and <b>{soon.name}</b> ends in {soon.last}. Name the pieces that are missing, or say from where to where.</p>;
}

/** Gaps that the file would have. */
function Open({ header }: { header: TrialHeader | null }): React.JSX.Element | null {
  const { paths, gaps: known } = useStore();
  const { gaps, markers } = known ? leftOpen(known.gaps) : gapsOf((header?.tracks ?? []).flatMap((t) => (t.named && !t.computed && paths?.byName.has(t.name) ? [paths.byName.get(t.name)!] : [])));
  if (!gaps) return null;
  return <p><b>{many(gaps, "gap")}</b> of {many(markers, "marker")} {gaps === 1 ? "is" : "are"} not filled, and will be in the file: <button type="button" className="button" onClick={() => (set({ dialog: null }), goTo("gaps"))}>look at gaps</button>.</p>;
}

export function Finish(): React.JSX.Element {
  const { header, problems, first, last, gap } = useStore(), own = marked(first, last, gap), unnamed = header?.tracks.filter((t) => !t.named).length ?? 0, left = problems?.errors;
  const [low, high] = header ? usual(header, own) : [1, 1], [from, setFrom] = useState(low), [to, setTo] = useState(high);
  const finish = async (e: React.FormEvent): Promise<void> => {
    e.preventDefault();
    set({ dialog: null });
    if (await act({ kind: "finish", first: from, last: to }, "Finished")) await write();
  };
  const frame = (value: number, change: (n: number) => void, label: string): React.JSX.Element => <input className="field" type="number" aria-label={label} min={header?.first_frame} max={header ? header.first_frame + header.n_frames - 1 : 1} value={value} onChange={(e) => change(Number(e.target.value))} />;
  return (
    <Modal title="Finish the trial">
      <form className={styles.body} onSubmit={(e) => void finish(e)}>
        <p>{unnamed ? `${many(unnamed, "track")} without a name ${unnamed === 1 ? "is" : "are"} left out` : "Every track has a name"}, all markers begin and end at these frames, and a C3D is written beside the trial. One act: Ctrl+Z takes it back.</p>
        <p>Frames {frame(from, setFrom, "First frame that is left")} to {frame(to, setTo, "Last frame that is left")}</p>
        {(own[0] ?? own[1]) !== null && <p className="soft">This is the stretch that is marked.</p>}
        <Common header={header} />
        <Open header={header} />
        {left != null && <p>Errors expected: <b>{left.toFixed(1)}</b>.</p>}
        <div className={styles.actions}>
          <button type="button" className="button" onClick={() => (set({ dialog: null }), void write())}>Only write</button>
          <button className="button strong" autoFocus>Finish and write</button>
        </div>
      </form>
    </Modal>
  );
}
