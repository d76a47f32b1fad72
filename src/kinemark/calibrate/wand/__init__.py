"""A wand waved through the volume: its markers in the images, the cameras from them, its length as these see it.

identify     which detection is which marker, in all cameras
rows         of them, of one image: markers in a row with the wand's gaps
ends         which end is which, where the gaps do not tell
calibrate    the cameras
completion   markers that the first reading left out, once there is a first rig
lengths      how long the wand comes out, place by place, and the error to expect
"""

from .calibrate import KNOWN_LENS, Wand, calibrate_wand
from .few_poses import thinned
from .identify import marker_places, wand_points
from .lengths import WandLengths, wand_lengths

__all__ = [
    "KNOWN_LENS",
    "Wand",
    "WandLengths",
    "calibrate_wand",
    "marker_places",
    "thinned",
    "wand_lengths",
    "wand_points",
]
