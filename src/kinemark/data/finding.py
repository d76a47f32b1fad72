"""A finding: what a stage or a check found, as a value.

A finding says what kind it is, how severe, which cameras, markers and frames it is about, and its numbers. It holds no
sentence: `report.words` turns each kind into words, and what follows from a finding follows from its values. Every kind
is declared once, with the units of its values, in `finding_kinds`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Literal, get_args

import numpy as np

Severity = Literal["red", "amber", "info"]
"""red: the results should not be used as they are; amber: look at this first; info: good to know; in this order."""
SEVERITIES: tuple[Severity, ...] = get_args(Severity)

Grade = Literal["red", "amber", "green"]

FindingStage = Literal[
    "record",
    "calibrate",
    "detect",
    "match",
    "reconstruct",
    "track",
    "label",
    "edit",
    "fill",
    "kinematics",
    "sensitivity",
    "gait",
    "plan",
]
"""Where it arises; "record" is the recording itself, before any computing."""

Unit = Literal[
    "px",
    "mm",
    "m",
    "deg",
    "s",
    "ms",
    "frames",
    "Hz",
    "m/s",
    "kg",
    "N",
    "share",
    "ratio",
    "parts",
    "count",
    "level",
    "flag",
    "text",
]
"""Of a value. share: 0 to 1; parts: 1 part in so many; level: grey level of an image; flag: true or false."""

Scalar = float | int | str | bool | None
Value = Scalar | tuple[Scalar, ...]
"""None is a number that is not known."""


@dataclass(frozen=True, slots=True)
class FindingKind:
    """The declaration of a kind.

    Attributes:
        name: of the kind; stage: where it arises; severity: unless a finding says otherwise.
        about: what it means and when it is found, for the reference.
        values: unit of each value by name; a name that ends in `_list` holds one value an item.
    """

    name: str
    stage: FindingStage
    severity: Severity
    about: str
    values: Mapping[str, Unit] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Finding:
    """What was found.

    Attributes:
        kind: of `finding_kinds.KINDS`; severity: "red", "amber" or "info"; stage: where it arises.
        cameras, markers: names of those that it is about; empty where it is about none in particular.
        frames: first and last frame, both included, of each stretch that it is about. What tracking and labelling find
            counts from 0; `numbered` makes numbers in the recording of it, and figures and words have these.
        values: its numbers, by the names and in the units that the kind declares.
    """

    kind: str
    severity: Severity
    stage: FindingStage
    cameras: tuple[str, ...] = ()
    markers: tuple[str, ...] = ()
    frames: tuple[tuple[int, int], ...] = ()
    values: Mapping[str, Value] = field(default_factory=dict)

    def numbered(self, first_frame: int) -> Finding:
        """The same with its frames, which count from 0, as numbers in the recording, whose first is `first_frame`."""
        return replace(self, frames=tuple((first + first_frame, last + first_frame) for first, last in self.frames))

    def as_dict(self) -> dict[str, Any]:
        """As plain data for JSON."""
        return {
            "kind": self.kind,
            "severity": self.severity,
            "stage": self.stage,
            "cameras": list(self.cameras),
            "markers": list(self.markers),
            "frames": [list(span) for span in self.frames],
            "values": {name: list(v) if isinstance(v, tuple) else v for name, v in self.values.items()},
        }

    @classmethod
    def of(cls, data: Mapping[str, Any]) -> Finding:
        """The finding that `as_dict` wrote; words beside it are not read.

        Raises:
            KeyError: a part is missing.
        """
        return cls(
            data["kind"],
            data["severity"],
            data["stage"],
            tuple(data["cameras"]),
            tuple(data["markers"]),
            tuple((int(first), int(last)) for first, last in data["frames"]),
            {name: plain_value(value) for name, value in data["values"].items()},
        )


def plain_value(value: Any) -> Value:
    """A value as Python has it: numbers of NumPy become numbers, sequences tuples, what is not finite None."""
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist()
    if isinstance(value, Sequence) and not isinstance(value, str):
        return tuple(_scalar(item) for item in value)
    return _scalar(value)


def _scalar(value: Any) -> Scalar:
    if isinstance(value, np.generic):
        value = value.item()
    return None if isinstance(value, float) and not math.isfinite(value) else value


def red_if(unusable: bool) -> Severity:
    """Red where so, else amber."""
    return "red" if unusable else "amber"


def most_severe_first(findings: Sequence[Finding]) -> list[Finding]:
    """Sorted by severity, otherwise as they came."""
    return sorted(findings, key=lambda one: SEVERITIES.index(one.severity))
