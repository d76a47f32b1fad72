"""Trajectories as the points of a C3D document."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ...data import Origin, Trajectories, Trial
from .document import C3D
from .points import LENGTH, Samples, kinds_of, mm_per_unit, point_names, samples_of
from .provenance import with_filled
from .tables import matched, with_descriptions, with_text

MOST_COUNTS = 32767
FULL_SCALE = 32000.0
OFF_ORIGIN = 1e-6
"""How far from (0, 0, 0), in file units, a sample at the very origin is written, because zeros say missing."""


def with_points(doc: C3D, source: C3D, trial: Trial, *, floats: bool) -> C3D:
    """The document with the trial's markers as points and `source` as what is kept of unchanged samples."""
    trajectories, old = trial.trajectories, point_names(source)
    rows = matched(trajectories.names, old)
    kinds = np.array(kinds_of(source, trajectories.names), dtype=object)
    factor = np.where(kinds == LENGTH, mm_per_unit(source), 1.0)
    new = _samples(trajectories, _n_frames(trial, source))
    points = np.nan_to_num((new.xyz / factor[:, None, None]).transpose(1, 0, 2))
    residual = (new.residual / factor[:, None]).T
    scale = _scale(source, points, residual, floats)
    word = _words(new, residual, scale)
    if source.points.size:
        points, word = _kept(new, source, rows, trajectories.first_frame, points, word, scale, floats)
    seen = (new.origin != Origin.MISSING).T
    points = _rounded(points, scale, floats, seen & ((kinds == LENGTH) | (kinds == "ANGLES")))
    none = np.zeros((0, 0))  # analog, until it is stored
    first = trajectories.first_frame
    doc = replace(doc, points=points, word=word, analog=none, scale=scale, floats=floats, first_frame=first)
    if len(rows):
        doc = with_text(doc, "POINT", "LABELS", trajectories.names, rows, old)
    doc = with_descriptions(doc, "POINT", rows, len(old))
    return with_filled(doc, trajectories, samples_of(doc).origin)


def _n_frames(trial: Trial, source: C3D) -> int:
    """Frames of the trial, which without markers are those of its source or of its channels."""
    if len(trial.trajectories) or len(source.points) or not trial.analog:
        return trial.trajectories.n_frames if len(trial.trajectories) else len(source.points)
    analog = trial.analog[0]
    return round(analog.values.shape[1] / max(1, round(analog.rate / trial.trajectories.rate)))


def _samples(trajectories: Trajectories, n: int) -> Samples:
    m, paths = len(trajectories), trajectories.paths
    return Samples(
        xyz=np.array([path.xyz for path in paths]).reshape(m, n, 3),
        residual=np.array([path.residual for path in paths]).reshape(m, n),
        cameras=np.array([path.cameras for path in paths], np.uint32).reshape(m, n),
        origin=np.array([path.origin for path in paths], np.uint8).reshape(m, n),
    )


def _scale(source: C3D, points: NDArray[np.float64], residual: NDArray[np.float64], floats: bool) -> float:
    """File units a count: the source's where it serves, else such that the farthest point has 32 000 counts."""
    most = float(np.abs(points).max(initial=0.0))
    if source.points.size and floats:
        return source.scale
    fits = most <= MOST_COUNTS * source.scale and (not source.floats or source.scale <= most / 8000)
    if source.points.size and fits:
        return source.scale
    resolved = float(np.nan_to_num(residual).max(initial=0.0)) / 255 if floats else 0.0
    return float(np.float32(max(most / FULL_SCALE, resolved) or 1.0))


def _words(new: Samples, residual: NDArray[np.float64], scale: float) -> NDArray[np.float64]:
    """(F, M) residual in counts of the scale and cameras; at least 1 when measured, 0 when filled, −1 when missing."""
    origin, cameras = new.origin.T, new.cameras.T.astype(np.int64)
    counts = np.clip(np.rint(np.nan_to_num(residual) / scale), 0, 255).astype(np.int64)
    known = (cameras != 0) | (residual > 0)
    word = np.where(known, np.maximum(counts | (cameras & 0x7F) << 8, 1), 0)
    word = np.where(origin == Origin.MEASURED, word, 0)
    return np.where(origin == Origin.MISSING, -1, word).astype(np.float64)


def _kept(
    new: Samples,
    source: C3D,
    rows: Sequence[int],
    first_frame: int,
    points: NDArray[np.float64],
    word: NDArray[np.float64],
    scale: float,
    floats: bool,
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Points and words, with the source's own numbers wherever they say the same."""
    old, n = samples_of(source), len(points)
    frame = np.arange(n) + first_frame - source.first_frame
    there = (frame >= 0) & (frame < len(source.points))
    known = (np.array(rows, np.int64) >= 0)[:, None] & there
    pick = np.ix_(np.maximum(rows, 0).astype(np.int64), np.clip(frame, 0, len(source.points) - 1))
    place = (known & _equal(new.xyz, old.xyz[pick]).all(-1)).T
    stored, marks = (a.swapaxes(0, 1)[pick].swapaxes(0, 1) for a in (source.points, source.word))
    if not floats:
        place &= (np.abs(stored) <= MOST_COUNTS * scale).all(-1)
    told = place & (_equal(new.residual, old.residual[pick]) & (new.cameras == old.cameras[pick])).T
    told &= (new.origin == old.origin[pick]).T & (scale == source.scale)
    if not floats:
        told &= (marks == np.rint(marks)) & (np.abs(marks) <= MOST_COUNTS)
    mixed = np.where(told, marks, word)
    if (mixed >= 0).any():  # a source that marks every sample as missing must not do so for some
        mixed = np.where((word >= 0) & ~(mixed >= 0), word, mixed)
    return np.where(place[..., None], stored, points), mixed


def _equal(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.bool_]:
    return (a == b) | (np.isnan(a) & np.isnan(b))


def _rounded(
    points: NDArray[np.float64], scale: float, floats: bool, not_zero: NDArray[np.bool_]
) -> NDArray[np.float64]:
    """Points as the file will hold them; `not_zero` (F, M) are moved off the origin by the least that shows."""
    whole = points.astype(np.float32).astype(np.float64) if floats else np.rint(points / scale) * scale
    frame, marker = np.nonzero(not_zero & (whole == 0).all(-1))
    far = np.abs(points[frame, marker]).argmax(-1)
    whole[frame, marker, far] = np.copysign(np.float32(OFF_ORIGIN) if floats else scale, points[frame, marker, far])
    return whole
