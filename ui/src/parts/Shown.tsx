import { useEffect, useState } from "react";
import { loadAgain, loadedScreen, loadScreen, loadTheOthers } from "../screens/shown";
import { again } from "../state/load";
import { useStore, type Screen } from "../state/store";
import styles from "./Waiting.module.css";

/** ms within which the other screens are loaded where the browser never rests; chosen. */
const LATEST_MS = 2000;

/** The others are loaded when the first screen is there with what it shows, never before: it comes first. */
function whenIdle(work: () => void): void {
  if (useStore.getState().busy > 0) {
    const off = useStore.subscribe((s) => {
      if (s.busy === 0) off(), whenIdle(work);
    });
  } else requestIdleCallback(work, { timeout: LATEST_MS });
}

/** A screen, as soon as its part of the page is here. Give it the screen as key. */
export function Shown({ screen }: { screen: Screen }): React.JSX.Element {
  const [, come] = useState(false), [failed, setFailed] = useState(false), View = loadedScreen(screen);
  useEffect(() => {
    if (!View) loadScreen(screen).then(() => (come(true), whenIdle(() => void loadTheOthers())), () => (setFailed(true), void loadAgain(screen)));
  }, []);
  if (View) return <View />;
  return (
    <div className={styles.waiting}>
      <h1 className={failed ? "" : "hidden-words"}>{failed ? "This screen could not be loaded" : "Loading the screen"}</h1>
      {failed && <p role="alert">The server gave no answer, or it is a newer one than this page. Nothing is lost: every edit is saved when it is made.</p>}
      {failed && <div><button type="button" className="button strong" onClick={() => location.reload()}>Load the page again</button></div>}
    </div>
  );
}

/** What stands where something is asked for that is not there yet; and where it could not be had, that it is asked for again. */
export function Asked({ words }: { words: string }): React.JSX.Element {
  const busy = useStore((s) => s.busy > 0), refused = useStore((s) => s.note?.kind === "refused");
  if (busy || !refused) return <p className="soft" role="status">{words}</p>;
  return <p role="alert">This could not be had; the line below says why. <button type="button" className="button" onClick={() => void again()}>Ask again</button></p>;
}
