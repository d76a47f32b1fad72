"""Bundle adjustment: all cameras, and all places of what they saw, at once (Brown 1958; Triggs et al. 2000).

adjust             what is fitted, and `bundle` for any mixture of cameras held and free and of parts
from_sizes         `calibrate_sticks`, `calibrate_points`: a rig from pixels and image sizes alone
initial/           the first guess of all cameras from which they start
lens_prior         what is usual of lenses
usual_terms        how far a rig's lenses are from that
parts              sticks, single points, points at known places
solver             least squares with the Schur complement
robust_adjustment  wrong points held at bay, then left out
robust_points      points in space from cameras of which some see them in the wrong place
misfit             what is said where cameras do not fit each other
stick_gaps         the gaps between a stick's markers as the images have them
parameter_covariance   of all cameras together
"""

from .adjust import Bundle, BundleFit, bundle
from .from_sizes import calibrate_points, calibrate_sticks
from .parts import FreePoints, KnownPoints, Part, Sticks, sticks_through
from .solver import Freedom

__all__ = [
    "Bundle",
    "BundleFit",
    "FreePoints",
    "Freedom",
    "KnownPoints",
    "Part",
    "Sticks",
    "bundle",
    "calibrate_points",
    "calibrate_sticks",
    "sticks_through",
]
