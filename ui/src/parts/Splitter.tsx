import { useRef } from "react";
import { keep } from "../state/store";
import styles from "./Splitter.module.css";

interface Props { name: string; label: string; upright: boolean; least: number; most: number; start: number }

/** A line between two areas that can be dragged or moved with the arrow keys. It sets a custom property of its parent. */
export function Splitter({ name, label, upright, least, most, start }: Props): React.JSX.Element {
  const own = useRef<HTMLDivElement>(null);
  const value = (): number => Number(own.current?.getAttribute("aria-valuenow") ?? start);
  const put = (share: number): void => {
    const to = Math.round(Math.min(most, Math.max(least, share)));
    own.current!.parentElement!.style.setProperty(`--${name}`, String(to));
    own.current!.setAttribute("aria-valuenow", String(to));
    keep(`split.${name}`, String(to));
  };
  const down = (e: React.PointerEvent<HTMLDivElement>): void => {
    const element = e.currentTarget, box = element.parentElement!.getBoundingClientRect();
    const move = (m: PointerEvent): void => put(upright ? (100 * (m.clientX - box.left)) / box.width : (100 * (m.clientY - box.top)) / box.height);
    element.setPointerCapture(e.pointerId);
    element.addEventListener("pointermove", move);
    element.addEventListener("pointerup", () => element.removeEventListener("pointermove", move), { once: true });
  };
  const key = (e: React.KeyboardEvent): void => {
    const by = { ArrowLeft: -2, ArrowUp: -2, ArrowRight: 2, ArrowDown: 2 }[e.key];
    if (by) e.preventDefault(), put(value() + by);
  };
  return <div ref={own} className={`${styles.line} ${upright ? styles.upright : styles.flat}`} role="separator" tabIndex={0} aria-label={label} aria-orientation={upright ? "vertical" : "horizontal"} aria-valuenow={start} aria-valuemin={least} aria-valuemax={most} onPointerDown={down} onKeyDown={key} />;
}
