/** Names: the marker set as a figure, what automatic labelling proposes, and the lengths of the links. */
import { ArrowLeftRight, Check, Search, Tag } from "lucide-react";
import { useEffect, useRef, useState } from "react";
import * as api from "../api/client";
import type { MarkerSetChoice, MarkerSetRow, Proposal } from "../api/types";
import { Computed } from "../parts/Computed";
import { Figure } from "../parts/Figure";
import { SceneView } from "../parts/views";
import { Waiting } from "../parts/Waiting";
import { byId, LABEL_LIMIT } from "../keys/commands";
import { many, mm, percent } from "../model/format";
import { keptNames, knownNames, labelRows } from "../model/labels";
import { acceptLabels, exchangeSides, sureLabels } from "../state/acts";
import { lookAtTrack, nameTrack } from "../state/labels";
import { refetch, say, tried } from "../state/load";
import { set, useParts, useStore } from "../state/store";
import styles from "./Labels.module.css";

/** Of a file: names alone. */
const NO_SET: MarkerSetRow = { name: "", names: [], places: {}, faces: {}, meaning: {}, links: [] };

export function Labels(): React.JSX.Element {
  const { header, labels } = useStore();
  if (!header) return <Waiting />;
  const known = header.marker_set ? [] : knownNames(header, labels);
  return (
    <div className={styles.screen}>
      <section className={styles.figure} aria-label="Marker set">
        <header className={styles.head}><h1>Labels</h1><Sets key={header.id} /></header>
        {header.marker_set ? <Figure set={header.marker_set} /> : known.length ? <Figure set={{ ...NO_SET, names: known }} /> : header.session_id === null ? <p className={styles.none}>A file has no marker set of its own: choose one above, or take the names that stand in it, that a labelled trial or a template beside it proposes (<kbd>A</kbd>), and that you say (<kbd>L</kbd>).</p> : <p className={styles.none}>Name the tracks of one trial (<kbd>L</kbd>): the others are named by it when they are run, as <code>[label]</code> in session.toml says. A marker set, chosen above, draws its markers here.</p>}
        <Sides />
      </section>
      <section className={styles.tracks} aria-label="Tracks and names">
        <Accept />
        {labels?.by && <p className={styles.by}>Names are proposed by {labels.by}.</p>}
        {labels?.words && <p className={styles.words}>{labels.words}</p>}
        <Proposals />
      </section>
      <section className={`${styles.right} ${header.marker_set ? "" : styles.alone}`} aria-label={header.marker_set ? "View and links" : "View"}>
        <div className={styles.scene}><SceneView /></div>
        {header.marker_set && <Links />}
      </section>
    </div>
  );
}

/** The marker sets that may be chosen; another one is stated in session.toml, of a file beside its journal. */
function Sets(): React.JSX.Element {
  const { id, header, busy } = useParts("id", "header", "busy"), [sets, setSets] = useState<readonly MarkerSetChoice[]>([]), worn = sets.find((one) => one.worn), own = header?.marker_set;
  const head = header?.head, shown = own?.names.join();
  useEffect(() => {
    if (id) void tried(() => api.markerSets(id)).then((got) => got && setSets(got));
  }, [id, head, shown]);
  const choose = async (name: string): Promise<void> => {
    const got = id && (await tried(() => api.wear(id, name || null)));
    if (!got) return;
    setSets(got);
    await refetch();
    say("done", `${name ? `The marker set is ${name}` : "There is no marker set"}${header?.session_id ? ", as session.toml says now; a run names markers by it" : ", also when the studio is opened again"}.`);
  };
  return (
    <label className={styles.set} title={worn?.description}><span className="hidden-words">Marker set</span>
      <select className="field" disabled={busy > 0} value={worn?.name ?? (own ? "own" : "")} onChange={(e) => void choose(e.target.value)}>
        <option value="">no marker set</option>
        {own && !worn && <option value="own" disabled>{own.name || many(own.names.length, "marker")}</option>}
        {sets.map((one) => <option key={one.name} value={one.name} title={one.description}>{one.name} ({one.there} of {one.markers} here)</option>)}
      </select>
    </label>
  );
}

function Sides(): React.JSX.Element | null {
  const { header, labels } = useStore();
  if (!header?.pairs.length) return null;
  return (
    <div className={styles.sides}>
      {labels?.sides && <p>{labels.sides}</p>}
      {header.one_sided.length > 0 && <p className="soft">{keptNames(header.one_sided)}.</p>}
      <button type="button" className="button" onClick={exchangeSides}><ArrowLeftRight size={14} aria-hidden />Exchange left and right<kbd>⇧ X</kbd></button>
    </div>
  );
}

