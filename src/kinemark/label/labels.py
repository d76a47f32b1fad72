"""The result of labelling."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from ..data import MarkerTrajectory, Origin, Trajectories
from ..data.arrays import column, set_columns
from ..data.finding import Finding
from ..data.short_repr import ShortRepr

State = Literal["sure", "unsure", "unknown"]
"""sure: the name can be used; unsure: it is the best, but another may be right; unknown: there is none."""


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Labels(ShortRepr):
    """Of T tracks.

    Attributes:
        names: (T) the marker that each most likely is; None where none explains it better than chance.
        probability: (T) that the name is right; 0 without one.
        state: (T) sure, unsure or unknown.
        runner_up: (T) the marker that comes second; None where that is none.
        margin: (T) nats by which the name is better than the runner-up; NaN without name.
        fit: score of the whole trial as a share of what the template scores on its own data.
        placed: samples that have a name, as a share of those that could have one.
        refused: why nothing is named; None where the template fits.
        against: (T) of names that are not sure, the markers whose distance speaks most for the runner-up, and by how
            many nats; empty where none does. They say what to look at.
        undecided: that left and right of the whole subject cannot be told; None where they can.
        another: times as tall this subject is as the template's, where that was given as this one's and is not; else
            None. No name is sure then.
        displaced: markers that sit beside their places in the template, and by how many mm: put on anew, or others.
            Their names are as sure as without it.
    """

    names: tuple[str | None, ...]
    probability: NDArray[np.float64]
    state: tuple[State, ...]
    runner_up: tuple[str | None, ...]
    margin: NDArray[np.float64]
    fit: float
    placed: float
    refused: Finding | None = None
    against: tuple[tuple[tuple[str, float], ...], ...] = ()
    undecided: Finding | None = None
    another: float | None = None
    displaced: tuple[tuple[str, float], ...] = ()

    def __post_init__(self) -> None:
        n = len(self.names)
        set_columns(
            self,
            names=tuple(self.names),
            state=tuple(self.state),
            runner_up=tuple(self.runner_up),
            against=tuple(self.against) or ((),) * n,
            probability=column("probability", self.probability, np.float64, n),
            margin=column("margin", self.margin, np.float64, n),
        )
        lengths = {name: len(getattr(self, name)) for name in ("state", "runner_up", "against")}
        if set(lengths.values()) != {n}:
            raise ValueError(f"there are {n} names and, of other columns, {lengths}, wanted as many")

    def __len__(self) -> int:
        return len(self.names)


def named(trajectories: Trajectories, labels: Labels, *, unsure: bool = False) -> Trajectories:
    """The trial with its tracks named: the pieces of a marker become one trajectory; the others stay, as `*1`, `*2`, …

    Args:
        trajectories: those that were labelled.
        labels: of them, in the same order.
        unsure: also take names that are not sure.

    Raises:
        ValueError: there are other numbers of labels than of tracks.
    """
    if len(labels) != len(trajectories):
        raise ValueError(f"there are {len(labels)} labels and {len(trajectories)} tracks, wanted one each")
    wanted = ("sure", "unsure") if unsure else ("sure",)
    taken = [name if state in wanted else None for name, state in zip(labels.names, labels.state, strict=True)]
    pieces: dict[str, list[MarkerTrajectory]] = {}
    for name, path in zip(taken, trajectories, strict=True):
        if name is not None:
            pieces.setdefault(name, []).append(path)
    rest = [path for name, path in zip(taken, trajectories, strict=True) if name is None]
    whole = [_joined(name, pieces[name]) for name in sorted(pieces)]
    return replace(trajectories, paths=(*whole, *(replace(path, name=f"*{k}") for k, path in enumerate(rest, 1))))


def _joined(name: str, pieces: list[MarkerTrajectory]) -> MarkerTrajectory:
    """One trajectory of pieces that are seen one after the other."""
    columns = {
        key: getattr(pieces[0], key).copy() for key in ("xyz", "cov", "origin", "residual", "cameras", "detection")
    }
    for piece in pieces[1:]:
        rows = piece.origin != Origin.MISSING
        for key, values in columns.items():
            if values.shape[1:] == getattr(piece, key).shape[1:]:
                values[rows] = getattr(piece, key)[rows]
    return replace(pieces[0], name=name, **columns)
