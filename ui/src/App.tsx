/** The frame of every screen: head, rail, screen, foot. */
import { useEffect, useLayoutEffect } from "react";
import styles from "./App.module.css";
import { Dialogs } from "./parts/Dialogs";
import { Foot } from "./parts/Foot";
import { Head } from "./parts/Head";
import { Rail } from "./parts/Rail";
import { Shown } from "./parts/Shown";
import { Transport } from "./parts/Transport";
import { WayBack } from "./parts/WayBack";
import { playhead, useStore } from "./state/store";

/** Buttons that were clicked give the keys back; whoever tabs to them keeps them. */
function blurClicked(event: React.MouseEvent): void {
  if (event.detail > 0 && (event.target as Element).closest("button") && document.activeElement instanceof HTMLButtonElement) document.activeElement.blur();
}

/** Says on the page that something is being worked on; nothing else is drawn anew for it. */
function Busy(): null {
  const busy = useStore((s) => s.busy > 0);
  useLayoutEffect(() => void (document.getElementById("main")!.dataset.busy = busy ? "yes" : "no"), [busy]);
  return null;
}

export function App(): React.JSX.Element {
  const screen = useStore((s) => s.screen), header = useStore((s) => s.header), connected = useStore((s) => s.connected), stranger = useStore((s) => s.stranger);
  const editor = header !== null && (screen === "tracks" || screen === "gaps" || screen === "labels" || screen === "angles");
  const name = header && screen !== "home" ? `${header.name} – ` : "";
  useEffect(() => void (document.title = `${name}Kinemark studio`), [name]);
  useEffect(() => playhead.on((frame) => (document.getElementById("main")!.dataset.frame = String(frame))), []);
  return (
    <div className={styles.app} onClick={blurClicked}>
      <Head />
      <Rail />
      <main id="main" className={styles.main} data-screen={screen} data-head={header?.head ?? ""} data-edits={header?.edits ?? ""} data-stale={header ? (header.stale ? "yes" : "no") : ""}>
        {!connected && <p role="alert" className={styles.lost}>{stranger ? "The studio was started anew and does not know this window. Nothing is lost: every edit is saved when it is made. Open the address that it gives where it was started, in this browser: then this window goes on as well." : "The studio's server does not answer. Nothing is lost: every edit is saved when it is made. Where it was ended, start kinemark studio again and open the address that it gives; where it only was busy, this page goes on by itself."}</p>}
        <WayBack />
        <Busy />
        <Shown key={screen} screen={screen} />
      </main>
      {editor && <Transport />}
      <Foot />
      <Dialogs />
    </div>
  );
}
