"""How likely an error is, from what tells of it: logistic functions (Cox 1958) of the evidence.

    wrong = 1 / (1 + exp(−(c₀ + Σ c_k e_k)))                                                              (1)

The coefficients were fitted to seeded faults and to the tracker's own errors by studies/probable_errors.py, which says
on which scenes, and how well they do on others.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

COEFFICIENTS: dict[str, tuple[float, ...]] = {
    "change": (-4.0, 0.3, 0.8, 0.3, -0.5, 0.8, 0.1),
    "spike": (-4.0, 1.0, -0.5, 0.0),
    "piece": (0.0, 0.3, -0.8, 0.0),
    "ghost": (1.0, -1.0, -0.5, 0.0),
}
"""Constant, then as the evidence of each kind lists them. Fitted by studies/probable_errors.py."""


def probability(kind: str, evidence: Sequence[float]) -> float:
    """(1)."""
    c = COEFFICIENTS[kind]
    z = c[0] + float(np.dot(c[1:], np.asarray(evidence, np.float64)))
    return float(1 / (1 + np.exp(-np.clip(z, -50, 50))))
