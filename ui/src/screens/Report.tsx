import { ExternalLink, FileDown } from "lucide-react";
import { useEffect, useState } from "react";
import { reportAddress, standing } from "../api/client";
import { tried, writePdf } from "../state/load";
import { print } from "../state/print";
import { useStore } from "../state/store";
import styles from "./Report.module.css";

/** The report page as it is, in a frame that may draw and nothing else; where there is none, why. */
export function Report(): React.JSX.Element {
  const { header, id, busy, returns } = useStore(), [stands, setStands] = useState<{ ready: boolean; words?: string } | null>(null), there = stands?.ready === true;
  useEffect(() => void (id && tried(() => standing(id, "report")).then(setStands)), [id, header, returns]);
  return (
    <>
      <header className={styles.head}>
        <h1>{header ? `Report of ${header.name}` : "Report"}</h1>
        {header?.stale && <p className={styles.stale}>{header.stale}</p>}
        {there && <button type="button" className="button" onClick={print}><ExternalLink size={14} aria-hidden />Alone, to print<kbd>⇧ P</kbd></button>}
        {there && <button type="button" className="button" disabled={!id || busy > 0} onClick={() => void writePdf()}><FileDown size={14} aria-hidden />PDF{header && <kbd>P</kbd>}</button>}
      </header>
      {id && there && <iframe className={styles.frame} src={reportAddress(id)} title={`Report of ${header?.name ?? "the trial"}`} sandbox="allow-scripts" />}
      {!there && <p className={styles.none}>{stands?.words}</p>}
    </>
  );
}
