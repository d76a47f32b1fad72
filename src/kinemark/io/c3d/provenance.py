"""Which samples of a file were filled, stated in a group of its own where C3D's own marks do not state it.

C3D marks a sample that was not measured by a residual of 0 and no camera. Where a file states no cameras at all, as
most do, every sample looks like that. KINEMARK:FILLED_POINTS then names the points, a row for each run of filled
samples, and KINEMARK:FILLED_FRAMES its first and last frame, counted as the file counts. A sample there counts as
filled as long as its residual is 0: what another program measured or filled anew in the meantime is not ours to mark.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...data import Origin, Trajectories
from ...data.array_types import Bools
from ...numerics.runs import true_runs
from .document import C3D
from .parameter_tables import with_numbers, with_text

GROUP, POINTS, FRAMES = "KINEMARK", "FILLED_POINTS", "FILLED_FRAMES"
LAST = np.array([0, 1])
"""From where a run begins and where it is over to its first and last frame; by definition."""


def stated_filled(doc: C3D, names: tuple[str, ...]) -> Bools:
    """(M, F) samples that the group says are filled; runs of unknown points or beyond the file are passed over."""
    filled = np.zeros((len(names), len(doc.points)), bool)
    points, frames = doc.texts(GROUP, POINTS), doc.numbers(GROUP, FRAMES)
    row = {name: i for i, name in enumerate(names)}
    runs = frames[: len(frames) // 2 * 2].reshape(-1, 2) - doc.first_frame
    for name, (first, last) in zip(points, runs, strict=False):
        if name in row and 0 <= first <= last < len(doc.points):
            filled[row[name], int(first) : int(last) + 1] = True
    return filled & (doc.word.T == 0)


def with_filled(doc: C3D, trajectories: Trajectories, shown: NDArray[np.uint8]) -> C3D:
    """The document with the group, where it needs one.

    Args:
        doc: the document with the points of the trajectories.
        trajectories: what it holds.
        shown: (M, F) an `Origin` each, what a reader of the document would take its samples for.
    """
    filled = np.array([path.origin == Origin.FILLED for path in trajectories]).reshape(shown.shape)
    if np.array_equal(filled, shown == Origin.FILLED):
        return doc
    names, frames = [], []
    for path, own in zip(trajectories, filled, strict=True):
        runs = true_runs(own)
        names += [path.name] * len(runs)
        frames += (runs - LAST + doc.first_frame).tolist()
    had = doc.texts(GROUP, POINTS)
    doc = with_text(doc, GROUP, POINTS, names, [-1] * len(names), had)
    return with_numbers(doc, GROUP, FRAMES, np.array(frames).reshape(-1, 2))
