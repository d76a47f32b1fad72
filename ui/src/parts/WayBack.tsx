import { CornerUpLeft } from "lucide-react";
import { useEffect } from "react";
import { backToMenu, fetchMenu, pathTo, useMenu } from "../state/um2as";
import { useStore } from "../state/store";
import styles from "./WayBack.module.css";

/** Above a screen that the menu of UM²AS leads to: where in the menu it is, and the way back. */
export function WayBack(): React.JSX.Element | null {
  const { from, menu } = useMenu(), screen = useStore((s) => s.screen), shown = from !== "" && screen !== "um2as" && screen !== "home";
  const [, , id, , trial = "", level = ""] = from.split("/").map(decodeURIComponent);
  useEffect(() => {
    if (!shown || menu || !id) return;
    useMenu.setState({ session: id, trial }); // the page was opened here
    void fetchMenu();
  }, [shown, menu, id, trial]);
  if (!shown) return null;
  return (
    <nav className={styles.bar} aria-label="Way back">
      <ol>{["UM²AS", ...pathTo(level).map((row) => row.title)].map((title) => <li key={title}>{title}</li>)}</ol>
      <button type="button" className="button" onClick={backToMenu}><CornerUpLeft size={14} aria-hidden />Back to the menu<kbd>Esc</kbd></button>
    </nav>
  );
}
