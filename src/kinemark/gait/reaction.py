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
sign is the one with which it does (4). While nothing stands on a plate, in the frames that the file states
(FORCE_PLATFORM:ZERO) if nothing does then, else where its force shows it (`plate_baseline`), its channels have a mean
that each of them is less (5). A sample that is missing is no force of 0: up to half a frame of them lie between their
neighbours, else the frame is unknown, and between loaded frames the foot is taken to have stayed (6). The sensor is
below the surface: where o would have it above, it is −o. Of corners that go round the other way z is up, and so is o
(7).

Where markers are low-passed and forces are not, a force that rises in a moment meets accelerations that do not: moments
of knee and hip have a peak at foot strike that no muscle makes. So forces and moments may be filtered at the markers'
cut-off (8) (Bisseling and Hof 2006; Kristianslund et al. 2012). Which frames are loaded follows from the unfiltered
force, and the centre of pressure from what is filtered.

Source: C3D file format user guide, types 1 to 5.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..data import Analog, ForcePlate, KinemarkError
from ..data.array_types import Bools, Floats
from ..numerics.runs import true_runs
from ..signal.filters import butterworth, edge_samples
from .plate_baseline import loads_one_way, unloaded
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
IN_NEWTON_MM = {"NMM": 1.0, "NM": 1000.0, "NCM": 10.0, "KNMM": 1000.0, "KNM": 1e6}
"""Moment units; by definition."""
IN_MM = {"MM": 1.0, "CM": 10.0, "M": 1000.0}
"""Units of a centre of pressure (type 1); by definition."""
IN_LETTERS = re.compile(
    "(?P<kilo>KILO)|(?P<milli>MILLI)|(?P<centi>CENTI)|(?P<newton>NEWTONS?)|(?P<metre>MET(?:ER|RE)S?)"
)
"""Words of units; by definition."""
LETTERS = {"kilo": "K", "milli": "M", "centi": "C", "newton": "N", "metre": "M"}
"""Their letters; by definition."""


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
        baseline_n: the greatest component of the force that was taken off (5), N.
    """

    force: Floats
    centre: Floats
    free_moment: Floats
    loaded: Bools
    corners: Floats
    unknown: Bools
    baseline_n: float = 0.0


def reaction(
    plate: ForcePlate,
    analog: Sequence[Analog],
    *,
    n_frames: int,
    rate: float,
    threshold_n: float = THRESHOLD_N,
    averaged: bool = True,
    zeroed: bool = False,
    cutoff_hz: float | None = None,
) -> Reaction:
    """The ground reaction of a plate at each frame of the markers.

    Args:
        plate: with the names of its channels.
        analog: the channels of the trial.
        n_frames, rate: of the markers, Hz.
        threshold_n: vertical force from which it is loaded.
        averaged: take the mean of as many samples as a frame has, centred on it; else the one sample.
        zeroed: the baseline (5) is taken from the data where the file states none; it is 0 else.
        cutoff_hz: of a low-pass filter of force and moment (8); none where None.

    Raises:
        KinemarkError: the plate is of an unknown type, a channel is missing, or too slow for the cut-off.
    """
    record, values = _recorded(plate, analog)
    baseline = _baseline(values, record, plate, rate, zeroed)
    R, middle = plate_axes(plate.corners)
    outward = 1.0 if R[:, 2] @ Z_UP > FACES_UP else -1.0

    def in_plate(samples: Floats) -> tuple[Floats, Floats, Floats | None]:
        channels = at_frames(samples, record, n_frames=n_frames, rate=rate, averaged=averaged)
        return _in_plate(plate, channels, outward=outward)

    force, moment, centre = in_plate(values - baseline)
    unknown: Bools = np.asarray(~np.isfinite(force).all(axis=1), np.bool_)
    loaded = _bridged(np.asarray(np.abs(force[:, 2]) > threshold_n), unknown)  # (6)
    if cutoff_hz is not None:
        force, moment, centre = in_plate(_low_passed(plate, values - baseline, record.rate, cutoff_hz))  # (8)
    sign = 1.0 if np.nansum((force @ R.T) @ Z_UP) >= 0 else -1.0  # (4)
    if centre is None:
        centre, free = _centre(force, moment, loaded)
    else:
        free = moment[:, 2]
    return Reaction(
        np.where(loaded[:, None], sign * force @ R.T, 0.0),
        np.where(loaded[:, None], middle + centre @ R.T, np.nan),
        np.where(loaded, sign * free, 0.0)[:, None] * R[:, 2] / 1000.0,
        loaded,
        plate.corners,
        unknown,
        float(np.abs(_in_plate(plate, baseline[None], outward=outward)[0]).max()),
    )


def _low_passed(plate: ForcePlate, values: Floats, rate: float, cutoff_hz: float) -> Floats:
    """(N, K) channels, each stretch without a missing sample filtered (8); a measured centre by its moment.

    Raises:
        KinemarkError: the channels are too slow for the cut-off.
    """
    if cutoff_hz >= rate / 2:
        raise KinemarkError(
            f"Forces cannot be filtered at {cutoff_hz:g} Hz: the plates have {rate:g} samples a second, which show "
            f"nothing above {rate / 2:g} Hz. Give a lower cut-off."
        )
    weight = np.ones_like(values)
    if plate.type == 1:
        weight[:, 3:5] = values[:, 2:3]
    out, weighted = values.copy(), values * weight
    for first, stop in true_runs(np.asarray(np.isfinite(values).all(1), np.bool_)):
        if stop - first > edge_samples(2):
            out[first:stop] = butterworth(weighted[first:stop], rate=rate, cutoff_hz=cutoff_hz)
            if plate.type == 1:
                with np.errstate(invalid="ignore", divide="ignore"):
                    out[first:stop, 3:5] /= out[first:stop, 2:3]
    return out


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


def _recorded(plate: ForcePlate, analog: Sequence[Analog]) -> tuple[Analog, Floats]:
    """The record that has a plate's channels, and (N, K) N, N·mm and, of a measured centre, mm of them.

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
            return record, np.stack([record[name] * _to_house(record, name) for name in names], -1)
    raise KinemarkError(f"The channels {', '.join(names)} of a force plate are not in the trial.")


