import { useStore, type Dialog } from "../state/store";
import { EventForm } from "./EventForm";
import { Finish } from "./Finish";
import { Help } from "./Help";
import { NameDialog } from "./NameDialog";
import { Palette } from "./Palette";
import { Sign } from "./Sign";
import { Why } from "./Why";

const SHOWN: Record<Exclude<Dialog, null>, () => React.JSX.Element> = { help: Help, commands: Palette, name: NameDialog, why: Why, finish: Finish, sign: Sign, event: EventForm };

export function Dialogs(): React.JSX.Element | null {
  const dialog = useStore((s) => s.dialog);
  if (!dialog) return null;
  const Shown = SHOWN[dialog];
  return <Shown />;
}
