/** Tables, findings and key figures as the library words them. */
import { CircleAlert, CircleCheck, Info } from "lucide-react";
import type { FindingRow, TableRows } from "../api/sessions";
import styles from "./Tables.module.css";

export const WordTable = ({ of }: { of: TableRows }): React.JSX.Element => (
  <details className={styles.card} open={of.rows.length <= 12}>
    <summary><h2>{of.title}</h2></summary>
    <p className="soft">{of.about}</p>
    <div className={styles.scroll} tabIndex={0} role="region" aria-label={of.title}>
      <table>
        <thead><tr>{of.head.map((h) => <th key={h} scope="col">{h}</th>)}</tr></thead>
        <tbody>{of.rows.map((row, i) => (
          <tr key={i} className={of.marked[i] ? styles.marked : ""}>{row.map((cell, k) => (k ? <td key={k}>{cell}</td> : <th key={k} scope="row">{cell}{of.marked[i] && <span title="look at this one"> ▲</span>}</th>))}</tr>
        ))}</tbody>
      </table>
    </div>
  </details>
);

const ICON = { red: CircleAlert, amber: CircleAlert, green: CircleCheck, info: Info };

export const Findings = ({ of }: { of: readonly FindingRow[] }): React.JSX.Element => (
  <ul className={styles.findings}>
    {of.map((one) => {
      const Icon = ICON[one.severity];
      return <li key={one.words} data-severity={one.severity}><Icon size={15} aria-hidden /><div><p><span className="hidden-words">{one.severity}: </span>{one.words}</p>{one.advice && <p className="soft">{one.advice}</p>}</div></li>;
    })}
  </ul>
);
