"""What a standing trial tells of a subject: offsets of the feet, and axes of knees and ankles where it shows them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from ..data import KinemarkError
from ..data.array_types import Floats
from ..data.subject_measures import LETTER, SIDES, TO_THE_LEFT, LegMeasures, Side, SubjectMeasures
from ..kinematics import principal
from .clusters import with_wands
from .hip_centre import HipCentre
from .lower_limb import FOOT_SEQUENCE, LowerLimbs, leg_seen, lower_limbs
from .segments import Z_UP, mean_length, relative, upright
from .static_axes import with_knees, with_static_axes


def with_static_offsets(
    measures: SubjectMeasures,
    static: Mapping[str, Floats],
    *,
    flat_foot: bool,
    hip_centre: HipCentre = "davis",
    axes: bool = True,
) -> SubjectMeasures:
    """The measures with all that a static trial shows of the legs, means over its frames.

    Offsets of both feet; wands and torsions where knee alignment devices or markers inside of the joints are there.

    Args:
        measures: of the subject.
        static: (F, 3) mm by name, a standing trial.
        flat_foot: the sole is flat on the floor: HEE counts as high as TOE, and higher by the sole's difference.
        hip_centre: the regression.
        axes: knee alignment devices and markers inside of the joints, where there are, turn the wands back.

    Raises:
        KinemarkError: a marker is not there, or no frame has all that a foot needs.
    """
    static = with_wands(with_knees(static))
    if axes:
        measures = with_static_axes(measures, static, hip_centre=hip_centre)
    limbs = lower_limbs(static, measures, hip_centre=hip_centre)
    asis = measures.asis_mm or mean_length(static["LASI"] - static["RASI"])
    left, right = (_with_offsets(measures, limbs, static, side, flat_foot) for side in SIDES)
    return replace(measures, left=left, right=right, asis_mm=asis)


def _with_offsets(
    measures: SubjectMeasures, limbs: LowerLimbs, static: Mapping[str, Floats], side: Side, flat: bool
) -> LegMeasures:
    own, leg = measures.leg(side), limbs.leg(side)
    if not leg_seen(static, side):
        return own  # nobody wears markers there
    heel, toe = static[LETTER[side] + "HEE"], static[LETTER[side] + "TOE"]
    if flat:
        lift = ((toe - heel) @ Z_UP)[..., None] + own.sole_mm
        heel = heel + lift * Z_UP
    stood = upright(toe, heel - toe, leg.shank.R[..., 1])
    deg = principal(relative(leg.bare_foot.R, stood.R), FOOT_SEQUENCE)
    known = np.isfinite(deg).all(-1)
    if not known.any():
        raise KinemarkError(
            f"No frame of the static trial shows the whole {side} leg, so that its foot has no offsets. "
            "Give another static trial, or state the offsets."
        )
    plantar, rotation, _ = deg[known].mean(0)
    return replace(own, plantar_offset_deg=-plantar, rotation_offset_deg=-TO_THE_LEFT[side] * rotation)
