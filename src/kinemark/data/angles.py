"""Joint angles, what each is called and its normal range, and cycles of them.

A trial holds them as `signals`, a quantity a joint.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from .array_types import Bools, Floats
from .arrays import column, set_columns
from .models import JointMotion, Model
from .short_repr import ShortRepr
from .signals import Signal, Signals


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Angles(ShortRepr):
    """J joints over F frames.

    Attributes:
        joints: (J) names.
        sequence: (J) order of the three turns, such as "zxy".
        deg: (J, F, 3) deg, NaN where missing.
        cov: (J, F, 3, 3) deg², NaN where unknown.
        rate: Hz.
        locked: (J, F) whether the first and third turn cannot be distinguished (gimbal lock); False where not given.
    """

    joints: tuple[str, ...]
    sequence: tuple[str, ...]
    deg: Floats
    cov: Floats
    rate: float
    locked: Bools = field(default_factory=lambda: np.zeros((0, 0), np.bool_))

    def __post_init__(self) -> None:
        n, f = len(self.joints), self.deg.shape[1]
        locked = self.locked if self.locked.size else np.zeros((n, f), np.bool_)
        set_columns(
            self,
            joints=tuple(self.joints),
            sequence=tuple(self.sequence),
            deg=column("deg", self.deg, np.float64, n, f, 3),
            cov=column("cov", self.cov, np.float64, n, f, 3, 3),
            locked=column("locked", locked, np.bool_, n, f),
        )
        if len(self.sequence) != n:
            raise ValueError(f"sequence has {len(self.sequence)} entries, wanted {n}")

    @property
    def sd(self) -> Floats:
        """(J, F, 3) deg, the standard deviation of each angle, NaN where unknown."""
        return np.sqrt(np.diagonal(self.cov, axis1=-2, axis2=-1))

    @property
    def time(self) -> Floats:
        """(F) seconds from the first frame."""
        return np.arange(self.deg.shape[1]) / self.rate

    def __getitem__(self, joint: str) -> Floats:
        """(F, 3) deg of one joint."""
        if joint not in self.joints:
            raise KeyError(f"no joint {joint!r}; there are {', '.join(self.joints)}")
        return self.deg[self.joints.index(joint)]

    def signals(self, axes: Sequence[Sequence[str]] = ()) -> Signals:
        """Each joint as a quantity.

        Args:
            axes: (J) three names each of the angles; the letters of the sequence where not given.
        """
        named = axes or self.sequence
        rows = zip(self.joints, named, self.deg, self.cov, strict=True)
        return Signals(tuple(Signal(n, "angle", "deg", tuple(a), self.rate, v, c) for n, a, v, c in rows))


class NamedAngle(NamedTuple):
    """One angle that a model gives a name to: its joint, its place in the sequence, and its words."""

    joint: int
    turn: int
    motion: JointMotion


def named_angles(model: Model) -> tuple[NamedAngle, ...]:
    """The degrees of freedom of a model, in the order of its joints."""
    return tuple(
        NamedAngle(j, t, motion)
        for j, joint in enumerate(model.joints)
        for t, motion in enumerate(joint.motions)
        if motion is not None
    )


def outside(angles: Angles, model: Model) -> Bools:
    """(J, F, 3) whether an angle is beyond its normal range; False where the range or the angle is unknown."""
    out = np.zeros(angles.deg.shape, np.bool_)
    for j, t, motion in named_angles(model):
        if motion.normal is not None:
            low, high = motion.normal
            with np.errstate(invalid="ignore"):
                out[j, :, t] = (angles.deg[j, :, t] < low) | (angles.deg[j, :, t] > high)
    return out


class Cycles(NamedTuple):
    """The angles of J joints over N cycles.

    Attributes:
        deg: (N, J, 101, 3) deg; sd: (N, J, 101, 3) deg, propagated from the markers.
        mean: (J, 101, 3) deg over the cycles; spread: (J, 101, 3) deg, standard deviation of a cycle, NaN with one
            alone; noise: (J, 101, 3) deg, standard deviation of the mean by the measurement.
        spans: (N, 2) s where each begins and ends.
    """

    deg: Floats
    sd: Floats
    mean: Floats
    spread: Floats
    noise: Floats
    spans: Floats
