"""The methods by which an operator digitises images; called as `drive` says."""

from ..data.method import Stage

DIGITISE = Stage("digitise", "kinemark.digitise", default="semi_automatic", meaning="markers named by an operator")
