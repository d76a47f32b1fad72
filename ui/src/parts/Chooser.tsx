import { useEffect, useId, useRef, useState } from "react";
import styles from "./Modal.module.css";

export interface Choice { id: string; words: string; beside?: string; key?: string }

interface Props {
  label: string;
  /** What is listed for what was typed. */
  find: (typed: string) => readonly Choice[];
  onTake: (id: string) => void;
  onPoint?: (id: string) => void;
  /** Nothing is found that could be pointed at. */
  onNone?: () => void;
  start?: string;
  /** What is said where nothing is found. */
  none?: string;
}

/** A field with a list below it: type to narrow, arrows to point, Enter to take. */
export function Chooser({ label, find, onTake, onPoint, onNone, start = "", none }: Props): React.JSX.Element {
  const [typed, setTyped] = useState(start), [at, setAt] = useState(0), list = useRef<HTMLUListElement>(null), id = useId();
  const found = find(typed), pointed = found[Math.min(at, found.length - 1)];
  useEffect(() => {
    list.current?.querySelector('[aria-selected="true"]')?.scrollIntoView({ block: "nearest" });
    if (pointed) onPoint?.(pointed.id);
    else onNone?.();
    // eslint-disable-next-line -- only what is pointed at matters
  }, [pointed?.id]);
  const onKeyDown = (e: React.KeyboardEvent): void => {
    const by = e.key === "ArrowDown" ? 1 : e.key === "ArrowUp" ? -1 : 0;
    if (by) e.preventDefault(), setAt((n) => Math.min(found.length - 1, Math.max(0, n + by)));
    if (e.key === "Enter" && pointed) e.preventDefault(), onTake(pointed.id);
  };
  return (
    <>
      <input className={`field ${styles.search}`} autoFocus role="combobox" aria-label={label} aria-expanded="true" aria-controls={id} aria-activedescendant={pointed ? `${id}-${pointed.id}` : undefined} aria-autocomplete="list" placeholder={label} value={typed} onChange={(e) => (setTyped(e.target.value), setAt(0))} onKeyDown={onKeyDown} spellCheck={false} />
      <ul ref={list} id={id} role="listbox" aria-label={label} className={styles.list}>
        {found.map((one) => (
          <li key={one.id} id={`${id}-${one.id}`} role="option" aria-selected={one.id === pointed?.id} onClick={() => onTake(one.id)}>
            {one.words}{one.beside && <small>{one.beside}</small>}{one.key && <kbd>{one.key}</kbd>}
          </li>
        ))}
      </ul>
      {none && !found.length && <p role="status" className="soft">{none}</p>}
    </>
  );
}
