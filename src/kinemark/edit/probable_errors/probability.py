"""How likely an error is, from what tells of it: logistic functions (Cox 1958) of the evidence.

    wrong = 1 / (1 + exp(−(c₀ + Σ c_k e_k)))                                                              (1)

The coefficients were fitted to seeded faults and to the tracker's own errors by studies/probable_errors.py, which says
on which scenes, and how well they do on others.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

COEFFICIENTS: dict[str, tuple[float, ...]] = {
    "change": (-3.66, 0.23, 0.53, 0.33, -0.23, 0.09, 0.19, -0.04, -0.84),
    "spike": (-0.44, -0.11, 0.12, 1.02, 0.88, 0.84),
    "piece": (0.53, 0.34, -0.95, 2.17, -0.04, -0.13),
    "ghost": (-1.47, -0.68, -0.94, 1.94),
    "name_swap": (-3.0, 1.5, 0.5),
    "name_sides": (-3.0, 1.5, 0.5),
    "name_label": (-3.0, 1.5, 0.5),
}
"""Constant, then as the evidence of each kind lists them. Fitted by studies/probable_errors.py."""


def probability(kind: str, evidence: Sequence[float]) -> float:
    """(1)."""
    c = COEFFICIENTS[kind]
    z = c[0] + float(np.dot(c[1:], np.asarray(evidence, np.float64)))
    return float(1 / (1 + np.exp(-np.clip(z, -50, 50))))


def name_probability(kind: str, nats: float, seconds: float) -> float:
    """(1) of a stretch whose names fit worse than others by so many nats a frame, for so many seconds."""
    return probability(f"name_{kind}", (float(np.log(max(nats, 1e-3))), float(np.log(max(seconds, 1e-3)))))
