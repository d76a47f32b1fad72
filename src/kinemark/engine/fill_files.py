"""Filling the gaps of a file of trajectories, ours or another system's, and nothing else of it changed."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from pydantic import ValidationError

from ..data import AngleModel, KinemarkError, Trajectories, Trial
from ..data.progress import listening
from ..fill import Auto, Filled, KalmanAngles, LimbAngles, MarkerArray, fill, fit_model
from ..findings.gaps import filling_figures
from ..io.angle_model_csv import FIRST, read_angle_model
from ..io.formats import check_new_trial, endings
from ..io.gaps_csv import is_gaps_csv
from ..io.notes import FileNote, file_note_text, read_notes
from ..io.number_text import read_text
from ..io.trial import read_trial, write_trial
from ..report.filling_page import write_filling_page
from ..report.terminal_summary import filling_summary
from ..report.words import with_words
from .folders import FILLED, check_folder
from .identities import identity_of_file
from .progress import Progress, Watch, silent
from .put_aside import put_aside
from .settings.method_tables import method_of
from .settings.read import overridden


class FilledFile(NamedTuple):
    """What was done.

    Attributes:
        trial: with its gaps filled. filled: what became of each. figures: of the page.
        written: the files. notes: what the target could not hold.
    """

    trial: Trial
    filled: Filled
    figures: dict[str, Any]
    written: tuple[Path, ...]
    notes: tuple[FileNote, ...] = ()


def fill_file(
    source: Path,
    target: Path,
    *,
    method: Any = None,
    name: str = "auto",
    limit_mm: float | None = None,
    ends: bool = False,
    trim: int = 0,
    static: Path | None = None,
    report: Path | None = None,
    rate_hz: float | None = None,
    length_unit: str | None = None,
    partial: bool = False,
) -> FilledFile:
    """Fill the gaps of a trial's markers and write it; channels, events, angles and parameters stay as they were.

    So do points that a program computed of markers: no skin moves them, and they follow from the filled markers.

    Args:
        source: any file of trajectories, as `io.trial` reads them.
        target: the file to write, as `io.trial` writes them; an existing one is not replaced.
        method: one of `fill.FILL`, with its parameters; `Auto()` where None. name: what the report calls it.
        limit_mm: gaps whose expected mean error is greater stay open; as `fill` takes it where None.
        ends: also fill before a marker's first sample and after its last.
        trim: so many suspicious samples may be replaced on each side of a gap; 0: they are listed and kept.
        static: a trial in which the markers are seen that are not seen in this one.
        report: a page to write on every gap; an existing one is replaced.
        rate_hz, length_unit: of a file that does not say it. partial: read what there is of a damaged one.

    Raises:
        KinemarkError: a file is absent, damaged or holds no trajectories, the target exists, or a number is not one
            that it can be.
    """
    _check(limit_mm, trim)

    def reader(file: Path) -> Trial:
        return read_trial(file, rate_hz=rate_hz, length_unit=length_unit, partial=partial)

    check_new_trial(target)
    trial = reader(source)
    if not len(trial.trajectories):
        raise KinemarkError(f"{source} has no markers, so there is nothing to fill.")
    positions, aside = put_aside(trial)
    still = put_aside(reader(static)).rest if static else None
    filled = fill(positions, method=method, limit_mm=limit_mm, ends=ends, trim=trim, static=still)
    lacking = sum(bool(np.isnan(path.xyz).any()) for path in aside)
    figures = with_words(
        filling_figures(filled, positions, source=source.name, method=name, limit_mm=limit_mm, computed=lacking)
    )
    figures["identity"] = identity_of_file(trial, source)
    whole = replace(trial, trajectories=_in_order(trial.trajectories, filled.trajectories))
    notes = (*read_notes(trial.notes), *write_trial(whole, target))
    if report:
        write_filling_page(report, figures=figures, trajectories=filled.trajectories, before=positions)
    return FilledFile(whole, filled, figures, (target, report) if report else (target,), notes)


def _in_order(before: Trajectories, filled: Trajectories) -> Trajectories:
    """The file's points in its own order, its markers filled; after them what was placed anew."""
    done = {path.name: path for path in filled}
    kept = [done.pop(path.name, path) for path in before]
    return replace(before, paths=(*kept, *done.values()))


