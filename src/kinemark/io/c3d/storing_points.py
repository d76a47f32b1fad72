"""Markers and signals as the points of a C3D document."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...data import KinemarkError, Origin, Trajectories, Trial
from ...data.array_types import Bools, Floats
from ..notes import FileNote
from .document import C3D, HALF
from .parameter_tables import matched, with_descriptions, with_text
from .points import LENGTH, Samples, mm_per_unit, point_names, samples_of
from .provenance import with_filled
from .signal_points import SD, SignalPoint, points_of, with_listed, with_stated

MOST_COUNTS = 32767  # of a signed word of 16 bits; of the format
FULL_SCALE = 32000.0  # counts that the farthest coordinate gets; chosen: a little room below 32 767
OFF_ORIGIN = 1e-6
"""How far from (0, 0, 0), in file units, a sample at the very origin is written, because zeros say missing; chosen."""


def with_points(doc: C3D, source: C3D, trial: Trial, *, floats: bool) -> tuple[C3D, tuple[FileNote, ...]]:
    """The document with the trial's markers and signals as points, and what that changed of the signals.

    Args:
        doc: the document. source: what is kept of unchanged samples.
        trial: what it is to hold. floats: or integers.

    Raises:
        KinemarkError: a marker and a signal have one name.
    """
    first = trial.trajectories.first_frame
    n = _n_frames(trial, source)
    others, notes = points_of(trial.signals, trial.trajectories.rate, n)
    new, old = _point_table(trial.trajectories, others, source, n), samples_of(source)
    samples = _with_marks(new, old, source, first)
    factor = np.where(new.listed == LENGTH, mm_per_unit(source), 1.0)
    points = np.nan_to_num((samples.xyz / factor[:, None, None]).transpose(1, 0, 2))
    residual = (samples.residual / factor[:, None]).T
    scale = _scale(source, points, residual, floats)
    word = _words(samples, residual, scale)
    if source.points.size:
        points, word = _kept(samples, old, source, new.rows, first, points, word, scale, floats)
    seen = (samples.origin != Origin.MISSING).T
    points = _rounded(points, scale, floats, seen & ((new.listed == LENGTH) | (new.listed == "ANGLES")))
    none = np.zeros((0, 0))  # analog, until it is stored
    doc = replace(doc, points=points, word=word, analog=none, scale=scale, floats=floats, first_frame=first)
    doc = with_stated(with_listed(_with_labels(doc, source, new), new.names, new.listed.tolist()), trial.signals)
    return with_filled(doc, trial.trajectories, samples_of(doc).origin[new.listed == LENGTH]), notes


class PointTable(NamedTuple):
    """M points in the order of the file.

    Attributes:
        names: (M) labels. listed: (M) LENGTH for a marker, else the parameter that lists it.
        rows: (M) row of the source that each comes from, −1 for none.
        texts: (M) what its description is to be; None as in the source.
        samples: their numbers.
    """

    names: tuple[str, ...]
    listed: NDArray[np.object_]
    rows: list[int]
    texts: tuple[str | None, ...]
    samples: Samples


def _point_table(trajectories: Trajectories, others: Sequence[SignalPoint], source: C3D, n: int) -> PointTable:
    """Markers and quantities, in the order of the source where they come from it."""
    names = (*trajectories.names, *(point.name for point in others))
    taken = set(trajectories.names)
    for point in others:
        if point.name in taken:
            raise KinemarkError(f"The trial has a marker called {point.name}, as a signal is. Rename one of them.")
        taken.add(point.name)
    rows = matched(names, point_names(source))
    order = _in_order(rows, len(trajectories), [point.name.endswith(SD) for point in others])
    listed = [LENGTH] * len(trajectories) + [point.listed for point in others]
    texts = [None] * len(trajectories) + [point.description for point in others]
    samples = _samples(trajectories, others, n)
    return PointTable(
        tuple(names[i] for i in order),
        np.array([listed[i] for i in order], dtype=object),
        [rows[i] for i in order],
        tuple(texts[i] for i in order),
        Samples(*(getattr(samples, f.name)[order] for f in fields(samples))),
    )


def _in_order(rows: Sequence[int], markers: int, deviation: Sequence[bool]) -> list[int]:
    """Markers, quantities and deviations, each in their order, merged as the rows of the source say; new ones last."""
    kind = [0] * markers + [1 + own for own in deviation]
    key = np.empty(len(rows))
    for which in range(3):
        own = [i for i, one in enumerate(kind) if one == which]
        at = np.array([rows[i] for i in own], np.float64)
        known = np.flatnonzero(at >= 0)
        at[known[-1] + 1 if len(known) else 0 :] = np.inf
        key[own] = np.maximum.accumulate(at)
    return sorted(range(len(rows)), key=lambda i: (key[i], kind[i]))


def _with_labels(doc: C3D, source: C3D, new: PointTable) -> C3D:
    """The document with labels and descriptions of its points."""
    had = point_names(source)
    if len(new.rows):
        doc = with_text(doc, "POINT", "LABELS", new.names, new.rows, had)
    doc = with_descriptions(doc, "POINT", new.rows, len(had))
    old = (*doc.texts("POINT", "DESCRIPTIONS"), *[""] * len(new.names))[: len(new.names)]
    wanted = [was if text is None else text for text, was in zip(new.texts, old, strict=True)]
    return doc if wanted == list(old) else with_text(doc, "POINT", "DESCRIPTIONS", wanted, range(len(wanted)), old)


def _with_marks(new: PointTable, old: Samples, source: C3D, first_frame: int) -> Samples:
    """The samples; what is no marker has the residual, cameras and origin of the source, as far as it is as missing."""
    samples, n = new.samples, new.samples.xyz.shape[1]
    at = np.arange(n) + first_frame - source.first_frame
    frames = np.flatnonzero((at >= 0) & (at < len(source.points)))
    for i in np.flatnonzero((new.listed != LENGTH) & (np.array(new.rows, np.int64) >= 0)).tolist():
        was = old.origin[new.rows[i], at[frames]]
        both = (was == Origin.MISSING) == (samples.origin[i, frames] == Origin.MISSING)
        to, of = frames[both], at[frames[both]]
        for name in ("residual", "cameras", "origin"):
            getattr(samples, name)[i, to] = getattr(old, name)[new.rows[i], of]
    return samples


def _n_frames(trial: Trial, source: C3D) -> int:
    """Frames of the trial, which without markers are those of its source, its signals, its poses or its channels."""
    rate = trial.trajectories.rate
    if len(trial.trajectories) or len(source.points):
        return trial.trajectories.n_frames if len(trial.trajectories) else len(source.points)
    ends = [s.start + len(s) / s.rate for s in trial.signals]
    ends += [p.start + p.reliability.shape[1] / p.rate for p in trial.poses]
    ends = ends or [a.start + a.values.shape[1] / a.rate for a in trial.analog]
    return max(0, round(max(ends, default=0.0) * rate))


def _samples(trajectories: Trajectories, others: Sequence[SignalPoint], n: int) -> Samples:
    """Markers, then the other points, which are measured where they are known."""
    paths, m, shape = trajectories.paths, len(trajectories), (len(others), n)
    xyz = np.array([point.xyz for point in others]).reshape(*shape, 3)
    known = np.isfinite(xyz).all(2)
    return Samples(
        xyz=np.concatenate([np.array([path.xyz for path in paths]).reshape(m, n, 3), xyz]),
        residual=np.concatenate([np.array([p.residual for p in paths]).reshape(m, n), np.full(shape, np.nan)]),
        cameras=np.concatenate(
            [np.array([p.cameras for p in paths], np.uint32).reshape(m, n), np.zeros(shape, np.uint32)]
        ),
        origin=np.concatenate(
            [np.array([p.origin for p in paths], np.uint8).reshape(m, n), (known * Origin.MEASURED).astype(np.uint8)]
        ),
    )


def _scale(source: C3D, points: Floats, residual: Floats, floats: bool) -> float:
    """File units a count: the source's where it serves, else such that the farthest point has 32 000 counts."""
    most = float(np.abs(points).max(initial=0.0))
    if source.points.size and floats:
        return source.scale
    within = points.min(initial=0.0) >= HALF * source.scale and points.max(initial=0.0) <= MOST_COUNTS * source.scale
    fits = within and (not source.floats or source.scale <= most / 8000)
    if source.points.size and fits:
        return source.scale
    resolved = float(np.nan_to_num(residual).max(initial=0.0)) / 255 if floats else 0.0
    return float(np.float32(max(most / FULL_SCALE, resolved) or 1.0))


