"""Force plates to ground reactions: force, centre of pressure and free moment, at the markers' frames.

A plate's own axes, from its corners c₁ … c₄, are

    x = (c₁ + c₄) − (c₂ + c₃),   y = (c₁ + c₂) − (c₃ + c₄),   z = x × y                                      (1)

and in them, with force F and moment M about the sensor, whose place below the middle of the surface is o,

    M′ = M − o × F,   p = (−M′_y, M′_x, 0) / F_z,   T = M′_z − (p_x F_y − p_y F_x)                             (2)

are the moment about the surface's middle, the centre of pressure and the free moment. An eight-channel plate (type 3)
of sensors at (±a, ±b) adds up to

    F = (x₁₂ + x₃₄, y₁₄ + y₂₃, z₁ + z₂ + z₃ + z₄)
    M = (b (z₁ + z₂ − z₃ − z₄), a (−z₁ + z₂ + z₃ − z₄), b (−x₁₂ + x₃₄) + a (y₁₄ − y₂₃))                       (3)

Some plates write what the foot does to them and others what they do to the foot; a floor only pushes upwards, so the
sign is the one with which it does (4). Where the file says in which frames nothing stands on a plate
(FORCE_PLATFORM:ZERO), and nothing does, each channel is less its mean there (5). A sample that is missing is no
force of 0: up to half a frame of them lie between their neighbours, else the frame is unknown, and between loaded
frames the foot is taken to have stayed (6). The sensor is below the surface: where o would have it above, it is −o. Of
corners that go round the other way z is up, and so is o (7).

Source: C3D file format user guide, types 1 to 5.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..data import Analog, ForcePlate, KinemarkError
from ..data.array_types import Bools, Floats
from ..numerics.runs import true_runs
from .segments import Z_UP, unit

THRESHOLD_N = 5.0
"""Vertical force from which a plate counts as loaded, N; conventional (Plug-in Gait)."""
QUIET_SHARE = 0.1
"""Of a channel's range that it may move by in (5); chosen: noise is a hundredth, a foot moves it by all of it."""
FACES_UP = 0.5
"""Cosine of a plate's z with up, from which it counts as up; chosen: plates in walls are neither, and as usual."""
CHANNELS = {1: 6, 2: 6, 3: 8, 4: 6, 5: 8}
"""Of each type of plate; of the file format."""
IN_NEWTON = {"N": 1.0, "KN": 1000.0}
"""Force units; by definition."""
IN_NEWTON_MM = {"NMM": 1.0, "NM": 1000.0, "NCM": 10.0, "NMETERS": 1000.0, "KNMM": 1000.0, "KNM": 1e6}
"""Moment units; by definition."""
IN_MM = {"MM": 1.0, "CM": 10.0, "M": 1000.0}
"""Units of a centre of pressure (type 1); by definition."""


@dataclass(frozen=True, slots=True, eq=False)
class Reaction:
    """What one plate does to the body over F frames.

    Attributes:
        force: (F, 3) N; 0 where the plate is not loaded, NaN where it is and by how much is unknown.
        centre: (F, 3) mm of pressure; NaN where it is not loaded, or unknown.
        free_moment: (F, 3) N·m about the vertical of the plate.
        loaded: (F).
        corners: (4, 3) mm of the plate.
        unknown: (F) frames in which a channel has a missing sample.
    """

    force: Floats
    centre: Floats
    free_moment: Floats
    loaded: Bools
    corners: Floats
    unknown: Bools


