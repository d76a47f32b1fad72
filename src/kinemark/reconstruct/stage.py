"""The methods of reconstruction, each in a file of its own beside this one.

They are called as `function(matches, detections, rig, method=…)`.
"""

from ..data.method import Stage

RECONSTRUCT = Stage("reconstruct", "kinemark.reconstruct", default="least_squares", meaning="matched images to points")
