"""A subject's template with where it comes from, which is kept beside a session and grows with it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from ..data import Trajectories
from ..data.arrays import set_columns
from ..data.finding import Finding
from ..data.short_repr import ShortRepr
from .labels import Labels, named
from .pooled import contradiction, pooled
from .template import Template, learn_template

FEWEST = 4
"""Sure names without which a trial adds nothing; by definition of `learn_template`."""


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


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class SubjectTemplate(ShortRepr):
    """What is known of one subject's markers, and from where.

    Attributes:
        template: of the subject. marker_set: name of the set that the subject wears; empty where it is not known.
        subject: name of the subject; empty where it is not known. height_mm: body height, mm; NaN where not known.
        sources: what the template was learnt from, in that order.
        wider: of these markers and of others that nobody named, as a static trial shows both; see `bystanders`. None
            where there are none.
    """

    template: Template
    marker_set: str = ""
    subject: str = ""
    height_mm: float = float("nan")
    sources: tuple[TemplateSource, ...] = ()
    wider: Template | None = None

    def __post_init__(self) -> None:
        set_columns(self, sources=tuple(self.sources))
        if self.height_mm <= 0 or np.isinf(self.height_mm):
            raise ValueError(f"height_mm is {self.height_mm}, wanted a number above 0, or NaN where it is not known")

    @property
    def figure_alone(self) -> bool:
        """Whether nothing of the subject is known but the marker set and the height."""
        return bool(self.sources) and all(source.kind == "marker set" for source in self.sources)

    def grown(self, trial: Trajectories, labels: Labels, source: TemplateSource) -> Grown:
        """With what a labelled and accepted trial adds; only sure names count, each trial by its frames.

        Args:
            trial: that was labelled. labels: of its tracks. source: what it is called.

        Returns:
            The greater template, or this one with a finding where the trial is refused or contradicts it.
        """
        if labels.refused is not None:
            return Grown(self, (), labels.refused)
        whole = named(trial, labels)
        sure = [name for name in self.template.names if name in whole.names]
        if len(sure) < FEWEST:
            return Grown(self, ())
        new = learn_template(whole, names=sure)
        found = contradiction(self.template, new, whole)
        if found is not None:
            return Grown(self, (), found.finding)
        template = pooled(self.template, new, whole)
        return Grown(replace(self, template=template, sources=(*self.sources, source), wider=None), tuple(sure))


class Grown(NamedTuple):
    """What became of a template.

    Attributes:
        template: the new one, or the old one where the trial adds nothing.
        added: names of the markers that the trial adds samples of.
        refused: why the trial was not added; None where it was, or where too few of its names are sure.
    """

    template: SubjectTemplate
    added: tuple[str, ...]
    refused: Finding | None = None
