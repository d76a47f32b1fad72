import { reportAddress } from "../api/client";
import { useStore } from "../state/store";
import styles from "./Report.module.css";

/** The report page as it is, in a frame that may draw and nothing else. */
export function Report(): React.JSX.Element {
  const { header, id } = useStore();
  return (
    <>
      <h1 className="hidden-words">Report of {header?.name}</h1>
      {header?.stale && <p className={styles.stale}>{header.stale}</p>}
      {id && <iframe className={styles.frame} src={reportAddress(id)} title={`Report of ${header?.name ?? "the trial"}`} sandbox="allow-scripts" />}
    </>
  );
}
