"""Tracks become markers: names from a subject's template, each with a probability."""

from ..data.computed_points import computed_points
from ..data.marker_sides import sides_by_name
from .by_location import Located, label_by_location
from .check import Exchanged, find_exchanges
from .check_sides import SideSwap, find_side_swaps
from .check_stretches import Mislabelled, find_mislabelled
from .distances import Distances
from .from_set import figure_template, static_template
from .label import label
from .labelling import Labelling
from .labels import Labels, named
from .learn_set import learn_marker_set
from .pooled import template_of_subjects
from .stage import LABEL
from .subject_template import Grown, SubjectTemplate, TemplateSource
from .subjects import SubjectLabels, label_subjects
from .switching import CutLabels, Switch, label_switching
from .template import Template, learn_template

__all__ = [
    "LABEL",
    "CutLabels",
    "Distances",
    "Exchanged",
    "Grown",
    "Labelling",
    "Labels",
    "Located",
    "Mislabelled",
    "SideSwap",
    "SubjectLabels",
    "SubjectTemplate",
    "Switch",
    "Template",
    "TemplateSource",
    "computed_points",
    "figure_template",
    "find_exchanges",
    "find_mislabelled",
    "find_side_swaps",
    "label",
    "label_by_location",
    "label_subjects",
    "label_switching",
    "learn_marker_set",
    "learn_template",
    "named",
    "sides_by_name",
    "static_template",
    "template_of_subjects",
]
