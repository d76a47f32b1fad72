"""The gait report of a session, `results/gait`: what `kinemark gait` makes of the C3D files of its walks.

It is made after the trials, and again when one of their files or `[gait]` changed.
"""

from __future__ import annotations

import shutil
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from ...data import KinemarkError
from ...io.files import read_json, write_json
from ...report.words import sentences_of
from ..keys import code_key, digest, file_key
from ..settings import Settings
from ..settings.tables import GaitTable
from .files import FIGURES, PAGE, gait_of_files
from .trial_files import SubjectFiles

FOLDER = "gait"
KEY, REASON = "made_of", "not_computed"
"""In the figures: the key of what they were made of; why there are none."""


def update_gait(root: Path, results: Path, settings: Settings, *, self_contained: bool) -> dict[str, Any] | None:
    """The session's gait as it is now: its figures, or the reason why there are none.

    Args:
        root: of the session. results: its folder of results. settings: of the session.
        self_contained: the page holds the drawing library.

    Returns:
        The figures; `{"not_computed": reason}` where gait cannot be computed; None where the session has no `[gait]`,
        or none of its walks was processed yet.

    Raises:
        KinemarkError: the folder cannot be written.
    """
    table = settings.gait
    walks = [] if table is None else _files(results, _walks(settings, table))
    if table is None or not walks:
        return None
    static = next(iter(_files(results, [t.name for t in settings.trials if t.kind == "static"])), None)
    moved = next(iter(_files(results, [table.functional])), None) if table.functional else None
    strong = next(iter(_files(results, [table.mvc])), None) if table.mvc else None
    inputs = [root / path for path in (table.measures, table.reference) if isinstance(path, Path)]
    key = digest(
        code_key(), table, file_key(*walks, *(one for one in (static, moved, strong) if one), *inputs), self_contained
    )
    folder = results / FOLDER
    known = read_gait(results)
    if known is not None and known.get(KEY) == key:
        return known
    try:
        if table.functional and moved is None:
            raise KinemarkError(f"[gait] functional names the trial {table.functional!r}, which was not processed.")
        if table.mvc and strong is None:
            raise KinemarkError(f"[gait] mvc names the trial {table.mvc!r}, which was not processed.")
        given = SubjectFiles(
            walks, static=static, functional=moved, mvc=strong, measures=table.stated_measures(root),
            reference=None if table.reference is None else root / table.reference, markers=table.markers,
            clusters=table.clusters,
        )  # fmt: skip
        how, exports = table.settings(), table.exports
        figures = gait_of_files(
            given, folder=folder, exports=exports, settings=how, self_contained=self_contained
        ).figures
    except KinemarkError as error:
        shutil.rmtree(folder, ignore_errors=True)  # of another state of the session
        figures = {REASON: str(error)}
    return _kept(folder / FIGURES, figures | {KEY: key})


def read_gait(results: Path) -> dict[str, Any] | None:
    """The figures of the session's gait, or the reason why there are none; None where nothing is there."""
    return read_json(results / FOLDER / FIGURES) or None


def gait_page(results: Path) -> Path | None:
    """The session's gait page, where there is one."""
    page = results / FOLDER / PAGE
    return page if page.is_file() else None


def gait_headline(figures: dict[str, Any]) -> str:
    """One sentence of it."""
    if REASON in figures:
        return str(figures[REASON])
    return next(iter(sentences_of(figures["verdict"])), "")


def _walks(settings: Settings, table: GaitTable) -> Sequence[str]:
    motion = [trial.name for trial in settings.trials if trial.kind == "motion"]
    return table.trials or [name for name in motion if name not in (table.functional, table.mvc)]


def _files(results: Path, names: Sequence[str]) -> list[Path]:
    """The C3D files of trials that were processed."""
    found = [results / name / f"{name}.c3d" for name in names]
    return [path for path in found if path.is_file()]


def _kept(path: Path, figures: dict[str, Any]) -> dict[str, Any]:
    """The figures, written."""
    path.parent.mkdir(parents=True, exist_ok=True)
    write_json(path, figures)
    return figures