function Accept(): React.JSX.Element {
  const n = useStore(() => sureLabels(LABEL_LIMIT).length), labels = useStore((s) => s.labels), busy = useStore((s) => s.busy > 0);
  return (
    <div className={styles.accept}>
      <h2>Tracks</h2>
      {labels?.can_ask && <button type="button" className="button" disabled={busy} onClick={byId("labels-ask").run}><Search size={14} aria-hidden />Propose names<kbd>A</kbd></button>}
      <button type="button" className="button strong" disabled={!n} onClick={() => acceptLabels(LABEL_LIMIT)}><Check size={14} aria-hidden />Accept {n} of {percent(LABEL_LIMIT)} or more<kbd>⇧ Enter</kbd></button>
    </div>
  );
}

/** Tracks that ask come first: those without a name, then those whose name is unsure. */
function Proposals(): React.JSX.Element {
  const labels = useStore((s) => s.labels), header = useStore((s) => s.header), computed = useStore((s) => s.computed), place = useRef<HTMLDivElement>(null), track = useStore((s) => s.track);
  useEffect(() => void place.current?.querySelector('[aria-current="true"]')?.scrollIntoView({ block: "nearest" }), [track]);
  const rows = header ? labelRows(header, labels, computed) : [];
  return <div ref={place} className={styles.list} tabIndex={0} role="region" aria-label="Names of tracks"><ul>{rows.map((p) => <Row key={p.track} of={p} />)}</ul><Computed /></div>;
}

function Row({ of: p }: { of: Proposal }): React.JSX.Element {
  const on = useStore((s) => s.track === p.track), unnamed = p.track.startsWith("*"), other = p.name !== null && p.name !== p.track, sure = Number.isFinite(p.probability);
  return (
    <li className={styles.row} aria-current={on} data-track={p.track}>
      <button type="button" className={styles.name} onClick={() => lookAtTrack(p.track)}>
        <b>{p.track}</b>
        {!other && unnamed && <span className="soft">no name is proposed</span>}
      </button>
      {sure && <span className={`${styles.sure} number`}><meter min={0} max={1} low={0.6} high={0.9} optimum={1} value={p.probability} aria-label="Probability" />{percent(p.probability)}</span>}
      {p.runner_up && (p.probability < 0.999 || unnamed) && <small className="soft">else {p.runner_up}</small>}
      <span className={styles.acts}>
        {other && p.name && <button type="button" className="button" title={`${p.track} is ${p.name} (Enter)`} onClick={() => void nameTrack(p.name, p.track)}><span aria-hidden>→ </span>{p.name}</button>}
        <button type="button" className="icon-button" aria-label={`Another name for ${p.track}`} title="Another name (L)" onClick={() => set({ track: p.track, selected: [p.track], dialog: "name" })}><Tag size={14} aria-hidden /></button>
      </span>
    </li>
  );
}

const LINK = { steady: "steady", stretched: "stretched", bends: "over a joint", unknown: "seen too little" };

function Links(): React.JSX.Element {
  const labels = useStore((s) => s.labels), links = [...(labels?.links ?? [])].sort((a, b) => Number(b.state === "stretched") - Number(a.state === "stretched"));
  return (
    <div className={styles.links} tabIndex={0} role="region" aria-label="Lengths of links">
      <table>
        <thead><tr><th scope="col">Link</th><th scope="col">Length</th><th scope="col">Stated</th><th scope="col">State</th></tr></thead>
        <tbody>
          {links.map((l) => (
            <tr key={`${l.a} ${l.b}`} className={l.state === "stretched" ? styles.stretched : ""}>
              <th scope="row"><button type="button" className={styles.link} onClick={() => set((s) => ({ selected: [l.a, l.b], focused: s.focused + 1 }))}>{l.a} – {l.b}</button></th><td className="number">{mm(l.mean_mm)} ± {mm(l.sd_mm)} mm</td><td className="number">{l.stated_mm === null ? "–" : `${mm(l.stated_mm)} mm`}</td><td>{l.state === "stretched" ? <b>stretched</b> : LINK[l.state]}</td>
            </tr>
          ))}
        </tbody>
      </table>
      {labels && !links.length && <p className="soft">There are no links between markers that are there.</p>}
    </div>
  );
}
