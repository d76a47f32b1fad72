/** The drawing classes in their places: what they show follows the store, the frame follows the playhead. */
import { useEffect, useRef, useState } from "react";
import { Cameras } from "../draw/Cameras";
import { Curves, type Curve } from "../draw/Curves";
import { LARGER, Scene } from "../draw/Scene";
import { palette } from "../draw/palette";
import type { Side } from "../draw/orbit";
import { mm, wayOf } from "../model/format";
import { zoomed } from "../model/lanes";
import { besideCurves, candidatePath, hasSd, joined, SHOWN, whole, type Path } from "../model/paths";
import { currentProblem, get, playhead, set, useParts, useSeen, useShownPaths, useStore, watched, type State } from "../state/store";
import { wantDetections } from "../state/load";
import { Computed } from "./Computed";
import styles from "./views.module.css";

const SIDES: readonly Side[] = ["oblique", "side", "front", "top"];
const redraw = (): void => playhead.draw();

function pick(name: string | null, more: boolean): void {
  if (!name) return;
  set((s) => ({ selected: more ? [...s.selected.filter((n) => n !== name), name] : [name], instead: more ? s.instead : null }));
}

/** What is drawn beside what is: a proposal, or the way to fill that is shown. */
function insteadOf(s: State): readonly Path[] {
  if (s.screen === "tracks") return s.instead && s.instead.problem === s.problem ? s.instead.paths : [];
  if (s.screen !== "gaps") return [];
  const one = s.candidates?.candidates.find((c) => c.method === s.method);
  return one && s.candidates ? whole([candidatePath(s.candidates.marker, one.xyz, one.sd)], s.candidates.first, s.paths) : [];
}

export function SceneView(): React.JSX.Element {
  const canvas = useRef<HTMLCanvasElement>(null), over = useRef<HTMLCanvasElement>(null), [scene, setScene] = useState<Scene | null>(null), [failed, setFailed] = useState("");
  const s = useSeen(), paths = useShownPaths(), { header, selected, alone, bands, side, focused } = s, instead = insteadOf(s);
  useEffect(() => {
    let made: Scene;
    try {
      made = new Scene(canvas.current!, over.current!, redraw);
    } catch (error) {
      return setFailed(String(error));
    }
    made.onPick = pick;
    const off = playhead.on((frame) => made.show(frame)), watch = new ResizeObserver(redraw);
    watch.observe(canvas.current!);
    setScene(made);
    return () => (off(), watch.disconnect(), made.dispose());
  }, []);
  useEffect(() => void (scene && header && paths && scene.set(header, paths)), [scene, header, paths]);
  useEffect(() => scene?.with({ selected, alone, ellipsoids: bands, instead }), [scene, selected, alone, bands, s.instead, s.candidates, s.method, s.screen]);
  useEffect(() => void (side || scene?.orbit.azimuth ? scene?.side(SIDES[side]!) : null), [scene, side]);
  useEffect(() => void (scene && focused && scene.focus(watched(get()), playhead.frame)), [scene, focused]);
  const turn = (e: React.KeyboardEvent): void => {
    const by = { ArrowLeft: [0.1, 0], ArrowRight: [-0.1, 0], ArrowUp: [0, 0.1], ArrowDown: [0, -0.1] }[e.key];
    if (e.altKey && by) e.preventDefault(), e.stopPropagation(), scene?.orbit.turn(by[0]!, by[1]!);
    if (e.key === "+") scene?.orbit.zoom(0.85);
    if (e.key === "_") scene?.orbit.zoom(1 / 0.85);
  };
  return (
    <section className={styles.view} aria-label="Three dimensions" tabIndex={0} onKeyDown={turn}>
      <canvas ref={canvas} className={styles.fill} role="img" aria-label="Markers, their paths and the cameras in space" />
      <canvas ref={over} className={styles.fill} aria-hidden="true" />
      {failed ? <p className={styles.none}>This browser shows no WebGL: {failed}</p> : <SceneWords scene={scene} />}
      <Computed className={styles.aside} />
    </section>
  );
}

/** What is seen, in words; and the ellipsoid's size. */
function SceneWords({ scene }: { scene: Scene | null }): React.JSX.Element {
  const { selected, bands, paths } = useParts("selected", "bands", "paths"), text = useRef<HTMLSpanElement>(null), larger = useRef<HTMLSpanElement>(null);
  useEffect(() => {
    const off = playhead.on((frame) => {
      const path = paths?.byName.get(selected[0] ?? ""), i = frame - (paths?.firstFrame ?? 0);
      const sd = path?.origin[i] ? path.sd[i]! : NaN, known = sd > 0; // many files say nothing of it
      text.current!.textContent = path ? (path.origin[i] ? `${path.name}  ${[0, 1, 2].map((k) => mmOf(path.xyz[3 * i + k]!)).join("  ")} mm${known ? `  ± ${mm(sd * 1.96)}` : ""}` : `${path.name}  missing here`) : "";
      larger.current!.hidden = !known || !bands;
    });
    playhead.draw();
    return off;
  }, [selected, paths, scene, bands]);
  return <p className={styles.words}><span ref={text} className="number" /><span ref={larger} className="soft" hidden> · 95 % ellipsoid × {LARGER}</span></p>;
}

const mmOf = (v: number): string => v.toFixed(1);

