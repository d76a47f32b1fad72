"""The methods of the joint angles and of the smoothing before them.

Those of ANGLES are called as `function(R, joint, locked, method=…)` with rotations R (F, 3, 3) and give angles (F, 3),
deg; those of SMOOTH as `function(path, rate, method=…)` with one marker and give it smoothed.
"""

from ..data.method import Stage

ANGLES = Stage("angles", "kinemark.kinematics", default="signed", meaning="joint angles from rotations")
SMOOTH = Stage("smooth", "kinemark.kinematics", default="butterworth", meaning="markers, smoothed before angles")
