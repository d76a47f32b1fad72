"""The limb as a stick figure that moves and can be seen from any side, drawn by the script of `stick.html`.

Points are given along the laboratory's forward, right and up, whatever its axes are called, so that "from the front"
means the same in every laboratory. The script turns and draws them; no library and no graphics card is needed.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..data import Angles
from ..data.array_types import Floats
from ..findings.plain import plain
from ..kinematics import Model, named_angles, outside
from ..kinematics.chain import Points, laboratory
from .theme import hue, shortened

MOST_FRAMES = 900
"""Frames drawn; more are thinned evenly; chosen."""
MOST_NUMBERS = 36_000
"""Of all points and angles in all frames drawn; chosen (see benchmarks/pages.py)."""
TAIL_S = 0.7
"""How long a path stays behind its marker; chosen."""


def stick_data(points: Points, angles: Angles, model: Model, *, first_frame: int = 1) -> dict[str, Any]:
    """What the script draws: points by frame, links, floor, angles."""
    names = [name for name in dict.fromkeys(p for link in links(model) for p in link) if name in points]
    n_frames = angles.deg.shape[1]
    numbers = 3 * len(names) + 3 * len(named_angles(model))  # coordinates; angle, standard deviation, mark
    by = max(1, -(-n_frames // MOST_FRAMES), -(-n_frames * numbers // MOST_NUMBERS))
    basis = laboratory(model)[:, [0, 2, 1]]  # forward, right, up
    xyz = np.array([points[name][::by] for name in names]).reshape(len(names), -1, 3) @ basis
    place = {name: i for i, name in enumerate(names)}
    kept = [(place[a], place[b]) for a, b in links(model) if a in place and b in place]
    seen = xyz[np.isfinite(xyz).all(-1)]
    corners = np.array([seen.min(0), seen.max(0)]) if len(seen) else np.array([[-500.0] * 3, [500.0] * 3])
    step = by / angles.rate
    return {
        "names": shortened(names),
        "colours": [hue(i) for i in range(len(names))],
        "frames": _frames(xyz),
        "links": [[i, j, "#7A8794"] for i, j in kept],
        "trails": list(range(len(names))),
        "tail": max(2, round(TAIL_S / step)),
        "start": (first_frame - 1) / angles.rate,
        "step": step,
        "middle": plain(corners.mean(0).round(1)),
        "radius": round(max(float(np.linalg.norm(corners[1] - corners[0])) / 2, 50.0), 1),
        "pitch": _pitch(corners),
        "floor": _floor(corners),
        "marks": _marks(corners),
        "angles": _angles(angles, model, by),
        "locked": angles.locked[:, ::by].astype(int).tolist(),
    }


def links(model: Model) -> tuple[tuple[str, str], ...]:
    """The pairs that are joined: the model's own, or the vectors of its axes where it names none."""
    if model.links:
        return model.links
    ends = [axis.points[:2] for segment in model.segments for axis in (segment.first, segment.second)]
    return tuple(dict.fromkeys((a, b) for a, b in ends))


def _frames(xyz: Floats) -> list[list[Any]]:
    """By frame and point, mm with one decimal, None where missing."""
    rows = xyz.transpose(1, 0, 2).round(1)
    known = np.asarray(np.isfinite(rows).all(-1))
    return [
        [p.tolist() if k else None for p, k in zip(row, seen, strict=True)]
        for row, seen in zip(rows, known, strict=True)
    ]


def _pitch(corners: Floats) -> float:
    """Width of a square of the floor, mm."""
    return 100.0 if np.ptp(corners, axis=0).max() < 1500 else 500.0


def _extent(corners: Floats) -> tuple[Floats, Floats]:
    """Least and greatest corner, moved out to whole squares."""
    pitch = _pitch(corners)
    return np.floor(corners[0] / pitch) * pitch, np.ceil(corners[1] / pitch) * pitch


def _floor(corners: Floats) -> list[Any]:
    """A level grid under all that moves."""
    (low, high), pitch = _extent(corners), _pitch(corners)
    z = low[2]
    across = [[[f, low[1], z], [f, high[1], z]] for f in np.arange(low[0], high[0] + 1, pitch).tolist()]
    along = [[[low[0], r, z], [high[0], r, z]] for r in np.arange(low[1], high[1] + 1, pitch).tolist()]
    return plain(across + along)


def _marks(corners: Floats) -> list[Any]:
    """Words at the edge of the floor."""
    low, high = _extent(corners)
    middle, out = (low + high) / 2, 0.4 * _pitch(corners)
    spots = {
        "front": [high[0] + out, middle[1], low[2]],
        "back": [low[0] - out, middle[1], low[2]],
        "right": [middle[0], high[1] + out, low[2]],
        "left": [middle[0], low[1] - out, low[2]],
    }
    return [[word, plain(np.array(spot))] for word, spot in spots.items()]


def _angles(angles: Angles, model: Model, by: int) -> list[dict[str, Any]]:
    """A row a joint and a row a degree of freedom."""
    rows: list[dict[str, Any]] = []
    out, sd = outside(angles, model), angles.sd
    for j, joint in enumerate(angles.joints):
        rows.append({"name": joint, "joint": j})
        for one in named_angles(model):
            if one.joint == j:
                place = (j, slice(None, None, by), one.turn)
                values = {"deg": plain(angles.deg[place].round(2)), "sd": plain(sd[place].round(4))}
                rows.append({"name": one.motion.name, "joint": j, **values, "out": out[place].astype(int).tolist()})
    return rows
