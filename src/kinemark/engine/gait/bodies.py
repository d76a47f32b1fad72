"""Whether all files of a gait report are of one body with the same markers, and the standing trial stands."""

from __future__ import annotations

from collections.abc import Sequence

from ...findings.gait_subjects import BodyOfTrial
from ...gait.marker_doubts import MarkerDoubts, marker_doubts
from ...gait.same_body import body_change, steps_mm
from .doubts import worn_points
from .walks import Recorded


def bodies_of(walks: Sequence[Recorded], static: Recorded | None, functional: Recorded | None) -> list[BodyOfTrial]:
    """What of the bodies in files is to be told; the standing trial, else the first walk, is what others are held to.

    Args:
        walks: of one subject. static: a standing trial. functional: a motion that turns the hips.
    """
    files = [one for one in (static, *walks, functional) if one is not None]
    points = [worn_points(one.trial, one.points) for one in files]
    names = [marker_doubts(own) for own in points]
    found = []
    for one, own, doubts in zip(files, points, names, strict=True):
        wrong = doubts.exchanged or names[0].exchanged  # of such markers the distances are others'
        change = None if one is files[0] or wrong else body_change(points[0], own)
        steps = steps_mm(own) if one is static else 0.0
        told = doubts if one is static or one is functional else MarkerDoubts()  # walks tell their own
        found.append(BodyOfTrial(one.name, told, files[0].name, change, steps))
    return found
