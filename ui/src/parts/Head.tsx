import { useEffect, useState } from "react";
import { Check, CloudOff, Loader2, Moon, Redo2, Search, Sun, SunMoon, Undo2 } from "lucide-react";
import { byId } from "../keys/commands";
import { many, when } from "../model/format";
import { goTo } from "../state/load";
import { set, useParts, useStore, type Theme } from "../state/store";
import { chooseTheme } from "../state/theme";
import styles from "./Head.module.css";
import { Mark } from "./Mark";

const NEXT: Record<Theme, Theme> = { auto: "light", light: "dark", dark: "auto" };
const ICON = { auto: SunMoon, light: Sun, dark: Moon };

function Where(): React.JSX.Element {
  const header = useStore((s) => s.header), screen = useStore((s) => s.screen);
  return (
    <nav aria-label="Where you are" className={styles.where}>
      <button type="button" className={styles.brand} onClick={() => goTo("home")}><Mark />Kinemark</button>
      {header && screen !== "home" && (
        <>
          {header.session && <span className={styles.step}>{header.session}</span>}
          <span className={styles.step} aria-current="page"><b>{header.name}</b></span>
          <span className={styles.about}>{many(header.n_frames, "frame")} · {Number(header.rate.toFixed(2))} Hz · {header.cameras.length ? many(header.cameras.length, "camera") : "no cameras"}</span>
        </>
      )}
    </nav>
  );
}

/** ms of work before it is said: what most edits take less than is no news, and drawing it would delay them; chosen. */
const LONG_MS = 150;

/** Whether something is being worked on for long. */
function useLongWork(): boolean {
  const busy = useStore((s) => s.busy > 0), [long, setLong] = useState(false);
  useEffect(() => {
    if (!busy) return setLong(false);
    const later = setTimeout(() => setLong(true), LONG_MS);
    return () => clearTimeout(later);
  }, [busy]);
  return long;
}

function Saved(): React.JSX.Element | null {
  const { header, savedAt, connected } = useParts("header", "savedAt", "connected"), long = useLongWork();
  if (!connected) return <span className={`${styles.saved} ${styles.bad}`}><CloudOff size={14} aria-hidden />no server</span>;
  if (!header) return null;
  if (long) return <span className={styles.saved}><Loader2 size={14} className={styles.spin} aria-hidden />working</span>;
  return <span className={styles.saved}><Check size={14} aria-hidden />{savedAt ? `saved ${when(savedAt)}` : "no edits yet"}{header.by && ` · ${header.by}`}</span>;
}

export function Head(): React.JSX.Element {
  const theme = useStore((s) => s.theme), header = useStore((s) => s.header), Icon = ICON[theme];
  return (
    <header className={styles.head}>
      <Where />
      <button type="button" className={styles.search} onClick={() => set({ dialog: "commands" })}><Search size={14} aria-hidden /><span>Search or command</span><kbd>Ctrl K</kbd></button>
      <div className={styles.right}>
        <span role="status"><Saved /></span>
        <button type="button" className="icon-button" aria-label="Undo (Ctrl+Z)" title="Undo (Ctrl+Z)" disabled={header?.undo == null} onClick={byId("undo").run}><Undo2 size={16} aria-hidden /></button>
        <button type="button" className="icon-button" aria-label="Redo (Ctrl+Shift+Z)" title="Redo (Ctrl+Shift+Z)" disabled={header?.redo == null} onClick={byId("redo").run}><Redo2 size={16} aria-hidden /></button>
        <button type="button" className="icon-button" aria-label={`Theme: ${theme}`} title={`Theme: ${theme}`} onClick={() => chooseTheme(NEXT[theme])}><Icon size={16} aria-hidden /></button>
      </div>
    </header>
  );
}
