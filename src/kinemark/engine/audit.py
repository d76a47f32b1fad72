"""Files of other systems audited: what is probably wrong with their tracks and names, and mended where that is sure.

Nothing is changed in a file. What is mended stands in the journal beside it, act by act, and can be taken back;
`editing.files.write_edited` writes another file with it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ..data import KinemarkError
from ..data.problems import Alternative, Problem, Problems
from ..label import Template
from .editing.files import open_editing
from .folders import check_folder
from .problems import problems
from .put_aside import computed_names

SURE = 0.9
"""Probability from which on a problem is mended without a person; chosen: one act of ten may have to be undone."""
WHY = "kinemark audit"
ROUNDS = 5
"""Times that a file is looked at again after it was mended, at most; chosen: one error may hide another."""


class Audit(NamedTuple):
    """What was found in a file, as it is after mending, what was mended, and names of points that are no markers
    (`computed_names`), which are not looked at."""

    found: Problems
    mended: tuple[Problem, ...] = ()
    aside: tuple[str, ...] = ()


def audit_file(source: Path, *, template: Template | None = None, mend: bool = False, by: str = "") -> Audit:
    """What is probably wrong with a file of trajectories, or a trial of a session.

    Args:
        source: the file, or SESSION/TRIAL. template: of the subject; what the file is itself like where None.
        mend: take the best alternative of whatever is SURE to be wrong. by: who says it.

    Raises:
        KinemarkError: it cannot be read, has no samples, its journal cannot be written, or the template does not fit.
    """
    editing = open_editing(source, by=by)
    if not np.isfinite(editing.trajectories.xyz).any():
        names = len(editing.trajectories)
        lacks = f"has {names} markers, of which none is ever seen" if names else "has no trajectories"
        raise KinemarkError(f"{source} {lacks}. Give a file of markers in space, as a C3D file.")
    mended = list[Problem]()
    for _ in range(ROUNDS if mend else 0):
        found = problems(editing, template=template, one_by_one=True)
        sure = _beside_each_other([one for one in found.asked if one.wrong >= SURE and _mends(one)])
        if not sure:
            break
        for one in sure:
            editing.say(*_best(one).edits, why=f"{WHY}: {one.words}")
        mended += sure
    found = problems(editing, template=template)
    return Audit(found, tuple(mended), computed_names(editing.source) if editing.source else ())


def audit_files(
    sources: Sequence[Path],
    *,
    template: Template | None = None,
    mend: bool = False,
    by: str = "",
    announce: Callable[[Path], None] = lambda source: None,
) -> dict[Path, Audit | KinemarkError]:
    """Each of many; an error stands in the place of one that cannot be audited.

    Args:
        sources: files, or SESSION/TRIAL. template, mend, by: as `audit_file` takes them.
        announce: is called with each before it is looked at.

    Raises:
        KinemarkError: the only one cannot be.
    """
    done: dict[Path, Audit | KinemarkError] = {}
    for source in sources:
        announce(source)
        try:
            check_folder(source)
            done[source] = audit_file(source, template=template, mend=mend, by=by)
        except KinemarkError as error:
            if len(sources) == 1:
                raise
            done[source] = error
    return done


def _mends(one: Problem) -> bool:
    """Whether the best that can be said changes anything."""
    return _best(one).action not in ("keep", "note")


def _best(one: Problem) -> Alternative:
    return one.alternatives[0]


def _beside_each_other(some: Sequence[Problem]) -> list[Problem]:
    """Those that are about different tracks: what one says changes what others are called."""
    kept, used = list[Problem](), set[str]()
    for one in some:
        if not used & set(one.tracks):
            kept.append(one)
            used |= set(one.tracks)
    return kept