def reaction(
    plate: ForcePlate,
    analog: Sequence[Analog],
    *,
    n_frames: int,
    rate: float,
    threshold_n: float = THRESHOLD_N,
    averaged: bool = True,
    up: Floats = Z_UP,
) -> Reaction:
    """The ground reaction of a plate at each frame of the markers.

    Args:
        plate: with the names of its channels.
        analog: the channels of the trial.
        n_frames, rate: of the markers, Hz.
        threshold_n: vertical force from which it is loaded.
        averaged: take the mean of as many samples as a frame has, centred on it; else the one sample.
        up: of the laboratory.

    Raises:
        KinemarkError: the plate is of an unknown type, or a channel is missing.
    """
    channels = plate_channels(plate, analog, n_frames=n_frames, rate=rate, averaged=averaged)
    R, middle = plate_axes(plate.corners)
    force, moment, centre = _in_plate(plate, channels, outward=1.0 if R[:, 2] @ up > FACES_UP else -1.0)
    sign = 1.0 if np.nansum((force @ R.T) @ up) >= 0 else -1.0  # (4)
    unknown: Bools = np.asarray(~np.isfinite(force).all(axis=1), np.bool_)
    loaded = _bridged(np.asarray(np.abs(force[:, 2]) > threshold_n), unknown)  # (6)
    if centre is None:
        centre, free = _centre(force, moment, loaded)
    else:
        free = moment[:, 2]
    down = np.where(loaded, sign * free, 0.0)[:, None] * R[:, 2] / 1000.0
    return Reaction(
        np.where(loaded[:, None], sign * force @ R.T, 0.0),
        np.where(loaded[:, None], middle + centre @ R.T, np.nan),
        down,
        loaded,
        plate.corners,
        unknown,
    )


def _bridged(loaded: Bools, unknown: Bools) -> Bools:
    """(F) loaded frames with the unknown ones between them (6)."""
    for first, stop in true_runs(unknown):
        if first > 0 and stop < len(loaded) and loaded[first - 1] and loaded[stop]:
            loaded[first:stop] = True
    return loaded


def plate_axes(corners: Floats) -> tuple[Floats, Floats]:
    """(3, 3) axes (1) as columns, and (3) mm the middle of the surface."""
    c = corners
    x, y = unit(c[0] + c[3] - c[1] - c[2]), c[0] + c[1] - c[2] - c[3]
    z = unit(np.cross(x, y))
    return np.stack([x, np.cross(z, x), z], -1), c.mean(0)


def _centre(force: Floats, moment: Floats, loaded: Bools) -> tuple[Floats, Floats]:
    """(F, 3) mm and (F) N·mm of (2), from the moment about the surface."""
    with np.errstate(invalid="ignore", divide="ignore"):
        x, y = (np.where(loaded, part / force[:, 2], np.nan) for part in (-moment[:, 1], moment[:, 0]))
    return np.stack([x, y, 0 * x], -1), moment[:, 2] - (x * force[:, 1] - y * force[:, 0])


def _in_plate(plate: ForcePlate, channels: Floats, *, outward: float) -> tuple[Floats, Floats, Floats | None]:
    """(F, 3) N force, (F, 3) N·mm moment about the surface, and (F, 3) mm centre where it is measured, plate's axes.

    Args:
        plate, channels: of the plate. outward: 1 where its z goes from the sensor to the surface, −1 where it goes into
            the floor, as is usual.
    """
    if plate.type == 1:
        force, centre = channels[:, :3], np.concatenate([channels[:, 3:5], np.zeros((len(channels), 1))], 1)
        return force, channels[:, 5:6] * (0.0, 0.0, 1.0), centre
    if plate.type in (4, 5):
        if plate.calibration is None:
            raise KinemarkError(f"A force plate of type {plate.type} has no calibration matrix. Give the whole file.")
        channels = channels @ plate.calibration.T
    if plate.type == 3:
        a, b, height = plate.origin
        channels = np.concatenate(_eight(channels, a, b), axis=1)
        origin = np.array([0.0, 0.0, height])
    else:
        origin = plate.origin
    below = -origin if origin[2] * outward < 0 else origin  # the sensor is below the surface (7)
    force, moment = channels[:, :3], channels[:, 3:6]
    return force, moment - np.cross(below, force), None  # (2)


def _eight(c: Floats, a: float, b: float) -> tuple[Floats, Floats]:
    """(3): force and moment of an eight-channel plate."""
    x12, x34, y14, y23, z1, z2, z3, z4 = c.T
    force = np.stack([x12 + x34, y14 + y23, z1 + z2 + z3 + z4], -1)
    moment = [b * (z1 + z2 - z3 - z4), a * (-z1 + z2 + z3 - z4), b * (-x12 + x34) + a * (y14 - y23)]
    return force, np.stack(moment, -1)


