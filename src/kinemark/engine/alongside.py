"""What was recorded beside the images, as far as a C3D file can hold it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..data import Analog, Trajectories, Trial


def _whole(ratio: float) -> bool:
    """Whether a ratio of rates is a whole number."""
    return abs(ratio - round(ratio)) < 1e-6 and round(ratio) >= 1


def alongside(analog: Sequence[Analog], rate: float, n_frames: int) -> tuple[Analog, ...]:
    """Channels as a C3D file can hold them: one record, as many samples to every frame, from the first to the last.

    Channels whose rate is no multiple of the frame rate, or that start later, are left out; they stay in their own
    file. What was recorded beyond the last frame is cut, and what is missing before it is NaN.
    """
    fitting = [a for a in analog if a.start == 0 and _whole(a.rate / rate)]
    if not fitting:
        return ()
    fastest = max(a.rate for a in fitting)
    samples = round(fastest / rate) * n_frames
    rows = []
    for a in fitting:
        held = np.repeat(a.values, round(fastest / a.rate), axis=1)[:, :samples] if _whole(fastest / a.rate) else None
        if held is not None:
            rows.append((a, np.pad(held, ((0, 0), (0, samples - held.shape[1])), constant_values=np.nan)))
    names = tuple(name for a, _ in rows for name in a.names)
    units = tuple(unit for a, _ in rows for unit in a.units)
    return (Analog(names, units, fastest, np.concatenate([values for _, values in rows])),)


def together(beside: Trial, trajectories: Trajectories) -> Trial:
    """The trajectories with what was recorded beside them, as far as a C3D file can hold it."""
    analog = alongside(beside.analog, trajectories.rate, trajectories.n_frames)
    kept = {name for a in analog for name in a.names}
    plates = tuple(plate for plate in beside.plates if set(plate.channels) <= kept)
    return replace(beside, trajectories=trajectories, analog=analog, plates=plates)
