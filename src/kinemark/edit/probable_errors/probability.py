"""How likely an error is, from what tells of it: logistic functions of the evidence.

    wrong = 1 / (1 + exp(−(c₀ + Σ c_k e_k)))                                                              (1)

The coefficients were fitted to seeded faults and to the tracker's own errors by studies/probable_errors.py, which says
on which scenes and files, and how well they do on others. What a tracker does wrong, and what is left in files that
somebody looked at, have coefficients of their own. They hold where errors are as many as were seeded: with k times the
odds of an error, the odds of (1) are k times as many (2).

How many errors a file has nobody knows before, nor how its people move, but its other problems tell. What motion shows
is common in its own trial, an error stands alone there; and where much is wrong, more is. With z the log-odds of (1),
z_j those of the trial's other problems, w_j their probabilities, and f its rate,

    u = z + c₁ ln(1 + S) − c₂ ln(1 + n(z)) + c₄ a,      S = Σ_j w_j²                                      (3)
    n(z) = √(f / USUAL_HZ) Σ_j (1 − w_j) exp(min(z, z_j) / TAIL − max(z − z_j, 0) / BEYOND)              (4)

w_j² lets what is likely wrong speak of errors, and 1 − w_j what is not of motion. Of motion each counts as what it
tells, at most as what this one does, and less the farther this one is beyond it: so what stands alone stays likely, and
what tells no more than much else in its trial is motion, the more so the shorter the time from frame to frame. This is
empirical Bayes with the trial's own distribution of what is no error. Errors come together too: two markers that are
exchanged both leave their ways in one frame, and a is what other paths show there (`at_once`). A problem without others
stays at (1) here, and with 0 ≤ c₁, 0 ≤ c₂ < TAIL and 0 ≤ c₄ more evidence of its own never makes one less likely.

A logistic function falls as slowly far below its middle as its middle says. Errors do not: what is hardly off its way
is none, whatever else is told of it. So what is unlikely is less likely than (3) says,

    logit wrong' = u − c₃ max(0, −u − UNLIKELY)                                                           (5)
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...data.array_types import Floats
from .at_once import Moment, at_once

USUAL_HZ = 60.0
"""Rate of (4); by definition."""
TAIL, BEYOND = 2.0, 6.0
"""Log-odds of (4); chosen of 1.5 to 4 and 2 to infinity by what is told of each laboratory by the others."""
UNLIKELY = 2.0
"""Log-odds against an error from which on (5) falls faster; chosen of 0 to 3 by what is told of each laboratory by
the others."""
LEAST = 1e-6
"""Probability that counts as none; chosen."""

COEFFICIENTS: dict[str, tuple[float, ...]] = {
    "change": (-3.31, 0.23, 0.56, 0.67, -0.40, -0.17, -0.24, 0.06, 0.02, 1.06, -0.26, 0.12, 0.0, 1.30, -0.95, 0.0, 0.0),
    "cut": (-3.69, 0.28, 0.35, 0.15, -0.20, -0.04, 0.14, -0.06, 0.22, -0.43, 0.23, 0.0, 0.0, 0.96, -1.30, 0.0, 0.0),
    "change_in_file": (-9.07, 0.19, 0.67, -0.13, 0.51, 0, -0.03, -0.15, -0.04, 0, 0, 0.13, 0.89, 0, 0, 2.64, -1.19),
    "change_in_file_alone": (-4.73, 0.41, 1.41, -0.28, 1.09, 0, -0.07, -0.32, -0.09, 0, 0, 0.28, 1.88, 0, 0, 0, 0),
    "spike": (-0.37, 0.39, 0.12, 0.60, 0.28, -0.04, 0.24),
    "spike_in_file": (1.13, 0.76, -0.42, 1.83, 2.35, 0.18, 1.87),
    "leap": (-6.07, 0.34, 1.18, 1.59, -1.80, -0.79, -0.45),
    "piece": (-1.11, 0.41, -1.34, 3.03, 0.01, 0.11),
    "piece_in_file": (-0.80, 0.13, -0.36, 0.90, 0.0, 0.02),
    "filling": (-10.62, -0.82, 2.13, -2.72, 2.37),
    "lost": (-1.99, 0.61, 6.00, 2.20, -9.66, -1.34),
    "moved": (-12.15, 0.59, 1.31, 1.81, -3.37, 1.40),
    "repeated": (-4.0, 3.5, 0.0, 0.0, 0.0, 0.0),
    "ghost": (-7.58, -0.70, -0.11, 1.09, 1.00),
    "in_trial": (1.39, 1.85, 0.34, 1.48),
    "name_swap": (-3.0, 1.5, 0.5),
    "name_sides": (-3.0, 1.5, 0.5),
    "name_label": (-3.0, 1.5, 0.5),
}
"""Constant, then as the evidence of each kind lists them; c₁ and c₂ of (3), c₃ of (5), c₄ of (3). Fitted by
studies/probable_errors.py: those of leaps to files, those of errors that have a kind for files as well to scenes:
changes of tracks with a partner (`change`) and without (`cut`) to what the list keeps of them. The others were
fitted before rough tracks were among the faults, to files (spikes in them) or to both: fitted anew to files alone,
spikes would be told in clean files. Spikes of files then got a factor and a constant by which each recording counts
the same (`levelled`). (3) and (5) are fitted by studies/trial_bulk.py, to all 16 laboratories there; changes of
files without companions were, beside an earlier form of (3), to the same, and those with companions have these times
a factor, a constant, and what companions tell, by those of FILES, beside (3) without a. Fillings are by
studies/filled_samples.py, lost frames and moved worlds by studies/whole_trial_faults.py. Those of repeated frames are
chosen, as few files rest: where paths do so in one of three samples, it is as likely as not. Ghosts: scenes 0 to 59 and
140 to 141, and of 260 to 339 the twelve that have most, and twelve others, which count for the 68 that are left.
Changes and ghosts of tracks got a factor and a constant each (`rescaled`) by scenes 100 to 139 and 340 to 459 and the
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


