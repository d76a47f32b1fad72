"""What is compiled from C where there is a compiler: the inner loops of detection and tracking, on plain arrays.

Every function checks dtypes, shapes and indices in one declaration, so that no input can crash the process, and then
calls the compiled library or, where that is absent or `KINEMARK_PLAIN` is set, does the same with NumPy.
"""

from .compiled_library import PLAIN, Status, library, status
from .group_pixels import GroupPixels, cut_pixels, group_peaks, sum_peaks
from .image_index import ImageIndex, candidates, index_images
from .pixel_clusters import cluster_pixels
from .pixel_runs import find_runs
from .pixel_sums import sum_pixels
from .point_motion import predict, update
from .point_projection import information, project
from .ray_intersection import intersect
from .run_groups import group_runs
from .symmetric3 import inverse

__all__ = [
    "PLAIN",
    "GroupPixels",
    "ImageIndex",
    "Status",
    "candidates",
    "cluster_pixels",
    "cut_pixels",
    "find_runs",
    "group_peaks",
    "group_runs",
    "index_images",
    "information",
    "intersect",
    "inverse",
    "library",
    "predict",
    "project",
    "status",
    "sum_peaks",
    "sum_pixels",
    "update",
]
