"""Which files of a gait report count, and whether these are of one person: by what they say, by the body they show."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

from ..data import Finding, make_finding
from ..gait.marker_doubts import MarkerDoubts
from ..gait.marker_leaps import MarkerLeaps
from ..gait.same_body import BodyChange
from .gait_doubts import of_doubts


class BodyOfTrial(NamedTuple):
    """The body that a file shows, as far as something of it is to be told.

    Attributes:
        trial: its name. names: what of its markers' names cannot be, where it is no walk.
        like: the trial that it is held to. change: how it differs from that; None where it does not.
        steps_mm: by which the legs of a standing trial bend; 0 where they do not.
    """

    trial: str
    names: MarkerDoubts
    like: str
    change: BodyChange | None
    steps_mm: float = 0.0


def of_left_out(unusable: Mapping[str, str], repeated: Mapping[str, str]) -> Iterator[Finding]:
    """Findings of walks that do not count.

    Args:
        unusable: why they cannot be used. repeated: which other walk is the same recording. Both by their names.
    """
    yield from (make_finding("gait_walk_left_out", trial=trial, why=why) for trial, why in unusable.items())
    yield from (make_finding("gait_walk_repeated", trial=trial, other=other) for trial, other in repeated.items())


def of_bodies(bodies: Sequence[BodyOfTrial]) -> Iterator[Finding]:
    """Findings of the bodies in files."""
    for body in bodies:
        yield from of_doubts(body.trial, body.names, MarkerLeaps())
        if body.steps_mm:
            yield make_finding("gait_static_moves", trial=body.trial, by_mm=body.steps_mm)
        if (change := body.change) is not None:
            yield make_finding(
                "gait_bodies_differ", trial=body.trial, other=body.like, most_mm=abs(change.most_mm),
                rms_mm=change.rms_mm, pairs_list=[f"{a}–{b}" for a, b in change.pairs],
            )  # fmt: skip


def of_subjects(stated: Mapping[str, str]) -> Iterator[Finding]:
    """A finding where files state different subjects.

    Args:
        stated: the subject by the name of each file, walks and standing trial; empty where a file states none.
    """
    each: dict[str, list[str]] = {}
    for file, subject in stated.items():
        if plain := " ".join(subject.split()).casefold():
            each.setdefault(plain, []).append(file)
    if len(each) > 1:
        told = [f"{stated[files[0]]} ({', '.join(files)})" for files in each.values()]
        yield make_finding("gait_subjects_differ", subjects_list=told)
