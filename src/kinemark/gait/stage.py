"""The methods of gait analysis.

Called as `function(trial, measures, method=…)` with a `Trial` whose markers have names and `SubjectMeasures`, and
give a `GaitTrial`.
"""

from ..data.method import Stage

GAIT = Stage("gait", "kinemark.gait", default="physical", meaning="angles, moments and powers of walking")
