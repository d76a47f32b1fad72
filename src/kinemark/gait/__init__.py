"""From named markers, force plates and EMG to gait: segments, angles, ground reaction, moments and powers.

`lower_limbs` is the conventional gait model, `clinical_angles` what clinicians read of it, `reaction` and `contacts`
the force plates and the feet on them, `joint_loads` inverse dynamics.
"""

from .clinical_angles import clinical_angles, progression
from .clinical_moments import clinical_force, clinical_moment
from .inverse_dynamics import GroundContact, JointLoad, five_point, five_point_slope, joint_loads
from .lower_limb import Leg, LowerLimbs, lower_limbs, with_static_offsets
from .plate_contacts import Contact, contacts
from .reaction import Reaction, reaction
from .segment_inertia import INERTIAS, SegmentInertia
from .segments import Segment

__all__ = [
    "INERTIAS",
    "Contact",
    "GroundContact",
    "JointLoad",
    "Leg",
    "LowerLimbs",
    "Reaction",
    "Segment",
    "SegmentInertia",
    "clinical_angles",
    "clinical_force",
    "clinical_moment",
    "contacts",
    "five_point",
    "five_point_slope",
    "joint_loads",
    "lower_limbs",
    "progression",
    "reaction",
    "with_static_offsets",
]
