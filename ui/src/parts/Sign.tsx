import { many } from "../model/format";
import { act } from "../state/acts";
import { set, useStore } from "../state/store";
import { Modal } from "./Modal";
import styles from "./Modal.module.css";

export function Sign(): React.JSX.Element {
  const { header, problems } = useStore(), open = problems?.worth_looking ?? 0;
  const sign = (e: React.FormEvent): void => (e.preventDefault(), set({ dialog: null }), void act({ kind: "sign" }, `Signed by ${header?.by ?? ""}`));
  return (
    <Modal title="Sign this version">
      <form className={styles.body} onSubmit={sign}>
        <p>You, <b>{header?.by || "the user of this machine"}</b>, stand for {header?.name} as it is now, with {many(header?.edits ?? 0, "edit")}. Whatever is changed later will be seen to be later.</p>
        {open > 0 && <p className={`${styles.join} ${styles.not}`}>{many(open, "problem")} worth a look {open === 1 ? "has" : "have"} not been looked at.</p>}
        <div className={styles.actions}><button className="button strong" autoFocus>Sign</button></div>
      </form>
    </Modal>
  );
}
