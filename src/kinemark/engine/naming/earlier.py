"""Which trials of a session help to name another: a fixed order, so that names do not depend on what was run when.

Static trials come first, then those of the range of motion, then the others, each as the file lists them. A trial is
named by the template files and by all trials before it; without `grow` by those alone that are declared for it.
"""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

from ..keys import digest, file_key
from ..settings import Settings, TrialEntry

RANK = {"static": 0, "range_of_motion": 1, "motion": 2}
"""Place of each kind of trial in the order; by definition."""
ABSENT = "absent"
"""Stands for the key of a trial that could not be labelled."""


class Earlier(NamedTuple):
    """A trial before another.

    Attributes:
        name, kind: of the trial. folder: of its results.
        key: of its names; `ABSENT` where it has none.
    """

    name: str
    kind: str
    folder: Path
    key: str


def before(settings: Settings, entry: TrialEntry | None) -> tuple[TrialEntry, ...]:
    """The trials whose names help this one, in their order; all that help any where None.

    There are none where the session says nothing of labelling.
    """
    if settings.label is None:
        return ()
    ordered = sorted(settings.trials, key=lambda one: RANK[one.kind])
    names = [one.name for one in ordered]
    first = ordered if entry is None else ordered[: names.index(entry.name)]
    return tuple(one for one in first if settings.label.grow or one.kind != "motion")


def template_files_key(root: Path, settings: Settings) -> str:
    """Of the contents of all files that `[label]` and `[label.subjects]` name."""
    label = settings.label
    assert label is not None  # else nobody asks
    files = [*label.template, *label.static, *([label.names] if label.names else [])]
    files += [file for one in settings.label_subjects.values() for file in (*one.template, *one.static)]
    return digest(file_key(*(root / file for file in files)))
