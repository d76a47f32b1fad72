"""`kinemark run`, `status` and `calibrate`: what is done with a whole session."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..output import FailOn, Json, SelfContained, Set, exit_by_verdict, print_errors, print_note, print_result
from ..progress import progress

if TYPE_CHECKING:  # all stages come with a session, and --help does without: they are imported where they are used
    from ...engine.open_trial import OpenTrial
    from ...engine.session import Session


def run(
    session: Path,
    *trials: str,
    set: Set = None,
    to: str = "write",
    frames: tuple[int, int] | None = None,
    results: Path | None = None,
    threads: int | None = None,
    self_contained: SelfContained = False,
    fail_on: FailOn = "red",
    json: Json = False,
) -> None:
    """Process a session: calibrate, detect, match, reconstruct, track, and write C3D and report.

    Args:
        session: a folder with a session.toml, or such a file.
        trials: names of the trials to process; all where none is given.
        to: stop after this stage, such as detect, track or fill.
        frames: only frames FIRST LAST, counted from 1, as a preview; its results go into a folder of their own.
        results: folder for everything computed; results in the session's folder where none is given.
        threads: how many cameras are looked at side by side; as many as there are processors where none is given.
    """
    from ...engine.session import Session

    opened = Session.open(session, overrides=set or (), results=results, self_contained=self_contained)
    with progress() as tell:
        done = opened.run(
            trials, to=to, frames=frames, keep_going=len(trials or opened.names) > 1, progress=tell, threads=threads
        )
    if json:
        gait = {} if opened.gait is None or frames is not None else {"gait": opened.gait}
        print_result({name: trial.summary() for name, trial in done.items()} | gait)
    else:
        print_result("\n\n".join(_did(trial) for trial in done.values() if trial.failed is None))
        if opened.gait is not None and frames is None:
            print_result(f"\n{_gait(opened.gait, opened.results)}")
        print_errors({name: trial.failed for name, trial in done.items() if trial.failed is not None})
    _note_edits_of_no_trial(opened)
    if any(trial.failed for trial in done.values()):
        sys.exit(1)
    exit_by_verdict([trial.quality["verdict"]["grade"] for trial in done.values() if trial.done("quality")], fail_on)


def _note_edits_of_no_trial(session: Session) -> None:
    """What was said of trials that the session does not have, as after one was renamed."""
    for path in session.journals_of_no_trial:
        print_note(
            f"{path} has what people said of a trial {path.stem!r}, which the session does not have: it is applied to "
            f"nothing. If the trial is called otherwise now, give the file its name: {path.with_name('NAME.jsonl')}"
        )


def _gait(figures: dict[str, Any], results: Path) -> str:
    """The gait of a session's walks, and where it is."""
    from ...engine.gait.of_session import FOLDER, REASON
    from ...report.gait_text import gait_summary

    if REASON in figures:
        return f"gait: there is none. {figures[REASON]}"
    return f"{gait_summary(figures)}\nresults:  {results / FOLDER}"


def _did(trial: OpenTrial) -> str:
    """The figures of a trial, what was computed, and where it is."""
    from ...report.terminal_summary import summary

    did = ", ".join(trial.computed) or "nothing: all is unchanged"
    figures = f"{summary(trial.quality)}\n\n" if trial.done("quality") else ""
    return f"{figures}computed: {did}\nresults:  {trial.folder}"


def status(session: Path, *trials: str, json: Json = False) -> None:
    """Say which stages of a session's trials are done and up to date; nothing is computed but the calibration.

    Args:
        session: a folder with a session.toml, or such a file.
        trials: names of the trials; all where none is given.
    """
    from ...engine.session import Session

    opened = Session.open(session)
    found = {name: opened.trial(name).state() for name in trials or opened.names}
    if json:
        print_result(found)
        return
    _note_edits_of_no_trial(opened)
    for name, stages in found.items():
        done = ", ".join(stage for stage, there in stages.items() if there) or "nothing"
        left = ", ".join(stage for stage, there in stages.items() if not there)
        before = " (there are results of other settings, input or version)" if opened.trial(name).outdated() else ""
        print_result(f"{name}: {done} done" + (f"; to do: {left}{before}" if left else ""))


def calibrate(
    session: Path,
    *,
    set: Set = None,
    self_contained: SelfContained = False,
    fail_on: FailOn = "red",
    json: Json = False,
) -> None:
    """Calibrate a session's cameras, judge the calibration, and write rig.toml and calibration.html.

    Args:
        session: a folder with a session.toml, or such a file.
    """
    from ...engine.session import Session
    from ...report.terminal_summary import calibration_summary

    opened = Session.open(session, overrides=set or (), self_contained=self_contained)
    with progress() as tell:
        result = opened.calibrate(progress=tell)
    if json:
        print_result(result.figures)
    else:
        did = "the calibration" if result.computed else "nothing: all is unchanged"
        files = f"{result.folder / 'rig.toml'}, {result.folder / 'calibration.html'}"
        print_result(f"{calibration_summary(result.figures)}\ncomputed: {did}\nresults:  {files}")
    exit_by_verdict([result.figures["verdict"]["grade"]], fail_on)
