"""A C3D file as a trial, in mm, s and named channels."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from ...data import Analog, Events, ForcePlate, KinemarkError, MarkerTrajectory, Trajectories, Trial
from ...data.array_types import Bools, Floats
from .about import about_of
from .document import C3D, HALF, has_unsigned_analog, with_parameters
from .parameters import Parameter
from .points import LENGTH, Samples, distinct, kinds_of, mm_per_unit, point_names, samples_of
from .reading import read_document
from .rotations import poses_of
from .sample_table import with_covariance
from .signal_points import signals_of

N_CHANNELS = {1: 6, 2: 6, 3: 8, 4: 6}
"""Channels of each type of force plate; others have as many as the file lists; of the format."""
PLATE_COLUMNS = {"CORNERS": 3, "ORIGIN": 2, "CHANNEL": 2, "CAL_MATRIX": 3}
"""Parameters of a force plate and how many dimensions they have."""


def read_c3d(
    path: Path | str, *, units: str | None = None, rate_hz: float | None = None, partial: bool = False
) -> Trial:
    """A trial from a C3D file. `Trial.source` keeps the file's own document, so that writing gives it back.

    Args:
        path: the file.
        units: unit of its lengths where the file is silent or wrong: "mm", "cm", "m", "in".
        rate_hz: frames a second, where the file is silent or wrong about it.
        partial: read what there is of a damaged file; `trial.source.notes` says what is not.

    Raises:
        KinemarkError: the file cannot be read, or states no rate, an unknown unit or has lost something.
    """
    doc = read_document(path, partial=partial)
    if units is not None:
        doc = with_parameters(doc, "POINT", [Parameter.text("UNITS", units)])
    if rate_hz is not None:
        doc = with_parameters(replace(doc, rate=rate_hz), "POINT", [Parameter.real("RATE", rate_hz)])
    try:
        return trial_of(doc, name=Path(path).stem)
    except KinemarkError as error:
        raise KinemarkError(f"{path}: {error}") from error


def trial_of(doc: C3D, *, name: str) -> Trial:
    """The trial that a document holds: its positions as trajectories, its angles, forces and the like as signals.

    Raises:
        KinemarkError: its unit is unknown or its rate is.
    """
    if doc.rate <= 0:
        raise KinemarkError("the file states no frame rate. State the true one: --rate-hz (rate_hz=100.0).")
    analog, names = analog_of(doc), point_names(doc)
    kinds = kinds_of(doc, names)
    samples, cov, about_table = with_covariance(doc, samples_of(doc))
    return Trial(
        name=name,
        trajectories=Trajectories(_markers(names, kinds, samples, cov), doc.rate, doc.first_frame),
        analog=() if analog is None else (analog,),
        plates=plates_of(doc),
        events=events_of(doc),
        source=doc,
        signals=signals_of(doc, names, kinds, samples.xyz),
        poses=poses_of(doc),
        about=about_of(doc),
        notes=(*doc.notes, *_about_marks(doc), *about_table),
    )


def _markers(names: Sequence[str], kinds: Sequence[str], samples: Samples, cov: Floats) -> tuple[MarkerTrajectory, ...]:
    """The points that are positions."""
    return tuple(
        MarkerTrajectory(name, samples.xyz[i], cov[i], samples.origin[i], samples.residual[i], samples.cameras[i])
        for i, (name, kind) in enumerate(zip(names, kinds, strict=True))
        if kind == LENGTH
    )


def analog_names(doc: C3D) -> tuple[str, ...]:
    """(A) the names of the channels, all different; "channel 3" where the file has none."""
    return distinct(doc.texts("ANALOG", "LABELS"), len(doc.analog), "channel ")


def analog_scaling(doc: C3D) -> tuple[Floats, Floats]:
    """Factors and offsets (A): value = (raw − offset) factor, with factor = GEN_SCALE SCALE; 1 and 0 where absent."""
    n, offsets = len(doc.analog), doc.series("ANALOG", "OFFSET")
    factor, offset = np.ones(n), np.zeros(n)
    scale = doc.numbers("ANALOG", "SCALE")[:n]
    zero = np.concatenate([np.zeros(0), *(p.unsigned if has_unsigned_analog(doc) else p.numbers for p in offsets)])[:n]
    factor[: len(scale)], offset[: len(zero)] = scale, zero
    return np.nan_to_num(factor * doc.number("ANALOG", "GEN_SCALE", 1.0)), np.nan_to_num(offset)


def analog_of(doc: C3D) -> Analog | None:
    """The channels in their units; None where the file has no samples."""
    n = len(doc.analog)
    if not n or not doc.samples:
        return None
    units, values = (*doc.texts("ANALOG", "UNITS"), *[""] * n)[:n], np.empty(doc.analog.shape)
    for channel, own in zip(values, channels_of(doc), strict=True):
        channel[:] = own
    return Analog(analog_names(doc), units, doc.rate * doc.samples, values)


def channels_of(doc: C3D) -> Iterator[Floats]:
    """(N) each channel in its unit, one by one: all at once take several times the file's memory."""
    for raw, factor, offset in zip(doc.analog, *analog_scaling(doc), strict=True):
        with np.errstate(invalid="ignore", over="ignore"):  # a damaged file may hold any number
            yield (np.where(_marked(doc, raw), np.nan, raw) - offset) * factor


