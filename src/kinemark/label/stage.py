"""The methods of labelling, each in a file of its own beside this one.

Called as `function(trajectories, template, method=…, stated=…)`, and gives `Labels`.
"""

from ..data.method import Stage

LABEL = Stage("label", "kinemark.label", default="distances", meaning="names of markers for tracks without")
