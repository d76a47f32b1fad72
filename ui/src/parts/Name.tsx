/** The name of a marker; too long a one loses its middle, as sides and numbers stand at the end. */
import { ends } from "../model/format";
import { withoutSubject } from "../model/names";
import { useStore } from "../state/store";
import styles from "./Name.module.css";

export function Name({ of }: { of: string }): React.JSX.Element {
  const [begin, end] = ends(useStore((s) => withoutSubject(s.header, of)));
  return <b className={styles.name} title={of}><span className={styles.begin}>{begin}</span><span className={styles.end}>{end}</span></b>;
}