export function CurvesView(): React.JSX.Element {
  const place = useRef<HTMLDivElement>(null), [curves, setCurves] = useState<Curves | null>(null);
  const s = useSeen(), { header, paths, selected, first, last, bands, fourth, window } = s, seen = watched(s);
  useEffect(() => {
    const made = new Curves(place.current!);
    made.onFrame = (frame): void => (playhead.pause(), playhead.go(frame));
    made.onStretch = (a, b): void => set({ first: a, last: b });
    made.onZoom = (frame, by): void => set((s) => ({ window: zoomed(s.window, frame, by, [playhead.first, playhead.last]) }));
    const off = playhead.on((frame) => made.show(frame));
    setCurves(made);
    return () => (off(), made.dispose());
  }, []);
  useEffect(() => {
    if (!curves || !header || !paths) return;
    curves.set({ curves: curvesOf(s), firstFrame: paths.firstFrame, rate: header.rate, window: window ?? [playhead.first, playhead.last], marked: [first, last], bands, fourth });
  }, [curves, header, paths, selected, s.problem, first, last, bands, fourth, window, s.instead, s.candidates, s.method, s.screen]);
  return (
    <section className={styles.view} aria-label="Curves">
      <div ref={place} className={`${styles.fill} ${styles.under}`} role="img" aria-label={`X, Y, Z and ${fourth} of ${seen.slice(0, SHOWN).join(" and ") || "no marker"} over time`} />
      {!seen.length && <p className={styles.none}><span>Select a marker: click it in the view or its lane, or press <kbd>.</kbd></span></p>}
      {seen.length > 0 && <CurveLegend names={seen} />}
    </section>
  );
}

function curvesOf(s: State): Curve[] {
  const p = palette(), two = [p.a, p.measured, p.filled, p.edited], one = currentProblem(s) ? two : [p.measured, p.filled, p.edited, p.accent];
  const own: Curve[] = watched(s).slice(0, SHOWN).flatMap((name, i) => (s.paths?.byName.has(name) ? [{ path: s.paths.byName.get(name)!, colour: one[i]! }] : []));
  if (s.screen === "gaps" && s.candidates) {
    const { marker, first, candidates } = s.candidates;
    for (const c of candidates) own.push({ ...joined(candidatePath(marker, c.xyz, c.sd), first, s.paths), colour: c.method === s.method ? p.b : p.faint, dashed: c.method !== s.method, band: c.method === s.method });
  } else own.push(...besideCurves(insteadOf(s), watched(s)).map((path) => ({ path, colour: p.b, dashed: true, band: false })));
  return own;
}

function CurveLegend({ names }: { names: readonly string[] }): React.JSX.Element {
  const { instead, screen, candidates, method, bands } = useParts("instead", "screen", "candidates", "method", "bands"), paths = useStore((s) => s.paths), shown = screen === "tracks" && instead;
  const way = screen === "gaps" ? candidates?.candidates.find((c) => c.method === method) : undefined;
  const shaded = Boolean(way?.sd) || names.some((name) => paths?.byName.has(name) && hasSd(paths.byName.get(name)!));
  return (
    <p className={styles.legend}>
      <b>{names.slice(0, SHOWN).join(", ")}{names.length > SHOWN && ` and ${names.length - SHOWN} more`}</b>{shown ? <> · <i className={styles.a} />A as it is · <i className={styles.b} />B if: {instead.words}{instead.straight && ", drawn straight across them"}</> : null}
      {screen === "gaps" && candidates && method && <> · <i className={styles.fillOf} />{wayOf(method)}</>}{bands && shaded && " · shaded 95 %"}
    </p>
  );
}

export function CamerasView(): React.JSX.Element {
  const place = useRef<HTMLDivElement>(null), [cameras, setCameras] = useState<Cameras | null>(null);
  const s = useSeen(), { header, paths, detected, selected, lines, images, follow, clicks } = s, instead = insteadOf(s), problem = currentProblem(s);
  useEffect(() => {
    const made = new Cameras(place.current!, redraw);
    made.onPick = pick;
    made.wanted = (frame): void => void wantDetections(frame);
    made.onClick = (click): boolean => {
      if (get().clicks === null) return false;
      set((now) => ({ clicks: [...now.clicks!.filter((one) => one.camera !== click.camera), click] }));
      return true;
    };
    const off = playhead.on((frame) => made.show(frame));
    setCameras(made);
    return () => (off(), made.dispose());
  }, []);
  useEffect(() => void (cameras && header && paths && cameras.set(header, paths)), [cameras, header, paths]);
  useEffect(() => cameras?.detections(detected), [cameras, detected]);
  useEffect(() => cameras?.with({ selected, lines, images, follow, order: problem?.images ?? [], clicks: clicks ?? [], instead }), [cameras, header, selected, lines, images, follow, clicks, problem?.id, s.instead, s.candidates, s.method]);
  const none = header && !header.cameras.length;
  return (
    <section className={styles.view} aria-label="Cameras">
      <div ref={place} className={`${styles.fill} ${styles.grid}`} data-many={header && header.cameras.length > 9 ? "yes" : ""} data-count={Math.min(12, header?.cameras.length ?? 0)} />
      {none && <p className={styles.none}>This file came without its cameras, so there are no images to compare with.</p>}
    </section>
  );
}
