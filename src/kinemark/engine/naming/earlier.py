"""Which trials of a session help to name another: a fixed order, so that names do not depend on what was run when.

Static trials come first, then those of the range of motion, then the others, each as the file lists them. A trial is
named by the template files and by all trials before it; without `grow` by those alone that are declared for it. In a
session without template files the trials that people named come before all others, so that it is no matter which trial
somebody names.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

from ...data import KinemarkError
from ...io.stated_names_csv import read_stated_names
from ..keys import digest, file_key
from ..settings import Settings, TrialEntry
from .claims import claims_of

RANK = {"static": 0, "range_of_motion": 1, "motion": 2}
"""Place of each kind of trial in the order; by definition."""
NAMED_BY_HAND = 4
"""Names that people gave to a trial's tracks by which it goes first; by definition: fewer make no template."""
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


def before(root: Path, settings: Settings, entry: TrialEntry | None) -> tuple[TrialEntry, ...]:
    """The trials whose names help this one, in their order; all that help any where None.

    There are none where the session says nothing of labelling.

    Args:
        root: folder of the session. settings: of it. entry: the trial.
    """
    if settings.label is None:
        return ()
    known = bool(settings.label.template or settings.label.static or settings.label_subjects)
    ordered = sorted(
        settings.trials, key=lambda one: (not known and not _by_hand(root, settings, one.name), RANK[one.kind])
    )
    names = [one.name for one in ordered]
    first = ordered if entry is None else ordered[: names.index(entry.name)]
    return tuple(one for one in first if settings.label.grow or one.kind != "motion")


def _by_hand(root: Path, settings: Settings, trial: str) -> bool:
    """Whether people named this trial's tracks, by claims or in the file of names."""
    names = {claim.name for claim in claims_of(root, trial)}
    if settings.label is not None and settings.label.names is not None:
        with suppress(KinemarkError):  # a run says what is wrong with the file
            names |= {one.name for one in read_stated_names(root / settings.label.names) if one.trial == trial}
    return len(names - {None, ""}) >= NAMED_BY_HAND


def template_files_key(root: Path, settings: Settings) -> str:
    """Of the contents of all files that `[label]` and `[label.subjects]` name."""
    label = settings.label
    assert label is not None  # else nobody asks
    files = [*label.template, *label.static, *([label.names] if label.names else [])]
    files += [file for one in settings.label_subjects.values() for file in (*one.template, *one.static)]
    return digest(file_key(*(root / file for file in files)))


def check_files_of_names(root: Path, settings: Settings, entry: TrialEntry) -> None:
    """Raises KinemarkError, which names all, where files of `[label]` for a trial are not in the session's folder."""
    absent = [file for file in dict.fromkeys(_named(settings, entry)) if not (root / file).is_file()]
    if absent:
        verb, they = ("is not a file", "it") if len(absent) == 1 else ("are no files", "them")
        raise KinemarkError(
            f"[label] names {', '.join(absent)}, which {verb} in {root}. Correct the path, or leave {they} out."
        )


def _named(settings: Settings, entry: TrialEntry) -> Iterator[str]:
    """The files by which the markers of a trial's subjects are named."""
    apart = [settings.of_subject(name) for name in settings.subjects_of(entry)] or [settings]
    for label in (one.label for one in apart):
        if label is not None:
            yield from (*label.template, *label.static, *((label.names,) if label.names else ()))
