"""The command line: a few lines a command, each over one function of the library."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict
from pathlib import Path
from typing import Annotated, Literal

from cyclopts import App, Parameter
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, SpinnerColumn, TaskID, TextColumn, TimeElapsedColumn

from ..data import KinemarkError
from ..engine.bibliography import as_bibtex, as_text, chosen
from ..engine.detection_proposals import learn_session_masks, propose_detection
from ..engine.error_budget import error_budget
from ..engine.fill_files import fill_files, fill_method, filled_figures, filled_text
from ..engine.formats import convert as convert_file
from ..engine.formats import describe
from ..engine.progress import Progress as Told
from ..engine.session import Session
from ..engine.settings import methods_figures, methods_text, session_schema
from ..engine.simulate import Scene
from ..engine.simulate import simulate as simulate_session
from ..engine.system import absence_notice
from ..engine.system import system as describe_system
from ..engine.trial_angles import AngleSettings, angles_of_file
from ..fill import LIMIT, GapEdges
from ..findings.schema import quality_schema
from ..report.angles_text import angle_summary
from ..report.calibration_text import calibration_summary
from ..report.proposal_text import proposal_text
from ..report.sensitivity_text import sensitivity_summary
from ..report.terminal_summary import finding_lines, summary
from ..report.words import with_words
from ..sensitivity import ErrorBudget
from ..version import __version__
from .demo import demo as run_demo
from .um2as import digitise, um2as

app = App(
    name="kinemark", help="Marker-based optical motion capture, from images to trajectories.", version=__version__
)
app.command(digitise)
app.command(um2as)
errors = Console(stderr=True)

LengthUnit = Literal["mm", "cm", "m", "in"] | None
Json = Annotated[bool, Parameter(name="--json", negative="", help="Print the results for a machine.")]


SelfContained = Annotated[
    bool,
    Parameter(negative="", help="Put the drawing library into the page, for mailing; else pages share one file."),
]

Set = Annotated[
    list[str] | None,
    Parameter(
        name="--set",
        negative="",
        help="STAGE.PARAMETER=VALUE instead of the file's, as track.method=kiss_tracking; may be repeated. "
        "The command methods lists what there is.",
    ),
]


@contextmanager
def progress() -> Iterator[Told]:
    """Bars on the terminal, one a stage; nothing where the output goes to a file."""
    columns = (
        SpinnerColumn(),
        TextColumn("{task.description:<12}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
    )
    with Progress(*columns, console=errors, disable=not errors.is_terminal) as bars:
        tasks: dict[str, TaskID] = {}

        def tell(stage: str, done: int, total: int) -> None:
            if stage not in tasks or bars.tasks[tasks[stage]].completed > done:
                tasks[stage] = bars.add_task(stage, total=total)
            bars.update(tasks[stage], completed=done, total=total)

        yield tell


@app.command
def demo(folder: Path = Path("demo"), *, self_contained: SelfContained = False, json: Json = False) -> None:
    """Simulate a gait laboratory, process its images, and compare with the truth.

    Args:
        folder: where the session goes.
        self_contained: put the drawing library into each page, for mailing.
        json: print the figures for a machine.
    """
    with progress() as tell:
        result = run_demo(folder, self_contained=self_contained, progress=tell)
    _print(result.figures() if json else result.text())
    if not result.passed:
        raise KinemarkError("The demo did not reach what it should; see the figures above.")


@app.command
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
        _print({name: trial.told() for name, trial in done.items()})
        return
    for trial in done.values():
        did = ", ".join(trial.computed) or "nothing: all is unchanged"
        figures = f"{summary(trial.quality)}\n\n" if trial.done("quality") else ""
        _print(f"{figures}computed: {did}\nresults:  {trial.folder}")


@app.command
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
        _print(found)
        return
    for name, stages in found.items():
        done = ", ".join(stage for stage, there in stages.items() if there) or "nothing"
        left = ", ".join(stage for stage, there in stages.items() if not there)
        _print(f"{name}: {done} done" + (f"; to do: {left}" if left else ""))


@app.command
def calibrate(session: Path, *, set: Set = None, self_contained: SelfContained = False, json: Json = False) -> None:
    """Calibrate a session's cameras, judge the calibration, and write rig.toml and calibration.html.

    Args:
        session: a folder with a session.toml, or such a file.
        set: methods and parameters instead of the file's, as calibrate.method=dlt.
        self_contained: put the drawing library into the page, for mailing.
        json: print the figures for a machine.
    """
    with progress() as tell:
        opened = Session.open(session, overrides=set or (), self_contained=self_contained)
        result = opened.calibrate(progress=tell)
    if json:
        _print(result.figures)
        return
    did = "the calibration" if result.computed else "nothing: all is unchanged"
    page = result.folder / "calibration.html"
    _print(f"{calibration_summary(result.figures)}\ncomputed: {did}\nresults:  {result.folder / 'rig.toml'}, {page}")


@app.command
def cite(*words: str, bibtex: bool = False) -> None:
    """List the works that the methods come from, to be cited by whoever uses them.

    Args:
        words: only works whose authors, year or title hold all of these.
        bibtex: write entries for LaTeX.
    """
    found = chosen(words)
    _print(as_bibtex(found) if bibtex else as_text(found))


@app.command
def methods(stage: str | None = None, *, json: Json = False) -> None:
    """List the methods of each stage with their parameters: default, unit, range and meaning.

    Args:
        stage: calibrate, detect, match, reconstruct, track, fill, digitise, angles or smooth; all where none is given.
        json: print them for a machine, with all that is known of each parameter.
    """
    _print(methods_figures(stage) if json else methods_text(stage))


@app.command
def schema(what: Literal["session", "quality"] = "session") -> None:
    """Print the JSON schema of session.toml, for an editor that completes and checks it, or of quality.json.

    Args:
        what: of which file.
    """
    _print({"session": session_schema, "quality": quality_schema}[what]())


@app.command
def detect(source: Path, *, propose: bool = False, masks: Path | None = None, json: Json = False) -> None:
    """Propose parameters for [detect] from images, or learn the masks of a session.

    Args:
        source: a session, images or a video.
        propose: say what the images propose, and why.
        masks: a new TOML file for what the session's [masks] leave out, drawn and learned.
        json: print the proposed parameters for a machine.
    """
    if propose == (masks is not None):
        raise KinemarkError("Say what is wanted, --propose or --masks FILE; kinemark run detects markers in a session.")
    if masks is not None:
        n = learn_session_masks(source, masks)
        _print(f'{masks} is written, {n} polygons. To use it: [masks] file = "{masks.name}"')
        return
    found = propose_detection(source)
    if json:
        _print(
            {
                name: asdict(proposal.centroids)
                | {"findings": with_words([one.as_dict() for one in proposal.findings])}
                for name, proposal in found.items()
            }
        )
    else:
        _print("\n".join(f"# {name}: {proposal_text(proposal)}" for name, proposal in found.items()))


@app.command
def fill(
    source: Path,
    *sources: Path,
    output: Annotated[Path, Parameter(name=("--output", "-o"))],
    method: str = "auto",
    set: Annotated[list[str] | None, Parameter(name="--set", negative="")] = None,
    model: Path | None = None,
    limit_mm: float = LIMIT,
    ends: bool = False,
    trim: int = GapEdges().most,
    static: Path | None = None,
    report: bool = False,
    self_contained: SelfContained = False,
    rate_hz: float | None = None,
    length_unit: LengthUnit = None,
    json: Json = False,
) -> None:
    """Fill the gaps of a trial's markers, each with an expected error; all else in the file stays as it was.

    Args:
        source: a file of trajectories: C3D, TDF, TRC, CSV, HDF5 or TDC.
        sources: and others, which go into a folder under their names.
        output: the file to write, C3D, TRC, CSV, HDF5 or TDC, or a folder; an existing file is not replaced.
        method: auto finds out for every gap which method is best; `kinemark methods fill` lists them.
        set: PARAMETER=VALUE of the method; may be repeated.
        model: an angle model (CSV) or another trial of the same motion, for limb_angles, kalman_angles and auto.
        limit_mm: gaps whose expected mean error is greater stay open; inf leaves none open for that.
        ends: also fill before a marker's first sample and after its last.
        trim: so many bad samples may be replaced on each side of a gap; 0 keeps all that was measured.
        static: a trial in which markers are seen that this one never shows.
        report: write a page beside the output on which every gap is drawn.
        self_contained: as of other commands; this page always is, since its drawings need no library.
        rate_hz: of a CSV or TDC file that does not say it.
        length_unit: of a C3D file that does not say it.
        json: print what became of every gap for a machine.
    """
    chosen = fill_method(method, set or (), model=model)
    with progress() as tell:
        done = fill_files(
            (source, *sources), output, report=report, told=lambda n: tell("fill", n, 1 + len(sources)), method=chosen,
            name=method, limit_mm=limit_mm, ends=ends, trim=trim, static=static, rate_hz=rate_hz,
            length_unit=length_unit,
        )  # fmt: skip
    _print(filled_figures(done) if json else filled_text(done))
    if any(isinstance(found, KinemarkError) for found in done.values()):
        sys.exit(1)


@app.command
def info(*files: Path, system: Annotated[bool, Parameter(negative="")] = False, json: Json = False) -> None:
    """Say what is in files: C3D, TDF, TRC, CSV, rig TOML, DLT, HDF5, video, images or a session.

    Args:
        files: files or folders.
        system: say instead what Kinemark runs on: versions, threads, and whether its compiled library is used.
        json: print it for a machine.
    """
    if system == bool(files):
        raise KinemarkError("Say what is wanted: files, or --system.")
    if system:
        _print(describe_system().figures() if json else describe_system().text())
        return
    found: dict[str, dict[str, object]] = {}
    for one in files:
        try:
            found[str(one)] = describe(one)
        except KinemarkError as error:  # one bad file keeps nobody from seeing the others
            found[str(one)] = {"error": str(error)}
    if json:
        _print(found)
    else:
        for name, facts in found.items():
            _print("\n".join([name, *(f"  {key}: {value}" for key, value in facts.items())]))
    if any("error" in facts for facts in found.values()):
        sys.exit(1)


@app.command
def convert(
    source: Path,
    target: Path,
    *,
    what: Literal["trajectories", "detections", "rig"] | None = None,
    length_unit: LengthUnit = None,
    rate_hz: float | None = None,
) -> None:
    """Convert between formats: trajectories (C3D, TRC, CSV, HDF5, TDC), rigs (TOML, DLT), detections (HDF5, CSV).

    Args:
        source: the file to read.
        target: the file to write; an existing one is not replaced.
        what: which part, where the names do not tell.
        length_unit: of a rig or C3D file that does not say it.
        rate_hz: of detections or trajectories in a CSV or TDC file, which does not say it.
    """
    for note in convert_file(source, target, what=what, length_unit=length_unit, rate_hz=rate_hz):
        _print(f"note: {note}")
    _print(f"{target} is written. What it holds: kinemark info {target}")


@app.command
def simulate(folder: Path, *, scene: Annotated[Scene | None, Parameter(name="*")] = None) -> None:
    """Make a session of a virtual laboratory, with images and exact truth, ready for `kinemark run`.

    Args:
        folder: a new or empty folder.
        scene: what is simulated.
    """
    with progress() as tell:
        simulate_session(folder, scene=scene or Scene(), progress=tell)
    _print(f"{folder}/session.toml is written. Next: kinemark run {folder}")


@app.command
def angles(
    trial: Path,
    *,
    model: str,
    output: Path | None = None,
    static: Path | None = None,
    functional: Path | None = None,
    settings: Annotated[AngleSettings | None, Parameter(name="*")] = None,
    self_contained: SelfContained = False,
    json: Json = False,
) -> None:
    """Joint angles of a trial with their standard deviation: CSV, C3D, a page with curves and a moving stick figure.

    Args:
        trial: a file of trajectories: C3D, TDF, TRC, CSV, HDF5 or TDC.
        model: um2as, isb_upper_limb, isb_shoulder, or a TOML file that describes one.
        output: folder of the results; beside the trial, its name and _angles, where none is given.
        static: trial that shows the points which clusters of markers carry.
        functional: trial whose motion shows the joint centres of the model.
        settings: how angles are taken.
        self_contained: put the drawing library into the page, for mailing.
        json: print the figures for a machine.
    """
    result = angles_of_file(
        trial, model=model, folder=output, static=static, functional=functional, settings=settings,
        self_contained=self_contained,
    )  # fmt: skip
    if json:
        _print(result.figures)
        return
    _print(f"{angle_summary(result.figures)}\nresults:  {result.folder}")


@app.command
def sensitivity(
    session: Path,
    *,
    trial: str | None = None,
    placement_mm: float = 5.0,
    cycles: int = 6,
    centroid_px: float | None = None,
    model: str | None = None,
    markers: Path | None = None,
    rate_hz: float | None = None,
    length_unit: LengthUnit = None,
    self_contained: SelfContained = False,
    json: Json = False,
) -> None:
    """Say what limits the accuracy of a trial: noise, lenses, calibration, marker placement, or a camera that is lost.

    Args:
        session: a folder with a session.toml, or such a file.
        trial: its name; the first of the session where none is given.
        placement_mm: how far, along each axis, a marker sits from its landmark (standard deviation).
        cycles: how many cycles a mean is taken over.
        centroid_px: standard deviation of a centroid, px; as the trial's residuals show it where none is given.
        model: rank the joint angles of this model (its name, or a TOML file); else the directions of segments.
        markers: a file of trajectories (C3D, TDF, TRC, CSV, HDF5 or TDC) of the same recording with the names that the
            model wants.
        rate_hz: of the markers' file, where it does not say it.
        length_unit: of the markers' file, where it does not say it.
        self_contained: put the drawing library into the page, for mailing.
        json: print the figures for a machine.
    """
    try:
        asked = ErrorBudget(placement_mm=placement_mm, cycles=cycles, centroid_sd=centroid_px)
    except ValueError as error:
        raise KinemarkError(f"{error}.") from error
    with progress() as tell:
        found = error_budget(
            session, trial=trial, method=asked, model=model, markers=markers, rate_hz=rate_hz,
            length_unit=length_unit, self_contained=self_contained, progress=tell,
        )  # fmt: skip
    _print(found.figures if json else f"{sensitivity_summary(found.figures)}\nresults:  {found.page}")


def _print(value: object) -> None:
    """Text as it is, anything else as JSON."""
    sys.stdout.write((value if isinstance(value, str) else json.dumps(value, indent=1)) + "\n")
    sys.stdout.flush()


def main() -> None:
    """The command `kinemark`."""
    if notice := absence_notice():
        errors.print(f"kinemark: {notice}", markup=False, highlight=False, soft_wrap=True)
    try:
        app()
    except KinemarkError as error:
        told = "\n".join([f"kinemark: {error}", *finding_lines([found.as_dict() for found in error.findings])])
        errors.print(told, style="red", markup=False, highlight=False, soft_wrap=True)
        sys.exit(1)
    except BrokenPipeError:  # whoever read the output has seen enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        sys.exit(1)
    except KeyboardInterrupt:
        errors.print("stopped; what was finished is kept, and the next run goes on from there")
        sys.exit(130)
