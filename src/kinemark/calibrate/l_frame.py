"""An L-frame on the floor, which says where the world is: a corner marker and one or more on each arm.

The arms are at right angles. Which marker is which follows from the distances between them. X runs along the long arm,
Z up, to the side where the cameras are.

It stands still while it is recorded. A marker's place in F frames has the error of one frame, and their mean 1/√F of
what noise it has; so every frame is read, those in which it stands elsewhere than in most are left out, and the rest
is averaged (`resting_l_frame`).
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import permutations
from typing import NamedTuple

import numpy as np

from ..data import KinemarkError, Rig
from ..data.array_types import Bools, Floats
from ..numerics.evenly import evenly
from .world_frame import similarity

MOST = 12  # points in which the frame is looked for at most; chosen, as all orders are tried
MOST_FRAMES = 200
"""Frames that are read, evenly spread; more would not make a mean better than the calibration is; chosen for speed."""
MOVED = 5.0
"""Times the median distance of its markers from their medians: the L-frame, or what is taken for it, was moved.
Chosen."""
MM_PER = {"m": 1000.0, "cm": 10.0, "inches": 25.4}  # by definition
SAME_UNIT = 0.05  # share by which a ratio of lengths may be off that of units; chosen: no two are nearer
STILL = 0.002  # of its longest distance; smaller movements do no harm; chosen


class RestingLFrame(NamedTuple):
    """An L-frame over F frames.

    seen: (m, 3) its markers in the rig's world, the mean over frames; known: (m, 3) mm, where they are in its own;
    frames: in how many it was recognised; moved: in how many of these it stood elsewhere; off: how far at most, mm.
    """

    seen: Floats
    known: Floats
    frames: int
    moved: int
    off: float


def l_frame(
    rig: Rig,
    xyz: Floats,
    *,
    long: float | Sequence[float],
    short: float | Sequence[float],
    height: float = 0.0,
    tolerance: float = 0.02,
    scale: bool = False,
    cameras_above: bool = True,
) -> Floats:
    """Where the markers of an L-frame are in its world, (M, 3) mm, for `moved_to`; NaN for points that are none of it.

    Args:
        rig: the cameras; most of them are above the floor.
        xyz: (M, 3) points that were seen, of which some are the L-frame's.
        long: distance of the marker on the long arm from the corner, or of several, mm. X runs along it.
        short: the same of the short arm.
        height: of the markers' centres above the floor, mm.
        tolerance: share of the longest distance by which the others may be off.
        scale: whether only the distances' proportions are right, as after `calibrate_points`.
        cameras_above: whether Z points to the side of the L-frame's plane on which the cameras are, else away.

    Raises:
        ValueError: a distance is not positive, or the arms have markers at the same distances.
        KinemarkError: the L-frame is not among the points, or more than once.
    """
    model = _model(long, short)
    rows = _recognised(xyz, model, tolerance, scale)
    known = np.full((len(xyz), 3), np.nan)
    known[rows] = _facing(rig, xyz[rows], model, scale, cameras_above) + np.array([0.0, 0.0, height])
    return known


def resting_l_frame(
    rig: Rig,
    frames: Sequence[Floats],
    *,
    long: float | Sequence[float],
    short: float | Sequence[float],
    height: float = 0.0,
    tolerance: float = 0.02,
    scale: bool = False,
) -> RestingLFrame:
    """An L-frame that rests over F frames, from the points (n, 3) seen in each; the rest as in `l_frame`.

    Raises:
        ValueError: as `l_frame`.
        KinemarkError: as `l_frame`, where no frame shows it: of that with most nearly as many points as it has markers.
    """
    model = _model(long, short)
    read, trouble = list[Floats](), list[tuple[int, KinemarkError]]()
    for f in evenly(len(frames), MOST_FRAMES):
        try:
            read.append(frames[f][_recognised(frames[f], model, tolerance, scale)])
        except KinemarkError as error:
            trouble.append((abs(int(np.isfinite(frames[f]).all(1).sum()) - len(model)), error))
    if not read:
        nothing = KinemarkError("No frame shows any marker.")
        raise min(trouble, key=lambda each: each[0], default=(0, nothing))[1]
    places = np.array(read)
    distance = np.linalg.norm(places - np.median(places, axis=0), axis=2).max(1)
    rests: Bools = distance <= max(MOVED * float(np.median(distance)), STILL * float(_distances(places).max()))
    seen = places[rests].mean(0)
    known = _facing(rig, seen, model, scale, cameras_above=True) + np.array([0.0, 0.0, height])
    mm = float(_distances(known).max() / _distances(seen).max())  # a unit of the rig's world
    return RestingLFrame(seen, known, len(places), int((~rests).sum()), mm * float(distance.max()))


def _model(long: float | Sequence[float], short: float | Sequence[float]) -> Floats:
    """The markers (m, 3) mm on the floor, the corner first, the short arm along +Y."""
    arms = np.atleast_1d(np.asarray(long, np.float64)), np.atleast_1d(np.asarray(short, np.float64))
    if any(not (arm > 0).all() or len(np.unique(arm)) < len(arm) for arm in arms) or set(arms[0]) == set(arms[1]):
        raise ValueError(f"arms are {arms[0].tolist()} and {arms[1].tolist()} mm, wanted different distances above 0")
    model = np.zeros((1 + len(arms[0]) + len(arms[1]), 3))
    model[1 : 1 + len(arms[0]), 0] = arms[0]
    model[1 + len(arms[0]) :, 1] = arms[1]
    return model


def _facing(rig: Rig, seen: Floats, model: Floats, scale: bool, cameras_above: bool) -> Floats:
    """The model (m, 3) as it was seen (m, 3): with the short arm along −Y where else the cameras were below."""
    A, b, s = similarity(seen, model, scale=scale)
    centres = s * rig.centres @ A.T + b
    turned = (np.median(centres[:, 2]) > 0) != cameras_above
    return model * np.array([1.0, -1.0 if turned else 1.0, 1.0])


def _recognised(xyz: Floats, model: Floats, tolerance: float, scale: bool) -> list[int]:
    """Which points (M, 3) are the model's (m, 3), by the distances between them."""
    there = np.flatnonzero(np.isfinite(xyz).all(1))
    if not len(model) <= len(there) <= MOST:
        raise KinemarkError(
            f"{len(there)} points are seen, and the L-frame has {len(model)} markers. Show it to the cameras alone "
            f"(at most {MOST} points)."
        )
    wanted = _distances(model)
    choices = np.array(list(permutations(there, len(model))))
    found = _distances(xyz[choices])
    if scale:
        found = found * ((found * wanted).sum(-1) / np.maximum((found**2).sum(-1), 1e-300))[:, None]
    difference = np.abs(found - wanted).max(-1) / wanted.max()
    best = np.argsort(difference)[:2]
    if not difference[best[0]] <= tolerance:
        advice = _advice(found, wanted, tolerance, alone=len(there) == len(model))
        raise KinemarkError(
            f"No {len(model)} of {len(there)} points have the L-frame's distances: the best are off by "
            f"{difference[best[0]] * wanted.max():.1f} mm. {advice}"
        )
    if len(best) > 1 and difference[best[1]] <= tolerance:
        raise KinemarkError(
            "The L-frame's markers can be taken in two ways: its distances are too much alike, or there are points "
            "beside it. Use arms of unequal lengths, or a smaller tolerance."
        )
    return [int(i) for i in choices[best[0]]]


