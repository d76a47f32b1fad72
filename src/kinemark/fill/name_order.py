"""Markers in the order of their names, so that fills do not depend on the order in which a file lists them.

Hold-out gaps are drawn one gap after the other from one series of random numbers, share copies of the trial as they
come, and stand for others where there are many gaps. In the order of a file the same trial would be filled otherwise
when another program has written it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from ..data import Trajectories


def by_name(trajectories: Trajectories) -> Trajectories:
    """The same markers in the order of their names; those of one name in the order of the trial."""
    return replace(trajectories, paths=tuple(trajectories.paths[k] for k in _order(trajectories.names)))


def as_before(trajectories: Trajectories, before: Trajectories) -> Trajectories:
    """What `by_name` made of a trial, in the order of that trial."""
    paths = dict(zip(_order(before.names), trajectories.paths, strict=True))
    return replace(trajectories, paths=tuple(paths[k] for k in range(len(paths))))


def _order(names: Sequence[str]) -> list[int]:
    return sorted(range(len(names)), key=lambda k: names[k])
