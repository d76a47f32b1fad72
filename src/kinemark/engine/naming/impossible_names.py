"""Labelled trials whose names cannot be, as a body is made: whoever is named by them has the same wrong names."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from ...data import KinemarkError, Trajectories, Trial, make_finding
from ...data.array_types import Floats
from ...data.finding import Finding
from ...data.laboratory_axes import shows_up
from ...gait.gait_trial import marker_points
from ...gait.marker_doubts import marker_doubts
from ...gait.standard_trial import standard_trial
from ...gait.upper_body_doubts import upper_body_doubts
from ...numerics.finite import finite_median

UPRIGHT = 1.5
"""Height of the pelvis above the ankles, in lengths from knee to ankle, from which a subject stands or walks; chosen:
it is 2 and more there, and 1 where somebody sits."""


def impossible_names(trials: Sequence[Trajectories], sources: Sequence[str]) -> Iterator[Finding]:
    """A finding for markers that cannot be where their names say, of trials that stand or walk.

    Args:
        trials: labelled, without the subject's prefix. sources: what each is called.
    """
    for trial, source in zip(trials, sources, strict=True):
        try:
            found = standard_trial(Trial(source, trial))
        except KinemarkError:  # nothing shows which way is up
            continue
        points = marker_points(found.trial)
        if not shows_up(points) or not _upright(points):
            continue
        legs = marker_doubts(points).exchanged
        turned = any(how in ("sides", "pelvis") for how, _ in legs)  # what is above has no front to be judged by
        for markers in (*(two for _, two in legs), *(() if turned else upper_body_doubts(points))):
            own = [found.known.get(name, name) for name in markers or sorted(found.known)]
            yield make_finding("template_names_impossible", markers=own, file=source)


def _upright(points: Mapping[str, Floats]) -> bool:
    """Whether the pelvis is high above one of the ankles most of the time."""
    for side in "LR":
        if {side + "ASI", side + "KNE", side + "ANK"} <= set(points):
            knees = [points[s + "KNE"] for s in "LR" if s + "KNE" in points]  # the nearer one, as sides may be wrong
            shank = finite_median(np.min([np.linalg.norm(knee - points[side + "ANK"], axis=-1) for knee in knees], 0))
            if finite_median((points[side + "ASI"] - points[side + "ANK"])[:, 2]) > UPRIGHT * shank:
                return True
    return False
