/** Another way of calibration: the recordings that could calibrate, what is asked for the one that is chosen, the change. */
import { useEffect, useState } from "react";
import * as api from "../api/ways";
import type { WayRow } from "../api/ways";
import { say, tried } from "../state/load";
import { useStore } from "../state/store";
import { fetchCameras, put } from "../state/sessions";
import { Asked } from "./Shown";
import styles from "./ChangeWay.module.css";

export function ChangeWay({ id, done }: { id: string; done: () => void }): React.JSX.Element {
  const returns = useStore((s) => s.returns), [ways, setWays] = useState<readonly WayRow[] | null>(null), [chosen, setChosen] = useState(""), [answers, setAnswers] = useState<Record<string, string>>({});
  useEffect(() => void tried(() => api.ways(id)).then((got) => {
    if (!got) return;
    setWays(got.ways);
    setChosen((now) => now || keyOf(got.ways.find((one) => !one.now)));
  }), [id, returns]);
  if (!ways) return <div className={styles.card}><Asked words="Recordings are looked for …" /></div>;
  const one = ways.find((way) => keyOf(way) === chosen);
  const change = async (e: React.FormEvent): Promise<void> => {
    e.preventDefault();
    const got = one && (await tried(() => api.change(id, { path: one.path, role: one.role as api.Role, answers })));
    if (!got) return;
    put({ cameras: got, control: null, pointing: null, camera: "", point: "" });
    await fetchCameras();
    done();
    say("done", `The session is calibrated by ${one.words} from now on. Calibrate now.`);
  };
  return (
    <form className={styles.card} aria-label="Another way of calibration" onSubmit={(e) => void change(e)}>
      <h2>Another way of calibration</h2>
      {!ways.length && <p>No recording in the session's folder could calibrate it.</p>}
      <ul className={styles.ways}>{ways.map((way) => (
        <li key={keyOf(way)}><label><input type="radio" name="way" checked={keyOf(way) === chosen} onChange={() => (setChosen(keyOf(way)), setAnswers({}))} /> <b>{way.words}</b> <code>{way.path}</code>{" "}{way.now && <span className="pill info">now</span>}<span className="soft"> {way.why}</span></label></li>
      ))}</ul>
      {one?.questions.map((ask) => (
        <label key={ask.key} className={styles.question}>{ask.words}{ask.optional && <span className="soft"> (may be left out)</span>}
          {ask.choices.length
            ? <select className="field" value={answers[ask.key] ?? ""} onChange={(e) => setAnswers({ ...answers, [ask.key]: e.target.value })}><option value="">…</option>{ask.choices.map((c) => <option key={c}>{c}</option>)}</select>
            : <input className="field" inputMode="decimal" value={answers[ask.key] ?? ""} onChange={(e) => setAnswers({ ...answers, [ask.key]: e.target.value })} />}
        </label>
      ))}
      <p className={styles.acts}><button type="submit" className="button strong" disabled={!one}>Change to it</button><button type="button" className="button" onClick={done}>Leave it as it is</button></p>
      <p className="soft">Written into session.toml; all else in it stays, and the present calibration is kept among the former ones.</p>
    </form>
  );
}

const keyOf = (way: WayRow | undefined): string => (way ? `${way.role} ${way.path}` : "");
