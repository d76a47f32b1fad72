"""Points of a file that are no markers, put aside while its markers are named, and put back as they were."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from contextlib import suppress
from dataclasses import replace
from functools import lru_cache
from itertools import count, islice
from pathlib import Path
from typing import NamedTuple

from ..data import KinemarkError, MarkerTrajectory, Trajectories, Trial
from ..data.computed_points import computed_points
from ..io.c3d import modeled_points
from ..io.trial import read_trial

FILES = 3
"""Trials whose computed points are remembered, or tell of another's, a number; chosen: as many are looked at side by
side."""


class PutAside(NamedTuple):
    """Trajectories without the points that are no markers, and these."""

    rest: Trajectories
    aside: tuple[MarkerTrajectory, ...] = ()


def put_aside(trial: Trial, *, keep: Collection[str] = ()) -> PutAside:
    """The markers of a trial, and its computed points: those that are found, and those that its file says are modeled.

    Args:
        trial: of a file. keep: names that are none of them, whatever they look like, also with a subject's before them.
    """
    tracks = trial.trajectories
    found = {*computed_points(tracks), *modeled_points(trial.source)}
    away = {name for name in found if name not in keep and name.rpartition(":")[2] not in keep}
    rest = tracks.select([name for name in tracks.names if name not in away])
    return PutAside(rest, tuple(path for path in tracks if path.name in away)) if len(rest) else PutAside(tracks)


@lru_cache(maxsize=FILES)
def computed_names(trial: Trial) -> tuple[str, ...]:
    """Points of a file that are no markers, worked out once for each trial."""
    return tuple(path.name for path in put_aside(trial).aside)


def computed_in(files: Iterable[Path]) -> frozenset[str]:
    """Names of the computed points of the first few trials, of those that can be read.

    Not of what is a marker in one of them, as one that fell off in another and lay still; nor `*1`, which is another
    point in each file.
    """
    found, markers = set[str](), set[str]()
    for file in islice(files, FILES):
        with suppress(KinemarkError):
            points = put_aside(read_trial(file))
            found.update(path.name for path in points.aside)
            markers.update(points.rest.names)
    return frozenset(name for name in found - markers if not name.startswith("*"))


def put_back(done: Trajectories, aside: Collection[MarkerTrajectory]) -> Trajectories:
    """With the points that were put aside; one without a name gets another number where its own is taken."""
    taken = {*done.names, *(path.name for path in aside if not path.name.startswith("*"))}
    back = []
    for path in aside:
        name = path.name
        if name.startswith("*") and name in taken:
            name = next(f"*{k}" for k in count(1) if f"*{k}" not in taken)
        taken.add(name)
        back.append(replace(path, name=name))
    return replace(done, paths=(*done.paths, *back))
