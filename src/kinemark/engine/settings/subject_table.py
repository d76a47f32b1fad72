"""`[label.subjects.NAME]`: one of several subjects in a session, and whose trials name its markers."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import Annotated

from pydantic import Field, model_validator

from ...data.nearest_word import are, guess
from ...label import Labelling
from .table import Strict

Height = Annotated[float, Field(gt=0, allow_inf_nan=False)]

APART = ("template", "static", "markers", "height_mm", "template_height_mm")
"""What `[label]` says of one subject, and each of several says for itself."""


class SubjectTable(Strict):
    """A subject, called by the table's name, which stands before its markers, as in `A:LKNE`."""

    marker_set: str | None = Field(
        default=None, description="that this subject wears: a shipped set or a TOML file; the session's where absent"
    )
    template: tuple[str, ...] = Field(
        default=(),
        description="labelled trials that move, or a .template.h5; of a file of several subjects the markers with this "
        "one's name before theirs",
    )
    static: tuple[str, ...] = Field(default=(), description="labelled static trials, likewise")
    markers: tuple[str, ...] = Field(default=(), description="names to learn, without the subject's")
    height_mm: Height | None = Field(default=None, description="height of the subject, mm, as [label] has it")
    template_height_mm: Height | None = Field(default=None, description="height of the one whom the files are of, mm")

    @model_validator(mode="after")
    def together(self) -> SubjectTable:
        """The height of another subject says nothing without that of this one."""
        self.labelling(Labelling())
        return self

    def labelling(self, common: Labelling) -> Labelling:
        """What `[label]` would say of this subject alone."""
        return replace(common, **{key: getattr(self, key) for key in APART})


def check_subjects(subjects: Iterable[str], common: Labelling, most: int) -> None:
    """Refuse names that cannot stand before a marker's or in a file's, too many, and what is each subject's own.

    Raises:
        ValueError: there is such a thing.
    """
    names = list(subjects)
    if wrong := [name for name in names if not name.replace("-", "").replace("_", "").isalnum()]:
        raise ValueError(f"label.subjects: {wrong[0]!r} is no name of a subject; letters, digits, - and _ are")
    if len(names) > most:
        raise ValueError(f"label.subjects: there are {len(names)} subjects, and at most {most} are told apart")
    if common_to := [key for key in APART if getattr(common, key)]:
        raise ValueError(f"label.{common_to[0]}: is of one subject; give it in [label.subjects.{names[0]}]")


def check_subject_of(trial: str, subject: str | None, subjects: Iterable[str]) -> None:
    """Refuse a trial of one who is none of the subjects.

    Raises:
        ValueError: it is.
    """
    known = list(subjects)
    if subject is not None and subject not in known:
        raise ValueError(
            f"trial {trial!r} is of {subject!r}, who is none of label.subjects{guess(subject, known)}; "
            f"there {are(known)}"
        )
