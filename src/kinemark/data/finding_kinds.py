"""Every kind of finding, declared once: its stage, its usual severity, what it means, and the units of its values.

`make_finding` makes one and checks it against its declaration. The words of each kind are in `report.words`.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from .finding import Finding, FindingKind, Severity, plain_value
from .finding_kinds_of_calibration import CALIBRATION_KINDS
from .finding_kinds_of_gait import GAIT_KINDS
from .finding_kinds_of_stages import PLAN_KINDS, STAGE_KINDS
from .finding_kinds_of_trial import TRIAL_KINDS

KINDS: dict[str, FindingKind] = {
    kind.name: kind for kind in (*TRIAL_KINDS, *CALIBRATION_KINDS, *STAGE_KINDS, *GAIT_KINDS, *PLAN_KINDS)
}


def make_finding(
    kind: str,
    *,
    severity: Severity | None = None,
    cameras: Iterable[str] = (),
    markers: Iterable[str] = (),
    frames: Iterable[tuple[int, int]] = (),
    **values: Any,
) -> Finding:
    """A finding of a declared kind.

    Args:
        kind: one of `KINDS`.
        severity: where it is not the kind's own.
        cameras, markers: names; frames: first and last of each stretch, both included.
        values: all that the kind declares, and no others; numbers that are not finite become None.

    Raises:
        ValueError: the kind is not declared, or the values are not those that it declares.
    """
    declared = KINDS.get(kind)
    if declared is None:
        raise ValueError(f"{kind!r} is no kind of finding")
    if set(values) != set(declared.values):
        raise ValueError(f"a finding {kind!r} has values {sorted(values)}, wanted {sorted(declared.values)}")
    return Finding(
        kind,
        severity or declared.severity,
        declared.stage,
        tuple(cameras),
        tuple(markers),
        tuple((int(first), int(last)) for first, last in frames),
        {name: plain_value(values[name]) for name in declared.values},
    )