def plate_channels(
    plate: ForcePlate, analog: Sequence[Analog], *, n_frames: int, rate: float, averaged: bool
) -> Floats:
    """(F, K) the channels of a plate at each frame, N, N·mm and, of a measured centre, mm.

    Raises:
        KinemarkError: the plate is of an unknown type, or a channel is missing.
    """
    wanted = CHANNELS.get(plate.type)
    if wanted is None or len(plate.channels) < wanted:
        raise KinemarkError(
            f"A force plate is of type {plate.type} with {len(plate.channels)} channels. Types 1 to 5 with 6 or 8 "
            "channels can be read."
        )
    names = plate.channels[:wanted]
    for record in analog:
        if set(names) <= set(record.names):
            values = np.stack([record[name] * _to_house(record, name) for name in names], -1)
            values = values - _baseline(values, record, plate, rate)
            return at_frames(values, record, n_frames=n_frames, rate=rate, averaged=averaged)
    raise KinemarkError(f"The channels {', '.join(names)} of a force plate are not in the trial.")


def _baseline(values: Floats, record: Analog, plate: ForcePlate, rate: float) -> Floats:
    """(K) mean of channels (N, K) over the frames in which the file says that nothing stands on the plate (5)."""
    if plate.zero_frames is None:
        return np.zeros(values.shape[1])
    first, stop = ((frame / rate - record.start) * record.rate for frame in np.add(plate.zero_frames, (0, 1)))
    quiet = values[max(round(first), 0) : max(round(stop), 0)]
    quiet = quiet[np.isfinite(quiet).all(1)]
    known = values[np.isfinite(values).all(1)]
    steady = len(quiet) and bool((np.ptp(quiet, axis=0) <= QUIET_SHARE * np.ptp(known, axis=0)).all())
    return np.asarray(quiet.mean(0)) if steady else np.zeros(values.shape[1])


def _to_house(record: Analog, name: str) -> float:
    """Factor to N, N·mm or mm; 1 where the unit is unknown, as a calibration matrix may follow."""
    stated = record.units[record.names.index(name)].upper()
    plain = "".join(letter for letter in stated if letter.isalpha())
    return (IN_NEWTON | IN_NEWTON_MM | IN_MM).get(plain, 1.0)


def at_frames(values: Floats, record: Analog, *, n_frames: int, rate: float, averaged: bool) -> Floats:
    """(F, K) of (N, K) samples at the markers' frames: with k samples a frame, the mean of 2 ⌊k / 2⌋ + 1 about each.

    NaN where more than ⌊k / 2⌋ in a row are missing (6).
    """
    k = record.rate / rate
    sample = np.round((np.arange(n_frames) / rate - record.start) * record.rate).astype(np.int64)
    half = int(k // 2) if averaged else 0
    values = _with_short_gaps(values, half)
    first, stop = np.clip(sample - half, 0, len(values)), np.clip(sample + half + 1, 0, len(values))
    total = np.concatenate(
        [np.zeros((1, values.shape[1])), np.cumsum(np.where(np.isfinite(values), values, 0.0), axis=0)]
    )
    missing = np.concatenate([[0], np.cumsum(~np.isfinite(values).all(1))])
    with np.errstate(invalid="ignore", divide="ignore"):
        mean = (total[stop] - total[first]) / (stop - first)[:, None]
    return np.asarray(np.where((missing[stop] > missing[first])[:, None], np.nan, mean))


def _with_short_gaps(values: Floats, most: int) -> Floats:
    """(N, K) samples with those in gaps of at most so many on the line between the ones beside them."""
    known = np.isfinite(values).all(1)
    n = len(values)
    short = [np.arange(a, b) for a, b in true_runs(np.asarray(~known)) if b - a <= most and a > 0 and b < n]
    if not short:
        return values
    gaps, there, whole = np.concatenate(short), np.flatnonzero(known), values.copy()
    for column in range(values.shape[1]):
        whole[gaps, column] = np.interp(gaps, there, values[there, column])
    return whole