def in_trial(wrong: Floats, rate: float, moments: Sequence[Moment] = ()) -> Floats:
    """(5) of the problems (N) of a trial at so many Hz that are as likely by themselves, by where they are; without
    that nothing happens at once."""
    z = logit_in_trial(evidence_of_trial(wrong, rate, moments), COEFFICIENTS["in_trial"])
    return np.asarray(1 / (1 + np.exp(-np.clip(z, -50, 50))))


def logit_in_trial(evidence: Floats, c: Sequence[float] | Floats) -> Floats:
    """(3) and (5) of problems by `evidence_of_trial` (N, 4), with c₁ to c₄."""
    u = evidence[:, 0] + told_by_trial(evidence, c)
    return np.asarray(u - c[2] * np.maximum(-u - UNLIKELY, 0.0))


def told_by_trial(evidence: Floats, c: Sequence[float] | Floats) -> Floats:
    """What (3) adds to z."""
    return np.asarray(evidence[:, 1:] @ np.array([c[0], -c[1], c[3]]))


def evidence_of_trial(wrong: Floats, rate: float, moments: Sequence[Moment] = ()) -> Floats:
    """(N, 4) of the problems (N) of a trial at so many Hz: z, ln(1 + S), ln(1 + n(z)) and a of (3)."""
    wrong = np.clip(wrong, LEAST, 1 - LEAST)
    z, squared = np.log(wrong) - np.log1p(-wrong), wrong**2
    among, common = np.maximum(squared.sum() - squared, 0.0), np.sqrt(rate / USUAL_HZ) * as_common(z)
    together = at_once(wrong, moments) if moments else np.zeros(len(wrong))
    return np.column_stack([z, np.log1p(among), np.log1p(common), together])


def as_common(z: Floats) -> Floats:
    """(4) of the problems (N) of a trial at the usual rate."""
    order = np.argsort(z)  # not all pairs: long trials have many thousands
    u = z[order]
    right, beyond = 1 / (1 + np.exp(u)), np.exp(u / BEYOND)
    odds = np.exp(u / TAIL)
    less, more = np.cumsum(np.append(0.0, right * odds * beyond))[:-1], np.cumsum(right[::-1])[::-1] - right
    n = np.empty(len(z))
    n[order] = less / beyond + odds * more
    return n


def name_probability(kind: str, nats: float, seconds: float) -> float:
    """(1) of a stretch whose names fit worse than others by so many nats a frame, for so many seconds."""
    return probability(f"name_{kind}", (float(np.log(max(nats, 1e-3))), float(np.log(max(seconds, 1e-3)))))
