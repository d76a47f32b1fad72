"""Cameras from nothing but their image sizes: a first guess from which a bundle adjustment converges.

growth           the guess itself: a pair of cameras, and growth from it
unknown_optics   what is assumed of a camera; lines straightened
view_pairs       which cameras see the same points, and their epipolar geometry
seeds            focal lengths and pose of a pair
rough_resection  a further camera from points that are known
odd_camera       which camera keeps all from fitting each other
"""

from .growth import TargetViews, start
from .unknown_optics import UnknownOptics, unknown_optics

__all__ = ["TargetViews", "UnknownOptics", "start", "unknown_optics"]