def _about_marks(doc: C3D) -> tuple[str, ...]:
    """What is said of marked samples."""
    counts = np.array([_marked(doc, raw).sum() for raw in doc.analog], int)
    names = [name for name, n in zip(analog_names(doc), counts, strict=True) if n]
    return (f"analog: {counts.sum()} samples of {', '.join(names)} are −32 768 and count as missing",) if names else ()


def _marked(doc: C3D, channel: Floats) -> Bools:
    """(N) samples of signed integers that are −32 768 where all others of their channel are far from it.

    A signal that is clipped comes near to the end of the range before; a mark for what was not sampled stands alone.
    """
    if doc.floats or has_unsigned_analog(doc):
        return np.zeros(channel.shape, np.bool_)
    least = channel == HALF
    others = np.where(least, np.inf, channel).min(initial=np.inf)
    return np.asarray(least & (others > HALF // 2) & (others < np.inf))


def plates_of(doc: C3D) -> tuple[ForcePlate, ...]:
    """The force plates, lengths in mm; what the file does not state is NaN."""
    types = np.nan_to_num(doc.numbers("FORCE_PLATFORM", "TYPE"))
    used = doc.number("FORCE_PLATFORM", "USED", len(types))
    count = int(min(len(types), used)) if used > 0 else 0
    channels, factor = analog_names(doc), mm_per_unit(doc)
    corners, origin, channel, matrix = (_column(doc, name, ndim, count) for name, ndim in PLATE_COLUMNS.items())
    rows = zip(types[:count], corners, origin, channel, matrix, strict=True)
    plates = (_plate(int(kind), *row, names=channels, factor=factor) for kind, *row in rows)
    return tuple(replace(plate, zero_frames=_zero_frames(doc)) for plate in plates)


def _zero_frames(doc: C3D) -> Floats | None:
    """(2) first and last frame of the baseline, from 0; None where the file states none that is in it."""
    stated = doc.numbers("FORCE_PLATFORM", "ZERO")
    if len(stated) < 2 or not 1 <= stated[0] <= stated[1]:
        return None
    first, last = stated[:2] - doc.first_frame
    return np.array([first, last]) if 0 <= first <= last < len(doc.points) else None


def _column(doc: C3D, name: str, ndim: int, count: int) -> Floats:
    """A parameter, one row a plate; empty rows where it is absent or short.

    Some files leave out the last dimension where there is one plate.
    """
    parameter = doc.get("FORCE_PLATFORM", name)
    if parameter is None or parameter.is_text:
        return np.zeros((count, 0))
    values = parameter.values[None] if count == 1 and parameter.values.ndim == ndim - 1 else parameter.values
    return values[:count].astype(np.float64) if values.ndim == ndim and len(values) >= count else np.zeros((count, 0))


def _plate(
    kind: int,
    corners: Floats,
    origin: Floats,
    channel: Floats,
    matrix: Floats,
    *,
    names: tuple[str, ...],
    factor: float,
) -> ForcePlate:
    listed = [int(c) for c in np.nan_to_num(channel)][: N_CHANNELS.get(kind)]
    return ForcePlate(
        type=kind,
        corners=_shaped(corners, (4, 3)) * factor,
        origin=_shaped(origin, (3,)) * factor,
        channels=tuple(names[c - 1] for c in listed if 0 < c <= len(names)),
        calibration=matrix.T if kind not in (1, 2, 3) and matrix.ndim == 2 and matrix.size else None,
    )


def _shaped(values: Floats, shape: tuple[int, ...]) -> Floats:
    return values if values.shape == shape else np.full(shape, np.nan)


def events_of(doc: C3D) -> Events:
    """The events of the EVENT group, or those of the header where it has none.

    EVENT:TIMES holds minutes and seconds of each, whether as a table or flat, or seconds alone.
    """
    times, labels = doc.numbers("EVENT", "TIMES"), doc.texts("EVENT", "LABELS")
    used = doc.number("EVENT", "USED", max(len(labels), len(times) // 2))
    count = int(used) if 0 < used < 2**16 else 0
    if len(times) >= 2 * count:
        times = times[: 2 * count : 2] * 60 + times[1 : 2 * count : 2]
    count = min(count, len(times))
    if not count:
        header = doc.header_events
        names = tuple(event.label.strip(" \0") for event in header)
        return Events(names, ("",) * len(header), np.array([event.time for event in header]))
    blank = ("",) * count
    sides = (*doc.texts("EVENT", "CONTEXTS"), *blank)[:count]
    return Events((*labels, *blank)[:count], sides, times[:count])
