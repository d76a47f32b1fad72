"""The markers of a trial through time, small enough for a page, for the script that plays them.

Places are whole numbers q of a step s about an origin o, so that a coordinate takes two bytes:

    x = o + s q,    s ≥ (greatest distance from o) / 32000                  (1)
"""

from __future__ import annotations

from base64 import b64encode
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..data import Trajectories
from ..findings.markers import positions, present
from .theme import shortened

MOST_PLACES = 6000
"""Of all markers in all frames that are played; chosen (see benchmarks/pages.py)."""
MOST_FRAMES = 400  # that are played; chosen
FINEST = 0.1  # mm; step of a coordinate; chosen
GREATEST = 32000
"""Of the whole numbers in (1), without unit; a little less than sixteen bits hold, by definition."""


def motion(trajectories: Trajectories, up: int, *, trace: int) -> dict[str, Any]:
    """What the script plays, coordinates in the order of `scene3d.stand_upright`.

    Args:
        trajectories: with at least one sample.
        up: which axis of the world points upwards.
        trace: index of the trace that moves.
    """
    order = [(up + 1) % 3, (up + 2) % 3, up]
    xyz, there = positions(trajectories)[..., order], present(trajectories)
    frames = _frames(there)
    frame, marker = np.nonzero(there[:, frames].T)
    places = xyz[marker, frames[frame]]
    origin = (places.min(0) + places.max(0)) / 2
    step = max(FINEST, float(np.abs(places - origin).max()) / GREATEST)  # (1)
    return {
        "trace": trace,
        "names": shortened(trajectories.names),
        "time": [round(float(t), 3) for t in trajectories.time[frames]],
        "starts": np.searchsorted(frame, np.arange(len(frames) + 1)).tolist(),
        "marker": _packed(marker, "<u2"),
        "xyz": _packed(np.rint((places - origin) / step), "<i2"),
        "origin": origin.round(1).tolist(),
        "step": step,
    }


def _frames(there: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Frames at equal steps from the first to the last in which any marker (M, F) is there, as many as may play."""
    seen = np.flatnonzero(there.any(0))
    first, last = int(seen[0]), int(seen[-1]) + 1
    by = max(1, -(-(last - first) // MOST_FRAMES))
    by = max(by, -(-int(there[:, first:last].sum()) // MOST_PLACES))
    return np.arange(first, last, by)


def _packed(values: NDArray[Any], kind: str) -> str:
    return b64encode(np.ascontiguousarray(values, kind).tobytes()).decode()
