"""How far off a fill may be expected to be where nobody says it: less where what is measured is smaller than a person.

A hand's markers are 80 mm apart, an insect's 5: there a fill that is off by a person's marker, 20 mm, is worth nothing.
So with s, the median distance of two markers of a trial in one frame, the limit is

    LIMIT min(1, s / LEAST)                                                                               (1)

It is also what jumps (`judge.contradiction`) and uncertain gaps are measured by.
"""

from __future__ import annotations

import numpy as np

from ..data.array_types import Floats
from ..numerics.evenly import evenly

LIMIT = 20.0
"""mm of expected error above which a gap stays open; chosen: about a marker's diameter (see benchmarks/gaps.py)."""
LEAST = 200.0
"""mm, s of a person's markers at least; chosen: in seventeen trials of people it was 273 to 742 mm, of an arm 306."""
MOST = 50
"""Frames, and markers in each, evenly spread, that tell of s; chosen for time."""


def usual_limit(xyz: Floats) -> float:
    """(1) of markers (M, F, 3) mm, NaN where missing: mm; LIMIT where no two markers at different places are seen."""
    apart = [d for frame in evenly(xyz.shape[1], MOST) if (d := _median_distance(xyz[:, frame])) > 0]
    return LIMIT * min(1.0, float(np.median(apart)) / LEAST) if apart else LIMIT


def _median_distance(xyz: Floats) -> float:
    """Between two of markers (M, 3), mm; 0 where fewer are seen."""
    seen = xyz[~np.isnan(xyz[:, 0])]
    seen = seen[evenly(len(seen), MOST)]
    one, other = np.triu_indices(len(seen), 1)
    return float(np.median(np.linalg.norm(seen[one] - seen[other], axis=1))) if len(one) else 0.0