def fill_files(
    sources: Sequence[Path],
    output: Path | Mapping[Path, Path],
    *,
    report: bool = False,
    progress: Progress = silent,
    **options: Any,
) -> dict[Path, FilledFile | KinemarkError]:
    """Fill one trial into a file or folder, or many into a folder under their own names.

    Of many, one that cannot be filled keeps nobody from the others: its error stands in its place.

    Args:
        sources: files as `fill_file` takes them; BTS files become C3D in a folder.
        output: a file, or a folder, which is made where it is not there; or a file for each, as `targets_of` gives.
        report: write a page beside each.
        progress: called with the steps of each file.
        options: the others of `fill_file`.

    Raises:
        KinemarkError: there are many files for one, or the only one cannot be filled.
    """
    many, targets = len(sources) > 1, output if isinstance(output, Mapping) else targets_of(sources, output)
    pages = _pages(targets)
    done: dict[Path, FilledFile | KinemarkError] = {}
    for number, source in enumerate(sources, 1):
        try:
            with listening(Watch(progress).of(f"{source.name} ({number} of {len(sources)})" if many else source.name)):
                check_folder(source)
                page = pages[source] if report else None
                done[source] = fill_file(source, targets[source], report=page, **options)
        except KinemarkError as error:
            if not many:
                raise
            done[source] = error
    return done


def targets_of(sources: Sequence[Path], output: Path | None = None, *, alone: bool = False) -> dict[Path, Path]:
    """The file that the result of each trial goes into.

    Args:
        sources: the trials.
        output: a file, or a folder; where None, a folder "filled" beside each trial. alone: there is one trial, which
            was named itself; where there is no output, its result stands beside it.

    Raises:
        KinemarkError: there are many trials for one file.
    """
    if output is None:
        if alone:
            return {one: one.with_name(f"{one.stem}{FILLED}{Path(own_name(one)).suffix}") for one in sources}
        return {one: one.parent / "filled" / own_name(one) for one in sources}
    if output.is_dir() or not output.suffix:
        return {one: output / own_name(one) for one in sources}
    if len(sources) > 1:
        raise KinemarkError(f"{output} is one file, and there are {len(sources)} trials. Name a folder.")
    return dict.fromkeys(sources, output)


def _pages(targets: Mapping[Path, Path]) -> dict[Path, Path]:
    """The page of each source: it has the name of the result, and its ending too where two would have one page."""
    short = Counter(target.with_suffix(".html") for target in targets.values())
    return {
        source: page if short[page := target.with_suffix(".html")] == 1 else target.with_name(f"{target.name}.html")
        for source, target in targets.items()
    }


def check_table(table: Path, others: Iterable[Path | None]) -> None:
    """Whether a table of gaps may be written there: an earlier one may be replaced, and nothing else.

    Args:
        table: the file. others: that are read or written in the same run.

    Raises:
        KinemarkError: it may not.
    """
    if table.suffix.lower() != ".csv":
        raise KinemarkError(f"{table} is to be a table, which is CSV. Name a file that ends with .csv.")
    if table.resolve() in {other.resolve() for other in others if other is not None}:
        raise KinemarkError(f"{table} is also a trial of this run. Name another file for the table.")
    try:
        if table.exists() and not is_gaps_csv(table):
            raise KinemarkError(f"{table} exists and is no table of gaps. Name another file or remove it.")
    except OSError as error:
        raise KinemarkError(f"{table} cannot be read: {error}. Name another file for the table.") from error


def gaps_of(done: Mapping[Path, FilledFile | KinemarkError]) -> dict[str, Sequence[Mapping[str, Any]]]:
    """What became of the gaps of each file that was read."""
    return {str(source): one.figures["list"] for source, one in done.items() if isinstance(one, FilledFile)}


def own_name(source: Path) -> str:
    """What the result of a file is called in a folder."""
    return source.name if source.suffix.lower() in endings("trajectories") else f"{source.stem}.c3d"


