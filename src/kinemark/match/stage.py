"""The methods of matching, one a file beside this one; called as `function(detections, rig, method=…)`."""

from ..data.method import Stage

MATCH = Stage("match", "kinemark.match", default="epipolar_triplets", meaning="images of several cameras to markers")
