"""Tracks become markers: names from a subject's template, each with a probability."""

from .check import Exchanged, find_exchanges
from .distances import Distances
from .label import label
from .labels import Labels, named
from .score import LabelScore, Reliability, reliability, score_labels
from .shredded import Change, Shredded, shredded
from .stage import LABEL
from .template import Template, learn_template

__all__ = [
    "LABEL",
    "Change",
    "Distances",
    "Exchanged",
    "LabelScore",
    "Labels",
    "Reliability",
    "Shredded",
    "Template",
    "find_exchanges",
    "label",
    "learn_template",
    "named",
    "reliability",
    "score_labels",
    "shredded",
]
