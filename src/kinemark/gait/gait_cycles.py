"""Gait curves over the stride: each stride on 0 to 100 %, their mean, how they differ, and what measurement adds.

Every quantity of the left leg is cut at the left foot's strikes, of the right leg at the right's. Over n strides the
mean has the spread s (between strides), the measurement's own u (root mean square of the propagated SD of the strides,
which systematic causes do not average out), and consistency is told by

    CMC = √( 1 − [ΣΣ (y_nt − ȳ_t)² / T (N − 1)] / [ΣΣ (y_nt − ȳ)² / (T N − 1)] )                       (1)

(Kadaba et al. 1989). Most typical is the stride nearest to the median of all, over all angles (Sangeux and Polak 2015).
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from ..data import Signal, Signals
from ..data.array_types import Floats
from ..data.gait_curves import GaitCurves, GaitReference, known_mean
from ..data.strides import Stride
from ..data.subject_measures import LETTER, SIDES, Side
from ..kinematics import resampled
from .emg import Emg, normalised, peak_of

POINTS = 101
"""Of a stride, 0 to 100 %; conventional."""


def gait_curves(signals: Signals, strides: Sequence[Stride]) -> tuple[GaitCurves, ...]:
    """Every quantity whose name begins with L or R, over the strides of its side that lie in the recording."""
    found = []
    for signal in signals:
        side = side_of(signal.name)
        own = [s for s in strides if s.side == side]
        if side is not None and own:
            found.append(_curves(signal, side, own))
    return tuple(found)


def emg_curves(
    channels: Mapping[str, Emg], strides: Sequence[Stride], *, whole: Mapping[str, float] | None = None
) -> tuple[GaitCurves, ...]:
    """Envelope in %, and whether the muscle is on, in %, over the strides of its side (`muscle_sides`).

    Where a channel shows no bursts, or nothing was recorded, it is not known whether the muscle is on (NaN).

    Args:
        channels: by name. strides: of both sides.
        whole: what counts as 100 %, in the channel's unit; its own greatest value where none is given.
    """
    found = []
    sides = muscle_sides(channels)
    for name, one in channels.items():
        side = sides[name] or "left"
        own = [s for s in strides if s.side == side]
        if own:
            hundred = (whole or {}).get(name, peak_of(one.envelope))
            on = np.where(np.isfinite(one.envelope) & one.bursts, 100.0 * one.on, np.nan)
            both = np.stack([normalised(one.envelope, hundred), on], -1)
            signal = Signal.of(name, "emg", "%", both, rate=one.rate, axes=("envelope", "on"))
            found.append(_curves(replace(signal, start=one.start), side, own))
    return tuple(found)


def dynamic_peaks(each: Sequence[tuple[Mapping[str, Emg], Sequence[Stride]]]) -> dict[str, float]:
    """By channel the mean over strides of each stride's greatest value (Yang and Winter 1984).

    Args:
        each: channels by name, and strides, of each walk.
    """
    found: dict[str, list[float]] = {}
    for channels, strides in each:
        sides = muscle_sides(channels)
        for name, one in channels.items():
            for stride in (s for s in strides if s.side == (sides[name] or "left")):
                a, b = (round((t - one.start) * one.rate) for t in (stride.first, stride.last))
                if 0 <= a < b <= len(one.envelope) and (peak := peak_of(one.envelope[a:b])) > 0:
                    found.setdefault(name, []).append(peak)
    return {name: float(np.mean(peaks)) for name, peaks in found.items()}


def muscle_sides(names: Collection[str]) -> dict[str, Side | None]:
    """Sides of EMG channels by their names; None of one that does not say it.

    A letter or a word says it ("R Rect", "EMG_left_soleus"), or the letter that a word begins or ends with, where
    another channel is called alike but for the other letter ("RTA" beside "LTA", "TAR" beside "TAL"; "RF" alone is the
    rectus femoris, and "GL" beside "GR" are two muscles).
    """
    known = set(names)
    return {name: _said_side(name) or _glued_side(name, known) for name in names}


def _said_side(name: str) -> Side | None:
    """By a letter or word of its own."""
    for word in re.split(r"[^A-Za-z]+", name):
        for side in SIDES:
            letter = LETTER[side]
            if word in (letter, letter.lower(), f"{letter}T") or word.lower() == side:
                return side
    return None


def _glued_side(name: str, known: Collection[str]) -> Side | None:
    """By the letter that one of its words begins or ends with, where its twin is there."""
    for found in re.finditer(GLUED, name):
        i, left = found.start(), found.group() == "L"
        if f"{name[:i]}{'R' if left else 'L'}{name[i + 1 :]}" in known:
            return "left" if left else "right"
    return None


def _curves(signal: Signal, side: Side, strides: Sequence[Stride]) -> GaitCurves:
    pairs = [(_on_stride(signal, signal.values, s), _on_stride(signal, signal.sd, s)) for s in strides]
    values, sd = (np.array([pair[k] for pair in pairs]) for k in (0, 1))
    if signal.kind == "angle":
        values = values - 360 * np.round(known_mean(values - values[:1], axis=(1,), keep=True) / 360)
    foot_off = np.array([s.values["foot_off"] for s in strides])
    return GaitCurves(signal.name, side, signal.unit, signal.axes, values, sd, foot_off)


def _on_stride(signal: Signal, values: Floats, stride: Stride) -> Floats:
    """(101, A); NaN where the recording does not hold the stride.

    An event beyond the first or last frame by less than one frame, as plates know it, is at that frame.
    """
    frame, end = 1 / signal.rate, (len(values) - 1) / signal.rate
    first, last = stride.first - signal.start, stride.last - signal.start
    if not (first > -frame and last < end + frame):
        return np.full((POINTS, values.shape[1]), np.nan)
    span = (max(first, 0.0), min(last, end))
    if signal.kind == "angle":
        values = np.degrees(np.unwrap(np.radians(values), axis=0)) if np.isfinite(values).all() else values
    return resampled(values, rate=signal.rate, span=span, points=POINTS)


def most_typical(curves: Iterable[GaitCurves], side: Side) -> int | None:
    """Index of the stride of a side nearest to the median of all, over all angles; None where there is none."""
    own = [c.values for c in curves if c.side == side and c.unit == "deg"]
    if not own:
        return None
    away = np.sum([np.nansum(np.abs(y - _median(y)), axis=(1, 2)) for y in own], axis=0)
    missing = np.sum([np.isnan(y).sum((1, 2)) for y in own], axis=0)
    return int(np.lexsort((away, missing))[0])


def _median(y: Floats) -> Floats:
    """(101, A) of strides (n, 101, A); 0 where none is known."""
    return np.asarray(np.nanmedian(np.where(np.isfinite(y).any(0), y, 0.0), axis=0))


GLUED = re.compile(r"(?<![A-Za-z])[LR](?=[A-Za-z])|(?<=[A-Za-z]{2})[LR](?![A-Za-z])")
"""A letter of a side before a word, or behind one of two letters and more; conventional."""
PROFILE = {
    "pelvic tilt": ("PelvisAngles", 0), "pelvic obliquity": ("PelvisAngles", 1), "pelvic rotation": ("PelvisAngles", 2),
    "hip flexion": ("HipAngles", 0), "hip adduction": ("HipAngles", 1), "hip rotation": ("HipAngles", 2),
    "knee flexion": ("KneeAngles", 0), "ankle dorsiflexion": ("AnkleAngles", 0),
    "foot progression": ("FootProgressAngles", 1),
}  # fmt: skip
"""The nine kinematic variables of the movement analysis profile (Baker et al. 2009)."""


OF_BOTH_SIDES = tuple(title for title in PROFILE if title.startswith("pelvic"))
"""Of the profile, what left and right share; by definition."""
FEWEST_SCORED = 4
"""Controls whose own scores make a scale; chosen: the deviation of three is known to a half."""


def movement_analysis_profile(
    curves: Sequence[GaitCurves], reference: GaitReference, side: Side
) -> tuple[dict[str, float], float]:
    """Root mean square distances, deg, of the mean curves of a side from the reference, by "knee flexion", and their
    root mean square, the gait profile score (Baker et al. 2009); NaN where a curve is missing."""
    by_name = {c.name[1:]: c.mean for c in curves if c.side == side}
    found = {}
    for title, (name, axis) in PROFILE.items():
        if name in by_name and name in reference.mean:
            difference = by_name[name][:, axis] - reference.mean[name][:, axis]
            found[title] = float(np.sqrt(np.mean(difference**2)))
        else:
            found[title] = np.nan
    return found, float(np.sqrt(np.mean(np.square(list(found.values())))))


def overall_score(left: Mapping[str, float], right: Mapping[str, float]) -> float:
    """The gait profile score of both sides, deg: of the nine variables of the left and six of the right, for both have
    one pelvis (Baker et al. 2009); NaN where one is missing.

    Args:
        left, right: distances of `movement_analysis_profile`, deg.
    """
    each = [*left.values(), *(value for title, value in right.items() if title not in OF_BOTH_SIDES)]
    return float(np.sqrt(np.mean(np.square(each))))


def scaled_score(score: float, reference: GaitReference) -> float:
    """The profile score on a scale of the controls' own: 100 is their mean, 10 less a standard deviation farther.

    100 − 10 (ln s − m) / d, with m and d of the logarithms of the controls' scores, each against the others: the scale
    of Schwartz and Rozumalski (2008), on the score of Baker et al. (2009). NaN where the reference does not know its
    controls' own.

    Args:
        score: deg. reference: that it was taken against.
    """
    if reference.log_score is None or not score > 0:
        return np.nan
    mean, sd = reference.log_score
    return float(100.0 - 10.0 * (np.log(score) - mean) / sd)


def reference_of(
    controls: Sequence[Mapping[str, Floats]], source: str, numbers: Sequence[Mapping[str, Sequence[float]]] = ()
) -> GaitReference:
    """A band of controls, each by its (101, A) mean curves by name ("LKneeAngles").

    A subject counts once, with the mean of both sides; a quantity counts where two subjects have it. A curve with gaps
    does not count: where it stops, the band would have a step.

    Args:
        controls: curves of each. source: where they are from.
        numbers: of each control, what its sides have of a time-distance parameter or a key value, by name.
    """
    each: dict[str, list[Floats]] = {}
    for means in controls:
        sides: dict[str, list[Floats]] = {}
        for name, curve in means.items():
            if np.isfinite(curve).all():
                sides.setdefault(name[1:], []).append(curve)
        for name, curves in sides.items():
            each.setdefault(name, []).append(known_mean(np.array(curves)))
    shared = {name: np.array(ys) for name, ys in each.items() if len(ys) > 1}
    mean = {name: known_mean(ys) for name, ys in shared.items()}
    sd = {name: np.sqrt(known_mean((ys - mean[name]) ** 2) * _unbiased(ys)) for name, ys in shared.items()}
    return GaitReference(mean, sd, source, len(controls), _log_score(shared), _numbers_of(numbers))


def _numbers_of(controls: Sequence[Mapping[str, Sequence[float]]]) -> dict[str, tuple[float, float]]:
    """Mean and standard deviation between subjects of each number that two or more have."""
    each: dict[str, list[float]] = {}
    for own in controls:
        for name, sides in own.items():
            if len(sides):
                each.setdefault(name, []).append(float(np.mean(sides)))
    return {name: (float(np.mean(y)), float(np.std(y, ddof=1))) for name, y in each.items() if len(y) > 1}


def _log_score(shared: Mapping[str, Floats]) -> tuple[float, float] | None:
    """Mean and standard deviation of the logarithms of the scores of subjects (n, 101, A), each against the others."""
    wanted = {name for name, _ in PROFILE.values()}
    if not wanted <= set(shared) or len({len(shared[name]) for name in wanted}) > 1:
        return None
    n = len(shared["KneeAngles"])
    if n < FEWEST_SCORED:
        return None
    squares = []
    for name, axis in PROFILE.values():
        y = shared[name][..., axis]
        others = (y.sum(0) - y) / (n - 1)
        squares.append(((y - others) ** 2).mean(1))
    scores = np.sqrt(np.mean(squares, axis=0))
    logs = np.log(scores[np.isfinite(scores) & (scores > 0)])
    return (float(logs.mean()), float(logs.std(ddof=1))) if len(logs) >= FEWEST_SCORED else None


def _unbiased(ys: Floats) -> Floats:
    """(101, A) n / (n − 1) of the n subjects with values; NaN with one alone."""
    n = np.isfinite(ys).sum(0)
    return np.where(n > 1, n / np.maximum(n - 1, 1), np.nan)


def side_of(name: str) -> Side | None:
    """Of a quantity by its first letter."""
    return next((side for side in SIDES if name.startswith(LETTER[side])), None)
