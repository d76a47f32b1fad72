"""The table of fillers: every method is a frozen object of parameters, and its type tells which function fills."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from ..judge.hold_out import MANY as MANY
from ..judge.hold_out import Filler
from ..marker_array import Gap, MarkerArray
from .angles import KalmanAngles, LimbAngles, fill_kalman_angles, fill_limb_angles, learned_of
from .body import Body, common_hyper, fill_body
from .cyclic import Cyclic, fill_cyclic
from .kalman_predictor import Kalman, fill_kalman
from .local_regression import LocalRegression, fill_local_regression
from .low_rank_kalman import LowRankKalman, fill_low_rank_kalman
from .pattern import Pattern, fill_pattern
from .pca import PCA, fill_pca
from .polynomials import Cubic, Linear, fill_cubic, fill_linear
from .quintic import Quintic, fill_quintic
from .relational import Relational, fill_relational
from .rigid_body import RigidBody, fill_rigid_body

FILLERS: dict[type, Filler] = {
    Linear: fill_linear,
    Cubic: fill_cubic,
    Quintic: fill_quintic,
    Pattern: fill_pattern,
    RigidBody: fill_rigid_body,
    Cyclic: fill_cyclic,
    Relational: fill_relational,
    LimbAngles: fill_limb_angles,
    KalmanAngles: fill_kalman_angles,
    Kalman: fill_kalman,
    PCA: fill_pca,
    LowRankKalman: fill_low_rank_kalman,
    LocalRegression: fill_local_regression,
    Body: fill_body,
}
"""`filler(motion, gaps, *, method) -> list[Prediction]`, by type of method."""

NAMES: dict[str, type] = {
    "linear": Linear,
    "cubic": Cubic,
    "quintic": Quintic,
    "pattern": Pattern,
    "rigid_body": RigidBody,
    "cyclic": Cyclic,
    "relational": Relational,
    "limb_angles": LimbAngles,
    "kalman_angles": KalmanAngles,
    "kalman": Kalman,
    "pca": PCA,
    "low_rank_kalman": LowRankKalman,
    "local_regression": LocalRegression,
    "body": Body,
}
"""What settings and the command line call them."""

TRIED = tuple(name for name in NAMES if name != "kalman_angles")
"""Those that `Auto` tries; `limb_angles` does all that the thesis' own algorithm does, and better."""

TOGETHER = (LimbAngles, KalmanAngles)
"""Methods whose answer for one gap hangs on the others asked with it: they fill on from those."""

SLOW = 600_000
"""Gaps times frames above which limb angles, which look at the whole trial for each hidden test, are not tried."""


def affordable(methods: Sequence[Any], gaps: int, frames: int) -> list[Any]:
    """Those of the methods to choose from that a trial of so many gaps and frames leaves time for."""
    quick = [method for method in methods if not isinstance(method, LimbAngles)]
    return quick if quick and gaps * frames > SLOW else list(methods)


def within_time(method: Any, gaps: list[Gap], source: MarkerArray | None) -> Any:
    """The method itself, or a faster form of it where there are many gaps.

    Args:
        method: of filling.
        gaps: all that are to be filled.
        source: the trial from which it learns once for them all; each fill learns by itself when None.
    """
    if len(gaps) <= MANY:
        return method
    if isinstance(method, Body):
        quick = replace(method, donors=min(method.donors, 12), bases=1, frames=min(method.frames, 75))
        return quick if method.hyper or not source else replace(quick, hyper=common_hyper(source, gaps, method=quick))
    if isinstance(method, LimbAngles) and source and not (method.model or method.learned):
        return replace(method, learned=learned_of(source, method=method))
    if isinstance(method, Kalman):
        return replace(method, history=min(method.history, 0.25))
    return method


def name_of(method: Any) -> str:
    """The name of a method's type.

    Raises:
        ValueError: it is not in the table.
    """
    for name, kind in NAMES.items():
        if type(method) is kind:
            return name
    raise ValueError(f"{method!r} is no method of filling; there are {', '.join(NAMES)}")
