"""A verdict: the grade that findings make, and what is to be said of the whole."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

from ..data import Finding, Grade

GradeShown = Literal["green", "amber", "red", "unknown"]
"""A grade where there is room for one word; "unknown" where the headline says that nobody knows more."""


@dataclass(frozen=True, slots=True)
class Verdict:
    """How good a whole is.

    Attributes:
        grade: "green", "amber" or "red".
        findings: that made it so, those of the highest severity; none where it is green.
        statements: what was measured and how well; the first is the headline.
    """

    grade: Grade
    findings: tuple[Finding, ...]
    statements: tuple[Finding, ...]

    def as_dict(self) -> dict[str, Any]:
        """As plain data for JSON, the findings by their kinds."""
        return {
            "grade": self.grade,
            "findings": list(dict.fromkeys(found.kind for found in self.findings)),
            "statements": [statement.as_dict() for statement in self.statements],
        }


def grade_of(findings: Iterable[Finding]) -> Grade:
    """Red or amber where a finding is, else green."""
    severities = {found.severity for found in findings}
    return "red" if "red" in severities else "amber" if "amber" in severities else "green"


def verdict_of(findings: Sequence[Finding], statements: Iterable[Finding]) -> Verdict:
    """The verdict that findings make."""
    grade = grade_of(findings)
    return Verdict(grade, tuple(found for found in findings if found.severity == grade), tuple(statements))


def grade_shown(verdict: Mapping[str, Any]) -> GradeShown:
    """The grade of a verdict in a file of figures; "unknown" where its headline says so."""
    unknown = verdict["statements"][0]["kind"].endswith("_unknown")
    return "unknown" if unknown else verdict["grade"]
