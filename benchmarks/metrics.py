"""What a benchmark measures: a number with its unit, which way is better, and how much worse is still the same.

Times are never metrics: machines differ. A metric of speed is a ratio of two times taken in one run.
"""

from __future__ import annotations

from typing import Literal, NamedTuple

Better = Literal["less", "more", "near"]


class Metric(NamedTuple):
    """One measured number.

    Attributes:
        name: what is measured, as `recall, arc`.
        value: the number.
        unit: of it; `ratio` of two times in one run.
        better: less, more, or near the baseline (as a coverage near 95 %).
        relative: how much worse, as a share of the baseline, is no change.
        absolute: the same in the unit; the larger of the two holds.
    """

    name: str
    value: float
    unit: str
    better: Better
    relative: float = 0.0
    absolute: float = 0.0

    @property
    def entry(self) -> dict[str, str | float]:
        """As the baseline has it."""
        fields = {"better": self.better, "relative": self.relative, "absolute": self.absolute}
        return {"value": round(self.value, 6), "unit": self.unit, **fields}


def is_worse(metric: Metric, baseline: float) -> bool:
    """Whether a metric is worse than its baseline by more than its tolerance; NaN is."""
    by = {"less": metric.value - baseline, "more": baseline - metric.value, "near": abs(metric.value - baseline)}
    return not by[metric.better] <= max(metric.relative * abs(baseline), metric.absolute) + 1e-9
