"""`kinemark run`, `status` and `calibrate`: what is done with a whole session."""

from __future__ import annotations

from pathlib import Path

from ...engine.session import Session
from ...report.calibration_text import calibration_summary
from ...report.terminal_summary import summary
from ..output import Json, SelfContained, Set, print_result, progress


def run(
    session: Path,
    *trials: str,
    set: Set = None,
    to: str = "write",
    frames: tuple[int, int] | None = None,
    results: Path | None = None,
    threads: int | None = None,
    self_contained: SelfContained = False,
    json: Json = False,
) -> None:
    """Process a session: calibrate, detect, match, reconstruct, track, and write C3D and report.

    Args:
        session: a folder with a session.toml, or such a file.
        trials: names of the trials to process; all where none is given.
        set: methods and parameters instead of the file's, as track.method=kiss_tracking; `kinemark methods` lists them.
        to: stop after this stage, such as detect, track or fill.
        frames: only frames FIRST LAST, counted from 1, as a preview; its results go into a folder of their own.
        results: folder for everything computed; results in the session's folder where none is given.
        threads: how many detection may use; as many as there are processors where none is given.
        self_contained: put the drawing library into each page, for mailing.
        json: print the figures for a machine.
    """
    opened = Session.open(session, overrides=set or (), results=results, self_contained=self_contained)
    with progress() as tell:
        if frames is None:
            done = opened.run(trials, to=to, progress=tell, threads=threads)
        else:
            previews = [opened.trial(name).preview(*frames) for name in trials or opened.names]
            done = {trial.name: trial.run(to, progress=tell, threads=threads) for trial in previews}
    if json:
        print_result({name: trial.summary() for name, trial in done.items()})
        return
    for trial in done.values():
        did = ", ".join(trial.computed) or "nothing: all is unchanged"
        figures = f"{summary(trial.quality)}\n\n" if trial.done("quality") else ""
        print_result(f"{figures}computed: {did}\nresults:  {trial.folder}")


def status(session: Path, *trials: str, json: Json = False) -> None:
    """Say which stages of a session's trials are done and up to date; nothing is computed but the calibration.

    Args:
        session: a folder with a session.toml, or such a file.
        trials: names of the trials; all where none is given.
        json: print it for a machine.
    """
    opened = Session.open(session)
    found = {name: opened.trial(name).state() for name in trials or opened.names}
    if json:
        print_result(found)
        return
    for name, stages in found.items():
        done = ", ".join(stage for stage, there in stages.items() if there) or "nothing"
        left = ", ".join(stage for stage, there in stages.items() if not there)
        print_result(f"{name}: {done} done" + (f"; to do: {left}" if left else ""))


def calibrate(session: Path, *, set: Set = None, self_contained: SelfContained = False, json: Json = False) -> None:
    """Calibrate a session's cameras, judge the calibration, and write rig.toml and calibration.html.

    Args:
        session: a folder with a session.toml, or such a file.
        set: methods and parameters instead of the file's, as calibrate.method=dlt.
        self_contained: put the drawing library into the page, for mailing.
        json: print the figures for a machine.
    """
    opened = Session.open(session, overrides=set or (), self_contained=self_contained)
    with progress() as tell:
        result = opened.calibrate(progress=tell)
    if json:
        print_result(result.figures)
        return
    did = "the calibration" if result.computed else "nothing: all is unchanged"
    files = f"{result.folder / 'rig.toml'}, {result.folder / 'calibration.html'}"
    print_result(f"{calibration_summary(result.figures)}\ncomputed: {did}\nresults:  {files}")
