"""A subject's template with where it comes from, which is kept beside a session and grows with it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..data.arrays import set_columns
from .template import Template


@dataclass(frozen=True, slots=True)
class TemplateSource:
    """A trial that a template has learnt from.

    Attributes:
        file: its name. frames: how many it has. date: when it was learnt, as 2026-01-31.
        kind: what was known of it: "labelled", "static", "other subject", "marker set" or "accepted".
    """

    file: str
    frames: int
    date: str
    kind: str = "labelled"


@dataclass(frozen=True, slots=True, eq=False)
class SubjectTemplate:
    """What is known of one subject's markers, and from where.

    Attributes:
        template: of the subject. marker_set: name of the set that the subject wears; empty where it is not known.
        subject: name of the subject; empty where it is not known. height_mm: body height, mm; NaN where not known.
        sources: what the template was learnt from, in that order.
    """

    template: Template
    marker_set: str = ""
    subject: str = ""
    height_mm: float = float("nan")
    sources: tuple[TemplateSource, ...] = ()

    def __post_init__(self) -> None:
        set_columns(self, sources=tuple(self.sources))
        if self.height_mm <= 0 or np.isinf(self.height_mm):
            raise ValueError(f"height_mm is {self.height_mm}, wanted a number above 0, or NaN where it is not known")
