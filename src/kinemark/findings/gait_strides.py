"""Whether the trials of a gait report have strides enough."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from ..data import Finding, make_finding
from ..data.finding import Severity
from ..data.strides import Stride
from ..data.subject_measures import SIDES

FEW_STRIDES = 3
"""Of a side, below which their spread says little; chosen."""


def of_strides(each: Mapping[str, Sequence[Stride]], files: Mapping[str, str]) -> Iterator[Finding]:
    """Findings of trials without a stride, which leave the others' result as it is, and of sides with few.

    Args:
        each: strides by the name of their trial. files: of the trials, by their names.
    """
    walked = {trial: any(not one.stands for one in own) for trial, own in each.items()}
    severity: Severity = "amber" if any(walked.values()) else "red"
    for trial, own in each.items():
        if not walked[trial]:
            file = files.get(trial, trial)
            yield make_finding("gait_without_strides", severity=severity, trial=trial, file=file, stood=len(own))
    left, right = (sum(one.side == side and one.counts for own in each.values() for one in own) for side in SIDES)
    if any(0 < n < FEW_STRIDES for n in (left, right)):
        yield make_finding("gait_few_strides", left_strides=left, right_strides=right)


def of_left_out(trial: str, strides: Sequence[Stride]) -> Iterator[Finding]:
    """Strides of a trial of this name that do not count, by the reason: the subject stands, or turns."""
    stood = sum(one.stands for one in strides)
    turned = sum(not one.counts and not one.stands for one in strides)
    for kind, left_out in (("gait_stands_left_out", stood), ("gait_turns_left_out", turned)):
        if left_out:
            yield make_finding(kind, trial=trial, left_out=left_out, strides=len(strides))
