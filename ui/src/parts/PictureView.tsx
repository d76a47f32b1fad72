/** A camera's image in its place: what is drawn over it is given anew whenever it changes. */
import { useEffect, useRef } from "react";
import { Picture, type Box, type Over } from "../draw/Picture";
import { useStore } from "../state/store";
import styles from "./PictureView.module.css";

interface Props {
  label: string;
  address: string;
  tall: number;
  over: Over;
  onClick?: (u: number, v: number) => void;
  onMove?: (u: number, v: number) => void;
  onBox?: ((box: Box) => void) | null;
  /** Given once, for buttons that enlarge it. */
  handle?: (picture: Picture) => void;
}

export function PictureView({ label, address, tall, over, onClick, onMove, onBox, handle }: Props): React.JSX.Element {
  const returns = useStore((s) => s.returns), place = useRef<HTMLDivElement>(null), picture = useRef<Picture | null>(null);
  useEffect(() => {
    const made = new Picture(place.current!, label);
    picture.current = made;
    handle?.(made);
    return () => made.dispose();
  }, [label]);
  useEffect(() => void picture.current?.show(address, tall).catch(() => null), [label, address, tall, returns]);
  useEffect(() => {
    const made = picture.current!;
    made.over = over;
    made.onClick = onClick ?? ((): void => {});
    made.onMove = onMove ?? ((): void => {});
    made.onBox = onBox ?? null;
    made.redraw();
  });
  return <div ref={place} className={styles.picture} data-painting={onBox ? "yes" : undefined} />;
}
