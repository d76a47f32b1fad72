"""How likely an error is, from what tells of it: logistic functions of the evidence.

    wrong = 1 / (1 + exp(−(c₀ + Σ c_k e_k)))                                                              (1)

The coefficients were fitted to seeded faults and to the tracker's own errors by studies/probable_errors.py, which says
on which scenes and files, and how well they do on others. What a tracker does wrong, and what is left in files that
somebody looked at, have coefficients of their own. They hold where errors are as many as were seeded: with k times the
odds of an error, the odds of (1) are k times as many (2).

How many errors a file has nobody knows before, nor how its people move, but its other problems tell. What motion shows
is common in its own trial, an error stands alone there; and where much is surely wrong, more is. With z the log-odds of
(1), f the rate of the trial, S the sum of the probabilities of its other problems that are SURE, and n(z) how many of
the others, j, nearly all of which are motion, tell as much,

    logit wrong' = c₀ + c₁ z + c₂ ln(1 + S) + c₃ ln(1 + n(z)) + c₄ ln(f / USUAL_HZ)                       (3)
    n(z) = Σ_j exp(−max(z − z_j, 0) / TAIL)                                                               (4)

Those that tell as much or more count as one each, and each that tells less as the share of its tail that would tell as
much. So what is sure and stands alone stays likely; what tells no more than much else in its trial is motion. This is
empirical Bayes with the trial's own distribution of what is no error. Each kind has coefficients (3) of its own:
evidence of a leap is held against its surroundings already and tells alone, that of a spike tells less than its trial.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...data.array_types import Bools, Floats

SURE, USUAL_HZ = 0.5, 60.0
"""Probability of (3) from which on a problem counts as an error, and the rate that is usual; by definition."""
TAIL = 2.0
"""Log-odds of (4); chosen of 1, 1.5, 2 and 3 by what is told of each laboratory by the others."""
LEAST = 1e-6
"""Probability that counts as none; chosen."""

COEFFICIENTS: dict[str, tuple[float, ...]] = {
    "change": (-3.12, 0.23, 0.57, 0.68, -0.40, -0.17, -0.24, 0.06, 0.02, 1.07, -0.26, 0.12, 0.0, 1.31, -0.96),
    "cut": (-3.32, 0.24, 0.30, 0.13, -0.17, -0.03, 0.12, -0.05, 0.19, -0.37, 0.20, 0.0, 0.0, 0.82, -1.11),
    "change_in_file": (-4.73, 0.41, 1.41, -0.28, 1.09, 0.0, -0.07, -0.32, -0.09, 0.0, 0.0, 0.28, 1.88, 0.0, 0.0),
    "spike": (-0.37, 0.39, 0.12, 0.60, 0.28, -0.04, 0.24),
    "spike_in_file": (1.13, 0.76, -0.42, 1.83, 2.35, 0.18, 1.87),
    "leap": (-6.07, 0.34, 1.18, 1.59, -1.80, -0.79, -0.45),
    "piece": (-1.11, 0.41, -1.34, 3.03, 0.01, 0.11),
    "piece_in_file": (-0.80, 0.13, -0.36, 0.90, 0.0, 0.02),
    "filling": (-10.62, -0.82, 2.13, -2.72, 2.37),
    "lost": (-1.99, 0.61, 6.00, 2.20, -9.66, -1.34),
    "moved": (-12.15, 0.59, 1.31, 1.81, -3.37, 1.40),
    "repeated": (-4.0, 3.5, 0.0, 0.0, 0.0, 0.0),
    "ghost": (-7.89, -0.87, -0.14, 1.34, 1.23),
    "change_in_trial": (-0.35, 0.8, 1.09, -0.85, -1.44),
    "leap_in_trial": (-0.92, 1.0, 1.87, -1.34, -1.09),
    "spike_in_trial": (2.61, 0.4, 0.48, -2.04, -2.46),
    "name_swap": (-3.0, 1.5, 0.5),
    "name_sides": (-3.0, 1.5, 0.5),
    "name_label": (-3.0, 1.5, 0.5),
}
"""Constant, then as the evidence of each kind lists them. Fitted by studies/probable_errors.py: those of leaps to
files, those of errors that have a kind for files as well to scenes: changes of tracks with a partner (`change`) and
without (`cut`) to what the list keeps of them. The others were fitted before rough tracks were
among the faults, to files (spikes in them) or to both: fitted anew to files alone, spikes would be told in clean files.
Spikes of files then got a factor and a constant by which each recording counts the same (`levelled`). Changes of files,
and (3), are fitted by studies/trial_bulk.py to 16 laboratories, c₁ of (3) chosen there; fillings by
studies/filled_samples.py, lost frames and moved worlds by studies/whole_trial_faults.py. Those of repeated frames are
chosen, as few files rest: where paths do so in one of three samples, it is as likely as not. Ghosts: scenes 0 to 59
and 140 to 141, and of 260 to 339 the twelve that have most, and twelve others, which count for the 68 that are left.
Changes and ghosts of tracks got a factor and a constant each (`rescaled`) by scenes 0 to 59 and 140 to 159 and the
present tracker, loose pieces of files by those of the laboratories."""


def of_source(kind: str, tracked: bool) -> str:
    """The kind of an error of samples with images behind them, which tracking may have taken wrongly (`tracked`), or of
    those of files, which somebody looked at."""
    return kind if tracked else f"{kind}_in_file"


def probability(kind: str, evidence: Sequence[float]) -> float:
    """(1)."""
    c = COEFFICIENTS[kind]
    z = c[0] + float(np.dot(c[1:], np.asarray(evidence, np.float64)))
    return float(1 / (1 + np.exp(-np.clip(z, -50, 50))))


def in_trial(kinds: Sequence[str], wrong: Floats, rate: float) -> Floats:
    """(3) of the problems (N) of a trial at so many Hz, of kinds `change`, `leap` and `spike`."""
    if not len(wrong):
        return np.zeros(0)
    c = np.array([COEFFICIENTS[f"{kind}_in_trial"] for kind in kinds])
    z = c[:, 0] + (c[:, 1:] * evidence_of_trial(wrong, rate)).sum(1)
    return np.asarray(1 / (1 + np.exp(-np.clip(z, -50, 50))))


def evidence_of_trial(wrong: Floats, rate: float) -> Floats:
    """(N, 4) of the problems (N) of a trial at so many Hz: z, ln(1 + S), ln(1 + n(z)) and ln(f / USUAL_HZ) of (3)."""
    clipped, sure = np.clip(wrong, LEAST, 1 - LEAST), wrong >= SURE
    z = np.log(clipped) - np.log1p(-clipped)
    among = np.where(sure, wrong, 0.0).sum() - np.where(sure, wrong, 0.0)
    rates = np.full(len(z), np.log(rate / USUAL_HZ))
    return np.column_stack([z, np.log1p(among), np.log1p(as_common(z, sure)), rates])


def as_common(z: Floats, sure: Bools) -> Floats:
    """(4) of the problems (N) of a trial."""
    unsure = np.sort(z[~sure])
    less = np.append(0.0, np.cumsum(np.exp(unsure / TAIL)))  # not all pairs: long trials have many thousands
    below = np.searchsorted(unsure, z)
    return np.asarray(len(unsure) - below + np.exp(-z / TAIL) * less[below] - ~sure)


def name_probability(kind: str, nats: float, seconds: float) -> float:
    """(1) of a stretch whose names fit worse than others by so many nats a frame, for so many seconds."""
    return probability(f"name_{kind}", (float(np.log(max(nats, 1e-3))), float(np.log(max(seconds, 1e-3)))))
