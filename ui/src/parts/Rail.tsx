import { Aperture, DraftingCompass, FileText, History, House, ListTree, MousePointerClick, Orbit, ScanSearch, Spline, Tags } from "lucide-react";
import { tenths } from "../model/format";
import { goTo } from "../state/load";
import { sessionOf, useSessions } from "../state/sessions";
import { held, useMenu } from "../state/um2as";
import { ofFile, TITLES, useStore, useSeen, type Screen, type State } from "../state/store";
import styles from "./Rail.module.css";

const STEPS: readonly { screen: Screen; icon: typeof House; open?: (s: State) => number }[] = [
  { screen: "home", icon: House },
  { screen: "cameras", icon: Aperture },
  { screen: "detect", icon: ScanSearch },
  { screen: "digitise", icon: MousePointerClick },
  { screen: "tracks", icon: Orbit, open: (s) => s.problems?.worth_looking ?? 0 },
  { screen: "labels", icon: Tags, open: (s) => (s.header?.named_only ? [] : s.header?.tracks ?? []).filter((t) => !t.named && !t.computed && t.samples > 0).length },
  { screen: "gaps", icon: Spline, open: (s) => s.gaps?.gaps.filter((g) => g.choice === null).length ?? 0 },
  { screen: "angles", icon: DraftingCompass },
  { screen: "report", icon: FileText },
  { screen: "history", icon: History },
  { screen: "um2as", icon: ListTree },
];

/** Screens of a recording's images. */
const IMAGES: readonly Screen[] = ["detect", "digitise"];

export function Rail(): React.JSX.Element {
  const s = useSeen(), inside = useMenu(held), session = useSessions(sessionOf);
  return (
    <nav className={styles.rail} aria-label="Steps">
      <ul>
        {STEPS.map(({ screen, icon: Icon, open }) => {
          const left = s.header && open ? open(s) : 0, on = s.screen === screen, off = (inside && !on) || (screen === "cameras" || screen === "um2as") ? inside || !session : screen !== "home" && (!s.id || (IMAGES.includes(screen) && ofFile(s)));
          return (
            <li key={screen}>
              <button type="button" className={styles.step} disabled={off} title={inside && !on ? "UM²AS is left from the top of its menu: Escape" : IMAGES.includes(screen) && s.id && off ? "A file of trajectories has no images" : TITLES[screen]} aria-current={on ? "page" : undefined} onClick={() => goTo(screen)}>
                <Icon size={17} aria-hidden />
                <span className={styles.words}>{TITLES[screen]}</span>
                {left > 0 && <span className={styles.count}>{left}<span className="hidden-words"> open</span></span>}
              </button>
            </li>
          );
        })}
      </ul>
      {s.header && s.screen !== "home" && <Left />}
    </nav>
  );
}

/** How many errors are expected, and what looking on would be worth: the stop rule. */
function Left(): React.JSX.Element | null {
  const problems = useStore((s) => s.problems);
  if (!problems) return null;
  return (
    <div className={styles.left}>
      <h3>Errors expected</h3>
      <p className={styles.figure} data-errors={problems.errors}>{tenths(problems.errors)}</p>
      <p className="soft">{problems.worth_looking ? `${tenths(problems.errors_left)} when the ${problems.worth_looking === 1 ? "one worth a look is" : `${problems.worth_looking} worth a look are`} settled` : "Looking on is not worth it."}</p>
    </div>
  );
}