def filled_figures(done: Mapping[Path, FilledFile | KinemarkError]) -> dict[str, Any]:
    """The figures of one file, or of many by their names; an error where one could not be filled."""
    each = {
        str(source): {"error": str(found)} if isinstance(found, KinemarkError) else found.figures
        for source, found in done.items()
    }
    return each if len(each) > 1 else next(iter(each.values()))


def filled_text(done: Mapping[Path, FilledFile | KinemarkError]) -> str:
    """What became of the files that could be read, as lines of text; of many also in all."""
    parts = []
    for source, found in done.items():
        if isinstance(found, FilledFile):
            lines = [
                *([f"{source}"] if len(done) > 1 else []),
                filling_summary(found.figures),
                *(f"note:     {file_note_text(note)}" for note in found.notes),
                f"results:  {', '.join(map(str, found.written))}",
            ]
            parts.append("\n".join(lines))
    return "\n\n".join([*parts, *([_in_all(done)] if len(done) > 1 else [])])


def _in_all(done: Mapping[Path, FilledFile | KinemarkError]) -> str:
    """How many gaps of how many files are filled, as the last line of a long text."""
    gaps = gaps_of(done)
    every = [gap for file in gaps.values() for gap in file]
    filled, unread = sum(bool(gap["method"]) for gap in every), len(done) - len(gaps)
    said = f"{len(done)} files: {sum(map(bool, gaps.values()))} had gaps, {filled} of {len(every)} gaps filled"
    return said + (f"; {unread} could not be used." if unread else ".")


def fill_method(name: str, parameters: Iterable[str] = (), *, model: Path | None = None) -> Any:
    """A method by its name and texts like "neighbours=5".

    Args:
        name: in `fill.FILL`. parameters: of it.
        model: an angle model's file, or another trial of the same motion, for the methods that place markers by the
            angles of limbs.

    Raises:
        KinemarkError: the method or a parameter is not known, a value is of the wrong kind, or the model is unusable.
    """
    try:
        table = overridden({}, [f"fill.{text}" for text in parameters])
        method = method_of("fill", {"method": name, **table.get("fill", {})})
    except ValidationError as error:
        row = error.errors()[0]
        raise KinemarkError(f"{'.'.join(map(str, row['loc']))}: {row['msg']}, found {row['input']!r}") from error
    except ValueError as error:
        raise KinemarkError(f"{error}. What there is: kinemark methods fill") from error
    return method if model is None else _with_model(method, name, angle_model(model))


def angle_model(path: Path) -> AngleModel:
    """The angle model in a file, or that of the trial in it.

    Raises:
        KinemarkError: the file is absent or damaged, or the trial has no segments or no cycle.
    """
    if path.suffix.lower() == ".csv" and read_text(path).startswith(",".join(FIRST)):
        return read_angle_model(path)
    try:
        return fit_model(MarkerArray.of(read_trial(path).trajectories)).model
    except KinemarkError as error:
        raise KinemarkError(f"No model can be made of {path}: {error}") from error


def _with_model(method: Any, name: str, model: AngleModel) -> Any:
    """The method with another trial's model."""
    if isinstance(method, Auto):
        own = [one if not isinstance(one, LimbAngles) else replace(one, model=model) for one in method.methods]
        return Auto(tuple(own))
    if isinstance(method, KalmanAngles):
        return replace(method, limbs=replace(method.limbs, model=model))
    if isinstance(method, LimbAngles):
        return replace(method, model=model)
    raise KinemarkError(f"{name} takes no model. Those that do are limb_angles, kalman_angles and auto.")


def _check(limit_mm: float | None, trim: int) -> None:
    """Raises a KinemarkError where a number is not one that it can be."""
    if limit_mm is not None and not limit_mm > 0:
        raise KinemarkError(f"The limit is {limit_mm} mm. Wanted is one above 0; inf fills all that can be filled.")
    if trim < 0:
        raise KinemarkError(f"trim is {trim}. Wanted is a number of samples, 0 for none.")