def _advice(found: Floats, wanted: Floats, tolerance: float, *, alone: bool) -> str:
    """What to do where no choice of points has the wanted distances (d): found are those of each (n, d).

    Where the L-frame is not alone, some points are like it by chance, in some size, but hardly in that of a unit.
    """
    times = (found * wanted).sum(-1) / (wanted**2).sum()
    off = np.abs(found - times[:, None] * wanted).max(-1) / np.maximum(times * wanted.max(), 1e-300)
    likest = np.argmin(off)
    unit = _as_if(times[likest])
    if off[likest] <= tolerance / 2 and (alone or unit):
        return (
            f"All are {times[likest]:.3f} times as long{unit}: correct lengths_mm of the wand, or the "
            "distance, that gives the scale, or arms_mm."
        )
    return "Check its lengths, and that all its markers are seen."


def _as_if(times: float) -> str:
    """Which unit was probably taken for mm, where what is seen is so many times as long as it should be."""
    for unit, mm in MM_PER.items():
        for whose, ratio in (("lengths that give the scale", 1 / mm), ("L-frame's arms", mm)):
            if abs(times / ratio - 1) < SAME_UNIT:
                return f", as if the {whose} were stated in {unit}"
    return ""


def _distances(points: Floats) -> Floats:
    """(…, m (m − 1) / 2) between all pairs of points (…, m, 3)."""
    i, j = np.triu_indices(points.shape[-2], 1)
    return np.asarray(np.linalg.norm(points[..., i, :] - points[..., j, :], axis=-1))
