"""How likely an error is, from what tells of it: logistic functions of the evidence.

    wrong = 1 / (1 + exp(−(c₀ + Σ c_k e_k)))                                                              (1)

The coefficients were fitted to seeded faults and to the tracker's own errors by studies/probable_errors.py, which says
on which scenes and files, and how well they do on others. What a tracker does wrong, and what is left in files that
somebody looked at, have coefficients of their own. They hold where errors are as many as were seeded: with k times the
odds of an error, the odds of (1) are k times as many (2).

How many errors a file has nobody knows before, but its other problems tell: where much is surely wrong, more is; where
much may be wrong and nothing surely is, a person moves as few do. With S the sum of the probabilities (1) of the other
problems of a trial that are SURE, and N how many others are neither sure nor unlikely,

    logit wrong' = c₀ + c₁ logit wrong + c₂ ln(1 + S) + c₃ ln(1 + N)                                      (3)
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...data.array_types import Floats

SURE, UNLIKELY = 0.8, 0.02
"""Probabilities of (3); chosen: what is surer is true in nearly all files, and what is less likely any trial has."""
LEAST = 1e-6
"""Probability that counts as none; chosen."""

COEFFICIENTS: dict[str, tuple[float, ...]] = {
    "change": (-3.27, 0.30, 0.75, 0.89, -0.53, -0.22, -0.31, 0.08, 0.03, 1.41, -0.34, 0.16, 0.0, 1.72, -1.26),
    "cut": (-4.20, 0.28, 0.35, 0.15, -0.20, -0.04, 0.14, -0.06, 0.22, -0.43, 0.23, 0.0, 0.0, 0.94, -1.28),
    "change_in_file": (-1.92, 0.24, 0.28, 0.71, -0.36, -0.32, -0.38, 0.17, 0.07, 1.36, -0.12, 0.08, -0.84, 0.0, 0.0),
    "spike": (-0.37, 0.39, 0.12, 0.60, 0.28, -0.04, 0.24),
    "spike_in_file": (1.13, 0.76, -0.42, 1.83, 2.35, 0.18, 1.87),
    "leap": (-6.07, 0.34, 1.18, 1.59, -1.80, -0.79, -0.45),
    "piece": (-1.11, 0.41, -1.34, 3.03, 0.01, 0.11),
    "piece_in_file": (-0.44, 0.33, -0.95, 2.35, 0.01, 0.05),
    "filling": (-10.62, -0.82, 2.13, -2.72, 2.37),
    "lost": (-1.99, 0.61, 6.00, 2.20, -9.66, -1.34),
    "moved": (-12.15, 0.59, 1.31, 1.81, -3.37, 1.40),
    "repeated": (-4.0, 3.5, 0.0, 0.0, 0.0, 0.0),
    "ghost": (-6.20, -0.69, -0.11, 1.06, 0.98),
    "trial": (-0.42, 0.92, 1.27, -0.76),
    "name_swap": (-3.0, 1.5, 0.5),
    "name_sides": (-3.0, 1.5, 0.5),
    "name_label": (-3.0, 1.5, 0.5),
}
"""Constant, then as the evidence of each kind lists them. Fitted by studies/probable_errors.py: those of leaps to
files, those of errors that have a kind for files as well to scenes: changes of tracks with a partner (`change`) and
without (`cut`) to what the list keeps of them. The others were fitted before rough tracks were
among the faults, to files (spikes in them) or to both: fitted anew to files alone, changes would be told in hands that
bend fast, and spikes in clean files. Spikes of files then got a factor and a constant by which each recording counts
the same (`levelled`). Fillings are fitted by studies/filled_samples.py, lost frames and moved worlds by
studies/whole_trial_faults.py, (3) to both halves of the files by studies/trial_prior.py. Those of repeated frames are
chosen, as few files rest: where paths do so in one of three samples, it is as likely as not. Ghosts: scenes 0 to 59
and 140 to 141, and of 260 to 339 the twelve that have most, and twelve others, which count for the 68 that are left."""


def of_source(kind: str, tracked: bool) -> str:
    """The kind of an error of samples with images behind them, which tracking may have taken wrongly (`tracked`), or of
    those of files, which somebody looked at."""
    return kind if tracked else f"{kind}_in_file"


def probability(kind: str, evidence: Sequence[float]) -> float:
    """(1)."""
    c = COEFFICIENTS[kind]
    z = c[0] + float(np.dot(c[1:], np.asarray(evidence, np.float64)))
    return float(1 / (1 + np.exp(-np.clip(z, -50, 50))))


def in_trial(wrong: Floats) -> Floats:
    """(3) of the problems (N) of a trial."""
    sure, unsure = wrong >= SURE, (wrong >= UNLIKELY) & (wrong < SURE)
    others = np.where(sure, wrong, 0.0).sum() - np.where(sure, wrong, 0.0), unsure.sum() - unsure
    c = COEFFICIENTS["trial"]
    logit = np.log(np.clip(wrong, LEAST, 1 - LEAST)) - np.log1p(-np.clip(wrong, LEAST, 1 - LEAST))
    z = c[0] + c[1] * logit + c[2] * np.log1p(others[0]) + c[3] * np.log1p(others[1])
    return np.asarray(1 / (1 + np.exp(-z)))


def name_probability(kind: str, nats: float, seconds: float) -> float:
    """(1) of a stretch whose names fit worse than others by so many nats a frame, for so many seconds."""
    return probability(f"name_{kind}", (float(np.log(max(nats, 1e-3))), float(np.log(max(seconds, 1e-3)))))
