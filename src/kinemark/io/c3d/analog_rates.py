"""What C3D can hold of channels: one rate for all, k samples to every frame, from the first frame to the last.

A trial keeps each record at its own rate and start. Here, at the very end, they are laid on one clock, with the least k
for which k · frame rate ≥ the greatest of their rates (1). A record whose samples fall on that clock is only shifted
and filled up with missing samples; one whose rate divides it has every sample repeated (2); any other is interpolated
by straight lines (3), and a note says so. Samples beyond the frames are cut, with a note.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...data import Analog, KinemarkError
from ...data.array_types import Floats
from ..notes import FileNote

SAME_RATE = 1e-3
"""Share by which rates may differ and still be one, since files round them; chosen."""
SAME_TIME = 1e-3
"""Samples by which a start may be off the clock; chosen."""
MOST_SAMPLES = 65_535
"""Samples of a channel in a frame; of the format."""
MOST_DRIFT = 0.5
"""Samples by which a repeated channel may be off the clock at its end; chosen."""


def samples_a_frame(analog: Sequence[Analog], rate: float) -> int:
    """k of (1), for frames at `rate` Hz."""
    fastest = max((a.rate for a in analog), default=rate) / rate
    near = round(fastest)
    return max(1, near if abs(fastest - near) <= SAME_RATE * fastest else int(np.ceil(fastest)))


def on_frames(analog: Sequence[Analog], rate: float, n_frames: int) -> tuple[Analog | None, tuple[FileNote, ...]]:
    """All channels as one record that begins and ends with the frames, and what that changed.

    Args:
        analog: the records of a trial.
        rate: of the frames, Hz. n_frames: their number.

    Raises:
        KinemarkError: more samples fall on a frame than the format counts, as with a wrong rate of the frames.
    """
    if not analog:
        return None, ()
    k = samples_a_frame(analog, rate)
    if k > MOST_SAMPLES:
        raise KinemarkError(
            f"With {rate:g} frames a second {k} samples of the channels fall on a frame. C3D holds {MOST_SAMPLES}. "
            "Correct the rate of the frames or that of the channels, or write HDF5 (.h5)."
        )
    whole = k * rate
    if all(abs(a.rate - whole) <= SAME_RATE * whole for a in analog):
        whole = analog[0].rate  # as the source states it
    if (
        len(analog) == 1
        and analog[0].rate == whole
        and analog[0].start == 0
        and analog[0].values.shape[1] == k * n_frames
    ):
        return analog[0], ()  # as it is, without a copy of what may be most of a file
    laid = [_on_clock(a, whole, k * n_frames) for a in analog]
    names = tuple(name for a in analog for name in a.names)
    units = tuple(unit for a in analog for unit in a.units)
    notes = tuple(note for _, own in laid for note in own)
    return Analog(names, units, whole, np.concatenate([values for values, _ in laid])), notes


def _on_clock(a: Analog, rate: float, n: int) -> tuple[Floats, list[FileNote]]:
    """One record as n samples at a rate, and what that changed."""
    ratio, start, out = rate / a.rate, a.start * rate, np.full((len(a), n), np.nan)
    times: int = round(ratio)
    notes: list[FileNote] = []
    if not a.values.size:
        return out, notes
    drift = abs(ratio - times) * a.values.shape[1]
    if drift <= MOST_DRIFT and abs(start - round(start)) <= SAME_TIME:
        _put(out, np.repeat(a.values, times, axis=1), round(start))  # (2)
    else:
        at = (np.arange(n) / rate - a.start) * a.rate
        out[:] = [np.interp(at, np.arange(a.values.shape[1]), row, np.nan, np.nan) for row in a.values]  # (3)
        notes.append(FileNote("resampled", "analog", a.names, {"rate_hz": a.rate, "stored_rate_hz": rate}))
    if (beyond := seconds_beyond(a.start, a.values.shape[1] / a.rate, n / rate)) * a.rate > 1 - SAME_TIME:
        notes.append(FileNote("cut", "analog", a.names, {"seconds": beyond}))
    return out, notes


def _put(out: Floats, values: Floats, first: int) -> None:
    """Columns of values into those of `out` from `first` on, as far as they are there."""
    n = out.shape[1]
    low, high = (min(max(at, 0), n) for at in (first, first + values.shape[1]))
    out[:, low:high] = values[:, low - first : high - first]


def seconds_beyond(start: float, length: float, whole: float) -> float:
    """How much of a recording from `start`, `length` long, lies outside of 0 to `whole`, s."""
    return min(length, max(0.0, -start)) + min(length, max(0.0, start + length - whole))
