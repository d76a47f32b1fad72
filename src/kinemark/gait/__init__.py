"""From named markers, force plates and EMG to gait: segments, angles, ground reaction, moments and powers.

`lower_limbs` is the conventional gait model, `clinical_angles` what clinicians read of it, `reaction` and `contacts`
the force plates and the feet on them, `joint_loads` inverse dynamics. `analyse_gait` does all of it for a trial;
`calibrated_body` has clusters of markers carry segments;
`standard_trial` brings another laboratory's names and axes to the model's; `foot_events`, `strides` and `gait_curves`
cut it into strides.
"""

from .clinical_angles import clinical_angles
from .clinical_moments import clinical_force, clinical_moment
from .clusters import CalibratedBody, calibrated_body, with_wands
from .estimated_measures import estimated_measures, mass_on_plates
from .foot_events import foot_events
from .functional_hip import FunctionalHip, functional_hip, with_functional_hips
from .gait_cycles import gait_curves
from .gait_methods import Physical, PlugInGait
from .gait_trial import GaitTrial, analyse_gait, marker_points
from .inverse_dynamics import GroundContact, JointLoad, five_point, five_point_slope, joint_loads, spline_acceleration
from .lower_limb import Leg, LowerLimbs, lower_limbs
from .plate_contacts import Contact, contacts
from .progression import progression
from .reaction import Reaction, reaction
from .segment_inertia import INERTIAS, SegmentInertia
from .segments import Segment
from .standard_trial import StandardTrial, standard_trial, with_heels, with_landmarks
from .static_trial import with_static_offsets
from .time_distance import strides

__all__ = [
    "INERTIAS",
    "CalibratedBody",
    "Contact",
    "FunctionalHip",
    "GaitTrial",
    "GroundContact",
    "JointLoad",
    "Leg",
    "LowerLimbs",
    "Physical",
    "PlugInGait",
    "Reaction",
    "Segment",
    "SegmentInertia",
    "StandardTrial",
    "analyse_gait",
    "calibrated_body",
    "clinical_angles",
    "clinical_force",
    "clinical_moment",
    "contacts",
    "estimated_measures",
    "five_point",
    "five_point_slope",
    "foot_events",
    "functional_hip",
    "gait_curves",
    "joint_loads",
    "lower_limbs",
    "marker_points",
    "mass_on_plates",
    "progression",
    "reaction",
    "spline_acceleration",
    "standard_trial",
    "strides",
    "with_functional_hips",
    "with_heels",
    "with_landmarks",
    "with_static_offsets",
    "with_wands",
]
