"""What made a joint angle leap: the marker without whose own leap it would not have.

Each marker in turn is bridged over a few frames by the parabola through its frames before and after (1), and the angle
is worked out anew. The marker by which the angle changes most is the one that made it (2).
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ...data import KinemarkError, MarkerTrajectory, Trajectories
from ...data.array_types import Floats
from ...data.models import Model
from ...kinematics import Template, joint_angles
from ...kinematics.chain import places_of, wanted_markers
from ...kinematics.sequences import AngleMethod

CORE = 3
"""Frames before and after the leap that are bridged with it; chosen: a wrong match lasts a few."""
BESIDE = 8
"""Frames on each side from which the bridge is drawn; chosen."""
NEAR = 3
"""Frames about a click within which the leap is looked for; chosen: 1000 frames on a screen are 1 px each."""
FEWEST = 4
"""Known frames beside it, without which nothing is bridged; chosen: one more than a parabola has numbers."""


class SpikeCause(NamedTuple):
    """Where an angle leapt and why.

    Attributes:
        at: index of the frame, from 0.
        marker: the one that made it, as the trial calls it; change_deg: by how much the angle is less without its leap.
        others: the other markers and what they change, deg, the largest first.
    """

    at: int
    marker: str
    change_deg: float
    others: tuple[tuple[str, float], ...]


def spike_cause(
    trajectories: Trajectories,
    *,
    model: Model,
    joint: int,
    turn: int,
    index: int,
    template: Template | None = None,
    method: AngleMethod | None = None,
) -> SpikeCause:
    """The marker that made the angle of a joint leap near a frame.

    Args:
        trajectories: of the trial, not smoothed.
        model, template, method: as `joint_angles` takes them.
        joint, turn: which angle of the model. index: of the frame that is meant, from 0.

    Raises:
        KinemarkError: there is no such angle or frame, or nothing to compare it with.
    """
    if not (0 <= joint < len(model.joints) and 0 <= turn < 3 and 0 <= index < trajectories.n_frames):
        raise KinemarkError(f"The model {model.name!r} has no angle {turn + 1} of joint {joint + 1} in that frame.")
    start = max(0, index - NEAR - CORE - BESIDE)
    window = _cut(trajectories, start, index + NEAR + CORE + BESIDE + 1)
    places = places_of(window, wanted_markers(model, template), model)

    def angle(of: Trajectories) -> Floats:
        return joint_angles(of, model=model, template=template, method=method).deg[joint, :, turn]

    deg = angle(window)
    deviation = np.array([_deviation(deg, k) if abs(k + start - index) <= NEAR else np.nan for k in range(len(deg))])
    if np.isnan(deviation).all():
        raise KinemarkError("The angle is missing there, or too few frames beside it have it.")
    at = int(np.nanargmax(deviation))
    changes = {}
    for i in places.values():
        path = _bridged(window.paths[i], at)
        paths = tuple(path if k == i else old for k, old in enumerate(window.paths))
        changed = float(_turned(deg[at] - angle(replace(window, paths=paths))[at]))
        changes[path.name] = abs(changed) if np.isfinite(changed) else 0.0
    order = sorted(changes.items(), key=lambda one: -one[1])  # (2)
    return SpikeCause(at + start, *order[0], tuple(order[1:]))


def _cut(trajectories: Trajectories, start: int, stop: int) -> Trajectories:
    """Some frames of a trial."""
    paths = [
        MarkerTrajectory.measured(path.name, path.xyz[start:stop], cov=path.cov[start:stop]) for path in trajectories
    ]
    return Trajectories(tuple(paths), trajectories.rate, trajectories.first_frame + start)


def _deviation(deg: Floats, at: int) -> float:
    """How far an angle (F,) deg is from its bridge in a frame; NaN where either is unknown."""
    known = np.isfinite(deg)
    whole = deg.copy()
    whole[known] = np.unwrap(deg[known], period=360.0)
    return abs(float(whole[at] - _parabola(whole[:, None], at)[at, 0]))


def _bridged(path: MarkerTrajectory, at: int) -> MarkerTrajectory:
    """A marker without what it does about a frame (1)."""
    core = _core(len(path.xyz), at)
    xyz = path.xyz.copy()
    xyz[core] = _parabola(xyz, at)[core]
    return MarkerTrajectory.measured(path.name, xyz, cov=path.cov)


def _core(n: int, at: int) -> slice:
    return slice(max(0, at - CORE), min(n, at + CORE + 1))


def _parabola(values: Floats, at: int) -> Floats:
    """(F, k) by the parabola through values (F, k) beside a frame; NaN where too few are known."""
    n, core = len(values), _core(len(values), at)
    beside = np.array(np.isfinite(values).all(1))
    beside[core] = False
    beside[: max(0, core.start - BESIDE)] = False
    beside[core.stop + BESIDE :] = False
    if beside.sum() < FEWEST:
        return np.full(values.shape, np.nan)
    t = (np.arange(n) - at) / BESIDE
    A = np.stack([np.ones(n), t, t**2], 1)
    return np.asarray(A @ np.linalg.lstsq(A[beside], values[beside], rcond=None)[0])


def _turned(deg: float) -> float:
    """A difference of angles without whole turns, deg."""
    return float((deg + 180) % 360 - 180)