def _baseline(values: Floats, record: Analog, plate: ForcePlate, rate: float, zeroed: bool) -> Floats:
    """(K) mean of channels (N, K) while nothing stands on the plate (5); of a measured centre 0."""
    quiet = _stated_quiet(values, record, plate, rate)
    known = np.asarray(np.isfinite(values).all(1), np.bool_)
    if quiet is None and zeroed:
        quiet = unloaded(plate, values, record.rate)
    if quiet is None or not (quiet & known).any():
        return np.zeros(values.shape[1])
    return np.asarray(values[quiet & known].mean(0)) * ((1, 1, 1, 0, 0, 1) if plate.type == 1 else 1.0)


def _stated_quiet(values: Floats, record: Analog, plate: ForcePlate, rate: float) -> Bools | None:
    """(N) samples in which nothing stands on the plate as its file states, and nothing does; None where there are
    none."""
    if plate.zero_frames is None:
        return None
    first, stop = ((frame / rate - record.start) * record.rate for frame in np.add(plate.zero_frames, (0, 1)))
    quiet, known = np.zeros(len(values), np.bool_), np.isfinite(values).all(1)
    quiet[max(round(first), 0) : max(round(stop), 0)] = True
    quiet &= known
    steady = quiet.any() and (np.ptp(values[quiet], axis=0) <= QUIET_SHARE * np.ptp(values[known], axis=0)).all()
    return quiet if steady and loads_one_way(plate, values, quiet, record.rate) else None


def _to_house(record: Analog, name: str) -> float:
    """Factor to N, N·mm or mm; 1 where the unit is unknown, as a calibration matrix may follow."""
    stated = record.units[record.names.index(name)].upper()
    words = "".join(letter for letter in stated if letter.isalpha())
    plain = IN_LETTERS.sub(lambda word: LETTERS[str(word.lastgroup)], words)
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
