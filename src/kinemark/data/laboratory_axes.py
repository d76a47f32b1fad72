"""Which axis of a laboratory goes up, as markers of pelvis and feet show it, and trials in other axes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from .array_types import Floats
from .errors import KinemarkError
from .trial import Trial

STEEP = 0.8
"""Least part of the way from ankles to pelvis along an axis, as a share, for the axis to be up; chosen: walkers lean
by less than 0.05, a laboratory that stands askew by 45° is 0.71."""


PELVIS = ("LASI", "RASI")
"""Above; conventional names of the gait model."""
FEET = (("LANK", "RANK"), ("LHEE", "RHEE"), ("LTOE", "RTOE"))
"""Below, the first that are seen: a walk whose shanks follow clusters may have no ankles; conventional names."""
ONE_FOOT = tuple((name,) for pair in FEET for name in pair)
"""Where one leg alone has markers: it is 0.1 of its length aside of the pelvis' middle, far less than askew."""


def unit(v: Floats) -> Floats:
    """(…, 3) with length 1; NaN where it has none."""
    length = np.linalg.norm(v, axis=-1, keepdims=True)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.where(length > 0, v / length, np.nan)


def level_axes(up: Floats) -> Floats:
    """(3, 3) that brings vectors (…, 3) to axes whose third is `up`, as `v @ level_axes(up)`."""
    other = np.eye(3)[np.abs(up).argmin()]
    x = unit(other - (other @ up) * up)
    return np.stack([x, np.cross(up, x), up], -1)


def up_shown(points: Mapping[str, Floats]) -> Floats:
    """(3) the axis from the feet to the pelvis; z where markers are missing, which is said elsewhere.

    Args:
        points: (F, 3) mm by the model's names.

    Raises:
        KinemarkError: it is along no axis.
    """
    way = _from_the_feet(points)
    if way is None:
        return axis_of("z")
    k = int(np.abs(way).argmax())
    if abs(way[k]) < STEEP:
        raise KinemarkError(
            f"From the feet to the pelvis it goes by {', '.join(f'{x:.2f}' for x in way)} along x, y and z, so that "
            "no axis is up. Turn the laboratory's axes so that one is, or say which is meant: --up z."
        )
    return np.asarray(np.sign(way[k]) * np.eye(3)[k])


def shows_up(points: Mapping[str, Floats]) -> bool:
    """Whether markers, (F, 3) mm by the model's names, show which way goes up."""
    return _from_the_feet(points) is not None


def _from_the_feet(points: Mapping[str, Floats]) -> Floats | None:
    """(3) of length 1 from the lowest pair of markers to the front of the pelvis; None where none is seen, or both are
    at one place, as where a file has the same numbers for all."""
    above = _middle(points, PELVIS)
    below = next((at for pair in (*FEET, *ONE_FOOT) if (at := _middle(points, pair)) is not None), None)
    return None if above is None or below is None or np.array_equal(above, below) else unit(above - below)


def _middle(points: Mapping[str, Floats], some: tuple[str, ...]) -> Floats | None:
    """(3) mm between the median places of markers; None where one is never seen."""
    seen = [points[name][np.isfinite(points[name]).all(1)] for name in some if name in points]
    if len(seen) < len(some) or not all(len(xyz) for xyz in seen):
        return None
    return np.asarray(sum(np.median(xyz, axis=0) for xyz in seen) / len(some))


def axis_of(up: str) -> Floats:
    """(3) an axis by its name, as "y", "+Y" or "-x"."""
    up = up.lower()
    return np.asarray((-1.0 if up[0] == "-" else 1.0) * np.eye(3)["xyz".index(up[-1])])


def turned(trial: Trial, turn: Floats) -> Trial:
    """Markers and plates in other axes; vectors (…, 3) times `turn`."""
    paths = tuple(replace(p, xyz=p.xyz @ turn, cov=turn.T @ p.cov @ turn) for p in trial.trajectories)
    plates = tuple(replace(plate, corners=plate.corners @ turn) for plate in trial.plates)
    return replace(trial, trajectories=replace(trial.trajectories, paths=paths), plates=plates)
