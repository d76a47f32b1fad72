/** How many pixels of an image have each grey level, on a scale of logarithms, and the threshold in it. */
import { useEffect, useRef } from "react";
import type { CameraFound } from "../api/types";
import { useStore } from "../state/store";
import { fit, palette } from "./palette";

interface Props { found: CameraFound | undefined; onThreshold: (level: number) => void }

const LEVELS = 256;

export function HistogramView({ found, onThreshold }: Props): React.JSX.Element {
  const canvas = useRef<HTMLCanvasElement>(null), theme = useStore((s) => s.theme);
  useEffect(() => {
    if (canvas.current && found) draw(canvas.current, found);
  }, [found, theme]);
  const level = (e: React.PointerEvent<HTMLCanvasElement>): void => {
    const box = e.currentTarget.getBoundingClientRect();
    if (e.buttons === 1) onThreshold(Math.round(Math.min(254, Math.max(0, ((e.clientX - box.left) / box.width) * LEVELS))));
  };
  return <canvas ref={canvas} style={{ width: "100%", height: 64, cursor: "ew-resize" }} role="img" aria-label={found ? `Histogram of ${found.name}; threshold ${found.threshold === null ? "none" : Math.round(found.threshold)} of 255` : "Histogram"} onPointerDown={level} onPointerMove={level} />;
}

function draw(canvas: HTMLCanvasElement, found: CameraFound): void {
  const { clientWidth: w, clientHeight: h } = canvas, ratio = fit(canvas, w, h), c = canvas.getContext("2d")!, p = palette();
  const most = Math.log1p(Math.max(1, ...found.histogram)), x = w / LEVELS;
  c.setTransform(ratio, 0, 0, ratio, 0, 0);
  c.fillStyle = p.view;
  c.fillRect(0, 0, w, h);
  for (const [level, n] of found.histogram.entries()) {
    const white = found.threshold !== null && (found.inverted ? level < found.threshold : level > found.threshold), high = (Math.log1p(n) / most) * (h - 4);
    c.fillStyle = white ? p.select : p.faint;
    c.fillRect(level * x, h - high, Math.max(1, x), high);
  }
  if (found.threshold === null) return;
  c.fillStyle = p.ink;
  c.fillRect(found.threshold * x - 0.75, 0, 1.5, h);
}
