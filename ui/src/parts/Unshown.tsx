import type { ReactNode } from "react";
import { useStore } from "../state/store";
import styles from "./Waiting.module.css";

/** While the images of a trial are opened; and where they cannot be, why, and what can be done about it. */
export function Unshown({ title, children }: { title: string; children?: ReactNode }): React.JSX.Element {
  const { busy, note, unshown } = useStore();
  return (
    <div className={styles.waiting}>
      <h1>{title}</h1>
      <p>{busy ? "Opening the images …" : (unshown || (note?.words ?? "There is nothing to show."))}</p>
      {!busy && children}
    </div>
  );
}
