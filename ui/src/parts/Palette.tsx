import { byId, COMMANDS, possible } from "../keys/commands";
import { shownKey } from "../keys/bind";
import { goTo } from "../state/load";
import { get, set, useStore } from "../state/store";
import { Chooser, type Choice } from "./Chooser";
import { Modal } from "./Modal";
import styles from "./Modal.module.css";

/** Commands that can be done now, markers, and trials, by a few letters of each word. */
export function Palette(): React.JSX.Element {
  const state = useStore();
  const commands: Choice[] = COMMANDS.filter((c) => possible(c, state)).map((c) => ({ id: `c:${c.id}`, words: c.title, beside: c.group, key: shownKey(c.keys[0]!) }));
  const markers: Choice[] = (state.header?.tracks ?? []).filter((t) => state.computed || !t.computed).map((t) => ({ id: `m:${t.name}`, words: t.name, beside: "select" }));
  const trials: Choice[] = (state.home?.sessions ?? []).flatMap((s) => s.trials.map((t) => ({ id: `t:${t.id}`, words: `${s.title} › ${t.name}`, beside: "open" })));
  const find = (typed: string): Choice[] => {
    const words = typed.toLowerCase().split(" ").filter(Boolean);
    return [...commands, ...trials, ...(typed ? markers : [])].filter((c) => words.every((w) => `${c.words} ${c.beside}`.toLowerCase().includes(w))).slice(0, 60);
  };
  const take = (id: string): void => {
    set({ dialog: null });
    const what = id.slice(2);
    if (id.startsWith("c:")) byId(what).run();
    else if (id.startsWith("m:")) set({ selected: [what], focused: get().focused + 1 });
    else goTo("tracks", what);
  };
  return <Modal title="Search or command"><div className={styles.body}><Chooser label="What do you want to do?" find={find} onTake={take} /></div></Modal>;
}
