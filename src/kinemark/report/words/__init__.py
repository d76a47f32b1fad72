"""The one place where findings become words.

`WORDS` has a sentence for every kind of finding, and what to do about it. Nothing reads a sentence back: other words
here change no grade, no figure and no decision.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ...data import Finding
from .calibration import CALIBRATION_WORDS
from .cameras import CAMERA_WORDS
from .control_points import CONTROL_POINT_WORDS
from .edits import EDIT_WORDS, edit_text, entry_text
from .gait import GAIT_WORDS
from .muscles import MUSCLE_WORDS
from .plans import PLAN_WORDS
from .reasons import SOURCE_ADVICE, evidence_text, frames_text, open_gap_text, place_of_reason, reason_text
from .stages import ANGLE_WORDS, FILLING_WORDS, LABELLING_WORDS, PROPOSAL_WORDS
from .template import Words
from .trial import TRIAL_WORDS
from .verdicts import VERDICT_WORDS

__all__ = [
    "SOURCE_ADVICE",
    "TAGS",
    "WORDS",
    "advice_of",
    "edit_text",
    "entry_text",
    "evidence_text",
    "frames_text",
    "headline_of",
    "open_gap_text",
    "place_of_reason",
    "reason_text",
    "sentences_of",
    "text_of",
    "with_words",
]

TAGS = {"green": "good", "amber": "look", "red": "stop", "info": "note"}
"""What stands beside a finding, by its severity."""

WORDS: dict[str, Words] = {
    **TRIAL_WORDS,
    **CAMERA_WORDS,
    **CONTROL_POINT_WORDS,
    **CALIBRATION_WORDS,
    **LABELLING_WORDS,
    **FILLING_WORDS,
    **EDIT_WORDS,
    **ANGLE_WORDS,
    **PROPOSAL_WORDS,
    **GAIT_WORDS,
    **MUSCLE_WORDS,
    **PLAN_WORDS,
    **VERDICT_WORDS,
}
"""By kind of finding."""


def text_of(found: Finding | Mapping[str, Any]) -> str:
    """What was found, as a sentence; of a finding, or of its plain data."""
    return _words(found)[0]


def advice_of(found: Finding | Mapping[str, Any]) -> str:
    """What to do about it; empty where there is nothing to do."""
    return _words(found)[1]


def _words(found: Finding | Mapping[str, Any]) -> tuple[str, str]:
    one = found if isinstance(found, Finding) else Finding.of(found)
    return WORDS[one.kind].of(one)


def headline_of(verdict: Mapping[str, Any]) -> str:
    """The first of a verdict's statements."""
    return text_of(verdict["statements"][0])


def sentences_of(verdict: Mapping[str, Any]) -> list[str]:
    """The other statements of a verdict."""
    return [text_of(statement) for statement in verdict["statements"][1:]]


def with_words(figures: Any) -> Any:
    """Figures with `text` and `advice` in every finding, `text` in every ambiguous decision, `evidence_text` in every
    source of error, `headline` and `sentences` in every verdict, however deep they lie."""
    if isinstance(figures, list):
        return [with_words(item) for item in figures]
    if not isinstance(figures, dict):
        return figures
    if "kind" in figures and "severity" in figures:
        text, advice = _words(figures)
        return figures | {"text": text, "advice": advice}
    if "kind" in figures and "reason" in figures:
        return figures | {"text": reason_text([figures])}
    if "source" in figures and "evidence" in figures:
        return figures | {"evidence_text": evidence_text(figures)}
    worded = {key: with_words(value) for key, value in figures.items()}
    if "statements" in figures:
        worded |= {
            "statements": figures["statements"],
            "headline": headline_of(figures),
            "sentences": sentences_of(figures),
        }
    return worded
