/** The editor: the trial in space, in its images and over time, and the list of what is probably wrong with it. */
import { CamerasView, CurvesView, SceneView } from "../parts/views";
import { Inspector } from "../parts/Inspector";
import { ProblemList } from "../parts/ProblemList";
import { Splitter } from "../parts/Splitter";
import { Waiting } from "../parts/Waiting";
import { useStore } from "../state/store";
import styles from "./Tracks.module.css";

export function Tracks(): React.JSX.Element {
  const layout = useStore((s) => s.layout), header = useStore((s) => s.header), cameras = (header?.cameras.length ?? 0) > 0;
  if (!header) return <Waiting />;
  const seen = layout === 1 ? (cameras ? "all" : "plain") : layout === 2 ? "scene" : layout === 3 ? "cameras" : "curves";
  return (
    <div className={styles.screen}>
      <h1 className="hidden-words">Tracks of {header.name}</h1>
      <div className={styles.areas} data-layout={seen}>
        {seen !== "cameras" && seen !== "curves" && <div className={styles.scene}><SceneView /></div>}
        {seen === "all" && <Splitter name="across" label="Width of the view" upright least={20} most={80} start={44} />}
        {(seen === "all" || seen === "cameras") && <div className={styles.cameras}><CamerasView /></div>}
        {(seen === "all" || seen === "plain") && <Splitter name="down" label="Height of the curves" upright={false} least={25} most={80} start={56} />}
        {(seen === "all" || seen === "plain" || seen === "curves") && <div className={styles.curves}><CurvesView /></div>}
      </div>
      <aside className={styles.side} aria-label="Problems and selection">
        <ProblemList />
        <Inspector />
      </aside>
    </div>
  );
}