def _words(new: Samples, residual: Floats, scale: float) -> Floats:
    """(F, M) residual in counts of the scale and cameras; at least 1 when measured, 0 when filled, −1 when missing."""
    origin, cameras = new.origin.T, new.cameras.T.astype(np.int64)
    counts = np.clip(np.rint(np.nan_to_num(residual) / scale), 0, 255).astype(np.int64)
    known = (cameras != 0) | (residual > 0)
    word = np.where(known, np.maximum(counts | (cameras & 0x7F) << 8, 1), 0)
    word = np.where(origin == Origin.MEASURED, word, 0)
    return np.where(origin == Origin.MISSING, -1, word).astype(np.float64)


def _kept(
    new: Samples,
    old: Samples,
    source: C3D,
    rows: Sequence[int],
    first_frame: int,
    points: Floats,
    word: Floats,
    scale: float,
    floats: bool,
) -> tuple[Floats, Floats]:
    """Points and words, with the source's own numbers wherever they say the same."""
    n = len(points)
    frame = np.arange(n) + first_frame - source.first_frame
    there = (frame >= 0) & (frame < len(source.points))
    known = (np.array(rows, np.int64) >= 0)[:, None] & there
    pick = np.ix_(np.maximum(rows, 0).astype(np.int64), np.clip(frame, 0, len(source.points) - 1))
    place = (known & _equal(new.xyz, old.xyz[pick]).all(-1)).T
    stored, marks = (a.swapaxes(0, 1)[pick].swapaxes(0, 1) for a in (source.points, source.word))
    if not floats:
        place &= ((stored >= HALF * scale) & (stored <= MOST_COUNTS * scale)).all(-1)
    unchanged = place & (_equal(new.residual, old.residual[pick]) & (new.cameras == old.cameras[pick])).T
    unchanged &= (new.origin == old.origin[pick]).T & (scale == source.scale)
    if not floats:
        unchanged &= (marks == np.rint(marks)) & (np.abs(marks) <= MOST_COUNTS)
    mixed = np.where(unchanged, marks, word)
    if (mixed >= 0).any():  # a source that marks every sample as missing must not do so for some
        mixed = np.where((word >= 0) & ~(mixed >= 0), word, mixed)
    return np.where(place[..., None], stored, points), mixed


def _equal(a: Floats, b: Floats) -> Bools:
    return (a == b) | (np.isnan(a) & np.isnan(b))


def _rounded(points: Floats, scale: float, floats: bool, not_zero: Bools) -> Floats:
    """Points as the file will hold them; `not_zero` (F, M) are moved off the origin by the least that shows."""
    whole = points.astype(np.float32).astype(np.float64) if floats else np.rint(points / scale) * scale
    frame, marker = np.nonzero(not_zero & (whole == 0).all(-1))
    far = np.abs(points[frame, marker]).argmax(-1)
    whole[frame, marker, far] = np.copysign(np.float32(OFF_ORIGIN) if floats else scale, points[frame, marker, far])
    return whole
