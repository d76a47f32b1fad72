"""What is found of the EMG of a walk: none, envelopes, cut off, hum, noise alone, muscles whose side nobody says."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from ..data import Finding, make_finding
from ..data.gait_curves import GaitCurves
from ..gait.emg import MAINS_HZ, Emg
from ..gait.gait_cycles import muscle_sides
from .plain import quantile

SCALE = 1.0, 1000.0
"""Greatest value of an envelope, % of the greatest contraction, beyond which one of both has another unit or gain;
chosen: muscles of patients reach up to 300, one that hardly works 5."""


def of_contractions(curves: Sequence[GaitCurves]) -> Iterator[Finding]:
    """Of channels whose envelopes cannot be on the scale of their greatest contractions."""
    peaks = {one.name: quantile(one.values[..., 0], 1.0) for one in curves if one.unit == "%"}
    if far := [name for name, peak in peaks.items() if not SCALE[0] <= peak <= SCALE[1] and np.isfinite(peak)]:
        yield make_finding("emg_scale_doubtful", channels_list=far, peak_share=peaks[far[0]] / 100.0)


def of_muscles(trial: str, channels: Mapping[str, Emg], left_out: Mapping[str, str]) -> Iterator[Finding]:
    """Of the channels of one trial, by name; and why others cannot be read as EMG."""
    if left_out:
        why = next(iter(left_out.values()))
        yield make_finding("emg_left_out", trial=trial, channels_list=list(left_out), why=why)
    if smooth := [name for name, one in channels.items() if one.smoothed]:
        yield make_finding("emg_smoothed", trial=trial, channels_list=smooth)
    if cut := [name for name, one in channels.items() if one.saturated]:
        most = max(channels[name].saturated for name in cut)
        yield make_finding("emg_saturated", trial=trial, channels_list=cut, samples_share=most)
    mains = max(MAINS_HZ, key=lambda hz: sum(one.hum_hz == hz for one in channels.values()))  # a place has one
    if loud := [name for name, one in channels.items() if one.hum_hz == mains]:
        yield make_finding("emg_hums", trial=trial, channels_list=loud, mains=mains)
    if flat := [name for name, one in channels.items() if not one.bursts]:
        yield make_finding("emg_without_bursts", trial=trial, channels_list=flat)
    if aside := [name for name, side in muscle_sides(channels).items() if side is None]:
        yield make_finding("emg_without_side", trial=trial, channels_list=aside)
