"""What else the names of whole markers could be, and how much worse that is: chains and rings of names, of any length.

Where a marker sits far from where the template foretells it, its neighbour can take its name, the next one the
neighbour's, and so on to a label that is absent: each name is wrong, and each supports the next, so that no exchange of
two shows it. So each marker in turn is denied the name that it has. The best assignment of names to all markers by
`arrange` (1) without that one tells, of what hangs on that marker, who takes its name, whose name it takes, and so on,
to a label or a marker that had none, or back to where it began; this alone is changed. A label loses

    r = min over the labellings that change it of  S(as it is) − S(changed),   at least 0,                          (1)

nats, with S the sum of `arrange` (1), scored anew for each, as names that have moved support each other.
"""

from __future__ import annotations

import numpy as np
import scipy

from ..data.array_types import Floats, Ints
from .arrange import ABSENT, TEMPER, Markers, markers_of, moved_places, nats_of, own_places, sum_of
from .evidence import PairScore
from .shape import Shapes
from .stretches import FREE, Stretches
from .template import Template

FRAMES = 10
"""In which labellings are scored; chosen: places hardly change in a trial."""


def lost_to_rivals(stretches: Stretches, label: Ints, template: Template, pairs: PairScore) -> Floats:
    """(L) nats (1) of labels; infinite where no marker has one, no other labelling changes it, or nothing is foretold.

    Args:
        label: (T) of tracks, −1 for none. What was stated of tracks, `stretches.fixed`, is changed in none.
    """
    shapes, out = Shapes.of(template, by_body=True), np.full(len(template), np.inf)
    if not shapes.known.any() or not (label >= 0).any():
        return out
    markers = markers_of(stretches, label, len(template))
    markers = markers._replace(xyz=markers.xyz[:: max(1, len(markers.xyz) // FRAMES)])
    now, placed = markers.label, own_places(markers, markers.label, shapes)
    most = sum_of(markers, now, shapes, pairs, placed)
    stated = np.isin(np.arange(len(now)), markers.of[stretches.fixed != FREE])
    for other in rivals(now, _worths(markers, shapes, pairs)):
        changed = other != now
        if not (changed & stated).any():
            own = now[changed & (now >= 0)]
            moved = moved_places(markers, now, other, shapes, placed)
            out[own] = np.minimum(out[own], max(most - sum_of(markers, other, shapes, pairs, moved), 0.0))
    return out


def _worths(markers: Markers, shapes: Shapes, pairs: PairScore) -> list[Floats]:
    """(M, L) of `arrange` (1) above what an absent label costs, by places alone and with distances."""
    share = np.isfinite(markers.xyz[..., 0]).mean(0)[:, None]
    return [share * (nats_of(markers, markers.label, shapes, pairs, part) + ABSENT) for part in (0.0, TEMPER)]


def rivals(now: Ints, worths: list[Floats]) -> list[Ints]:
    """(M) labellings, in each of which one marker does not have the name that it has now, each once.

    Args:
        now: (M) labels of markers, −1 for none. worths: (M, L) each, what a marker is worth as a label; 0 as absent.
    """
    out: dict[bytes, Ints] = {}
    for worth in worths:
        gain = np.maximum(worth, 0.0)
        for m in np.flatnonzero(now >= 0).tolist():
            kept = gain[m, now[m]]
            gain[m, now[m]] = 0.0
            rows, columns = scipy.optimize.linear_sum_assignment(-gain)
            new, good = np.full(len(now), -1), gain[rows, columns] > 0
            new[rows[good]] = columns[good]
            gain[m, now[m]] = kept
            moved = _hanging_on(m, now, new)
            out.setdefault(moved.tobytes(), moved)
    return list(out.values())


def _hanging_on(m: int, now: Ints, new: Ints) -> Ints:
    """(M) labels now, with what hangs on marker m as it is in the new ones."""
    out, at = now.copy(), m
    while at >= 0:  # m takes a name, who had it the next
        out[at] = new[at]
        had = np.flatnonzero((now == new[at]) & (new[at] >= 0))
        at = int(had[0]) if len(had) else -1
        if at == m:
            return out
    left = int(now[m])
    while left >= 0:  # who takes the name of m, and what that one leaves
        takes = np.flatnonzero(new == left)
        if not len(takes):
            break
        out[takes[0]] = left
        left = int(now[takes[0]])
    return out
