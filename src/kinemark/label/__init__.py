"""Tracks become markers: names from a subject's template, each with a probability."""

from .check import Exchanged, find_exchanges
from .distances import Distances
from .label import label
from .labelling import Labelling
from .labels import Labels, named
from .stage import LABEL
from .template import Template, learn_template

__all__ = [
    "LABEL",
    "Distances",
    "Exchanged",
    "Labelling",
    "Labels",
    "Template",
    "find_exchanges",
    "label",
    "learn_template",
    "named",
]
