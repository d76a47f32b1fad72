import { useMemo, useState } from "react";
import { COMMANDS, type Group } from "../keys/commands";
import { shownKey } from "../keys/bind";
import { commandsOf, find, type Topic } from "../keys/topics";
import { goTo } from "../state/load";
import { sessionOf } from "../state/sessions";
import { get, keep, set, TITLES, useStore } from "../state/store";
import { Chooser } from "./Chooser";
import styles from "./Help.module.css";
import modal from "./Modal.module.css";
import { Modal } from "./Modal";

const GROUPS: readonly Group[] = ["Cameras", "Detection", "Digitising", "Problems", "Names", "Gaps and places", "Time", "View", "Trial", "Go to"];

/** What to do, found by words; and all keys. */
export function Help(): React.JSX.Element {
  const [keys, setKeys] = useState(false);
  return (
    <Modal title="Help" wide>
      <div className={styles.tabs}>
        <button type="button" className="button" aria-pressed={!keys} onClick={() => setKeys(false)}>What to do</button>
        <button type="button" className="button" aria-pressed={keys} onClick={() => setKeys(true)}>All keys</button>
      </div>
      {keys ? <Keys /> : <Topics />}
    </Modal>
  );
}

function Topics(): React.JSX.Element {
  const screen = useStore((s) => s.screen), [id, setId] = useState(""), all = useMemo(() => find("", screen), [screen]), shown = all.find((t) => t.id === id);
  const choices = (typed: string): { id: string; words: string; beside: string }[] =>
    find(typed, screen).map((t) => ({ id: t.id, words: t.title, beside: t.screen ? TITLES[t.screen] : "everywhere" }));
  return (
    <div className={styles.topics}>
      <div className={styles.found}><Chooser label="Type a word: rename, gap, threshold …" find={choices} onTake={(taken) => goThere(all.find((t) => t.id === taken)!)} onPoint={setId} onNone={() => setId("")} none="No topic has all of these words. Take one away, or look among all keys." /></div>
      {shown && <Shown topic={shown} />}
    </div>
  );
}

function Shown({ topic }: { topic: Topic }): React.JSX.Element {
  return (
    <section className={styles.shown} aria-label={topic.title} aria-live="polite" tabIndex={0} data-topic={topic.id}>
      <h3>{topic.title}</h3>
      <p>{topic.text.split(/\{([\w-]+)\}/).map((part, i) => (i % 2 ? <kbd key={i}>{shownKey(COMMANDS.find((c) => c.id === part)!.keys[0]!)}</kbd> : part))}</p>
      <ul>{commandsOf(topic).map((c) => <li key={c.id}>{c.title}<span>{c.keys.map((key) => <kbd key={key}>{shownKey(key)}</kbd>)}</span></li>)}</ul>
      {topic.screen && reached(topic) && topic.screen !== get().screen && <button type="button" className="button" onClick={() => goThere(topic)}>Go to {TITLES[topic.screen]}<kbd>Enter</kbd></button>}
    </section>
  );
}

/** Whether its screen can be gone to now. */
const reached = ({ screen }: Topic): boolean => screen === "home" || screen === "new" || (screen === "cameras" ? sessionOf() !== null : get().id !== null);

function goThere(topic: Topic): void {
  set({ dialog: null });
  if (topic.screen && reached(topic) && topic.screen !== get().screen) goTo(topic.screen);
}

function Keys(): React.JSX.Element {
  const letters = useStore((s) => s.letters);
  const flip = (): void => (keep("letters", letters ? "off" : "on"), set({ letters: !letters }));
  return (
    <>
      <div className={modal.keys} tabIndex={0} role="region" aria-label="All keys">
        {GROUPS.map((group) => (
          <section key={group}>
            <h3>{group}</h3>
            <ul>
              {COMMANDS.filter((c) => c.group === group).map((c) => (
                <li key={c.id}>{c.title}<span>{c.keys.map((key) => <kbd key={key}>{shownKey(key)}</kbd>)}</span></li>
              ))}
            </ul>
          </section>
        ))}
      </div>
      <div className={modal.body}>
        <label className={modal.row}><input type="checkbox" checked={letters} onChange={flip} />Single letters do something (without them, use Ctrl K)</label>
      </div>
    </>
  );
}
