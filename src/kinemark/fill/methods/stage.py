"""The methods of filling, each in a file of its own beside this one.

A filler is called as `filler(motion, gaps, method=…)` and says a `Prediction` of each gap.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, Self

from ...data.method import Method, Stage
from ..judge.hold_out import Filler
from ..marker_array import Gap, MarkerArray

FILL = Stage("fill", "kinemark.fill", default="auto", meaning="missing samples of trajectories")


@dataclass(frozen=True, slots=True)
class FillMethod(Method):
    """Base of all methods of filling; a method says where it is not like most.

    Attributes:
        automatic: whether `auto` tries it.
        together: its answer for one gap hangs on the others asked with it, as it fills on from those.
        slow: it looks at the whole trial for each hold-out gap.
    """

    automatic: ClassVar[bool] = True
    together: ClassVar[bool] = False
    slow: ClassVar[bool] = False

    def for_many_gaps(self, gaps: Sequence[Gap], source: MarkerArray | None) -> Self:
        """The method itself, or a faster form of it where there are many gaps.

        Args:
            gaps: all that are to be filled.
            source: the trial from which it learns once for them all; each fill learns by itself when None.
        """
        return self


def filler_of(method: FillMethod) -> Filler:
    """What does a method.

    Raises:
        ValueError: it is no method that fills.
    """
    return FILL.function(method)


def automatic() -> tuple[str, ...]:
    """Names of the methods that `auto` tries."""
    kinds = {name: declared.kind for name, declared in FILL.items()}
    return tuple(name for name, kind in kinds.items() if issubclass(kind, FillMethod) and kind.automatic)
