import { lazy, Suspense } from "react";
import { useStore, type Dialog } from "../state/store";
import { EventForm } from "./EventForm";
import { Finish } from "./Finish";
import { NameDialog } from "./NameDialog";
import { Palette } from "./Palette";
import { Sign } from "./Sign";
import { SmoothForm } from "./SmoothForm";
import { Why } from "./Why";

/** With all that it says, which is needed only then. */
const Help = lazy(async () => ({ default: (await import("./Help")).Help }));
const SHOWN: Record<Exclude<Dialog, null>, React.ComponentType> = { help: Help, commands: Palette, name: NameDialog, why: Why, finish: Finish, sign: Sign, event: EventForm, smooth: SmoothForm };

export function Dialogs(): React.JSX.Element | null {
  const dialog = useStore((s) => s.dialog);
  if (!dialog) return null;
  const Shown = SHOWN[dialog];
  return <Suspense><Shown /></Suspense>;
}
