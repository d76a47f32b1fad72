"""Filling the gaps of a file of trajectories, ours or another system's, and nothing else of it changed."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

from pydantic import ValidationError

from .data import KinemarkError, Trajectories, Trial
from .fill import LIMIT, Filled, fill
from .formats import WRITERS, read, write_trial
from .io.c3d import markers
from .io.tdf import Tdf
from .report.filling import filling_figures
from .report.filling_page import write_filling_page
from .settings.methods import method_of
from .settings.overrides import overridden


class FilledFile(NamedTuple):
    """What was written: the trial with its gaps filled, what became of each, and the figures of the page."""

    trial: Trial
    filled: Filled
    figures: dict[str, Any]


def fill_file(
    source: Path,
    target: Path,
    *,
    method: Any = None,
    name: str = "auto",
    limit_mm: float = LIMIT,
    ends: bool = False,
    static: Path | None = None,
    report: Path | None = None,
    rate_hz: float | None = None,
) -> FilledFile:
    """Fill the gaps of a trial's markers and write it; channels, events, angles and parameters stay as they were.

    Args:
        source: a C3D, TRC or CSV file of trajectories, or a BTS one that has some.
        target: the file to write, of any of the first three kinds; an existing one is not replaced.
        method: of `fill.METHODS`, with its parameters; `Auto()` where None. name: what the report calls it.
        limit_mm: gaps whose expected mean error is greater stay open.
        ends: also fill before a marker's first sample and after its last.
        static: a trial in which the markers are seen that are not seen in this one.
        report: a page to write on every gap; an existing one is replaced.
        rate_hz: of a CSV file that does not say it.

    Raises:
        KinemarkError: a file is absent, damaged or holds no trajectories, or the target exists.
    """
    if target.exists():
        raise KinemarkError(f"{target} exists, and nothing is overwritten. Name another file or remove it.")
    if target.suffix.lower() not in WRITERS["trajectories"]:
        raise KinemarkError(f"{target} wants one of the endings {', '.join(WRITERS['trajectories'])}.")
    trial = _trial(source, rate_hz)
    positions = markers(trial)
    if not len(positions):
        raise KinemarkError(f"{source} has no markers, so there is nothing to fill.")
    still = markers(_trial(static, rate_hz)) if static else None
    filled = fill(positions, method=method, limit_mm=limit_mm, ends=ends, static=still)
    figures = filling_figures(filled, positions, source=source.name, method=name, limit_mm=limit_mm)
    whole = with_markers(trial, filled.trajectories)
    write_trial(target, whole)
    if report:
        write_filling_page(report, figures=figures, trajectories=filled.trajectories)
    return FilledFile(whole, filled, figures)


def fill_method(name: str, parameters: Iterable[str] = ()) -> Any:
    """A method by its name and texts like "neighbours=5".

    Raises:
        KinemarkError: the method or a parameter is not known, or a value is of the wrong kind.
    """
    try:
        table = overridden({}, [f"fill.{text}" for text in parameters])
        return method_of("fill", {"method": name, **table.get("fill", {})})
    except ValidationError as error:
        row = error.errors()[0]
        raise KinemarkError(f"{'.'.join(map(str, row['loc']))}: {row['msg']}, found {row['input']!r}") from error
    except ValueError as error:
        raise KinemarkError(f"{error}. What there is: kinemark methods fill") from error


def with_markers(trial: Trial, changed: Trajectories) -> Trial:
    """The trial with these markers in the place of those of their names; the others, and all else, stay."""
    new = {path.name: path for path in changed}
    paths = [new.pop(path.name, path) for path in trial.trajectories]
    return replace(trial, trajectories=replace(trial.trajectories, paths=(*paths, *new.values())))


def _trial(path: Path, rate_hz: float | None) -> Trial:
    """The trial in a file."""
    found = read(path, what="trajectories" if path.suffix.lower() == ".csv" else None, rate_hz=rate_hz)
    if isinstance(found, Tdf) and found.trajectories is not None:
        return Trial(path.stem, found.trajectories, found.analog, found.plates, found.events)
    if not isinstance(found, Trial):
        raise KinemarkError(f"{path} holds no trajectories. Wanted are those of a C3D, TRC, CSV or BTS file.")
    return found
