import { X } from "lucide-react";
import { useEffect, useRef, type ReactNode } from "react";
import { set } from "../state/store";
import styles from "./Modal.module.css";

/** A dialog of the browser's own: it keeps the focus within and gives it back. */
export function Modal({ title, wide, children }: { title: string; wide?: boolean; children: ReactNode }): React.JSX.Element {
  const dialog = useRef<HTMLDialogElement>(null);
  useEffect(() => {
    const element = dialog.current!;
    element.showModal(); // it would give the focus to the button that closes it
    element.querySelector<HTMLElement>("[data-body] :is(input, select, .strong)")?.focus();
    return () => element.close();
  }, []);
  const close = (): void => set({ dialog: null });
  return (
    <dialog ref={dialog} className={`${styles.dialog} ${wide ? styles.wide : ""}`} aria-labelledby="dialog-title" onCancel={(e) => (e.preventDefault(), close())} onClick={(e) => e.target === dialog.current && close()}>
      <div className={styles.inside}>
        <header><h2 id="dialog-title">{title}</h2><button type="button" className="icon-button" aria-label="Close (Esc)" onClick={close}><X size={16} aria-hidden /></button></header>
        <div data-body className={styles.content}>{children}</div>
      </div>
    </dialog>
  );
}
