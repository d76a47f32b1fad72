"""The figures of a trial with what they say in words, as quality.json holds them."""

from __future__ import annotations

from typing import Any

from ..findings import quality as figures
from ..findings.trial_records import TrialRecords
from .words import with_words


def quality(records: TrialRecords, **more: Any) -> dict[str, Any]:
    """All figures of one trial, its findings and verdict in values and words; arguments of `findings.quality.quality`.

    Raises:
        ValueError: a camera of the detections is not in the rig, or the points were not made from these detections.
    """
    return with_words(figures.quality(records, **more))
