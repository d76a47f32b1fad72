"""The methods of tracking, each in a file of its own beside this one.

Those that take a cloud of points are called as `function(cloud, method=…)`; those that take "detections" match at the
same time, and are called as `function(detections, rig, method=…)`.
"""

from ..data.method import Method, Stage

TRACK = Stage("track", "kinemark.track", default="simultaneous", meaning="markers followed from frame to frame")

DETECTIONS, CLOUD = "detections", "cloud"
"""What a method of tracking takes."""


def matches_itself(method: Method) -> bool:
    """Whether a method of tracking takes detections, so that nothing is matched before.

    Raises:
        ValueError: it is no method of tracking.
    """
    return TRACK.of(method).takes == DETECTIONS
