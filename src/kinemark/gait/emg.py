"""EMG: filtered, rectified, its envelope, when a muscle is on, and whether the recording can be trusted.

    raw → band-pass (Butterworth, forwards and backwards) → |·| → low-pass → envelope                          (1)

A muscle is on where a faster envelope exceeds its mean at rest m by `on_sd` standard deviations, and a share of its
peak, bridged and kept by a least duration (Hodges and Bui 1996; De Luca 1997 for the bands). Rest is not known
beforehand. At rest the envelope of noise has the standard deviation c m, and its quietest tenth is q on average:

    q = m (1 − 1.755 c)     on above m (1 + on_sd c)                                                           (2)

with 1.755 of the normal distribution. The deviation of that tenth itself is far below c m, as its values are chosen.
Where the faster envelope hardly differs from its mean, and never falls far below it, the channel shows no bursts, and
nothing says when its muscle is on, nor where most samples are cut off (3). A channel that sits at its greatest or
least value is saturated; one with more power at the mains' frequency than in the bands beside it hums, and what is
heard there and at its multiples is taken out before (1), as the hum would count as rest (4). A channel that is never
below zero and slow was rectified and smoothed before it was recorded: it is an envelope as it is, in place of (1) (5).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import scipy

from ..data import KinemarkError
from ..data.array_types import Bools, Floats
from ..data.arrays import check_positive
from ..numerics.runs import true_runs

MAINS_HZ = (50.0, 60.0)
"""Of power lines, Hz; by definition."""
HUM_TIMES = 10.0
"""Power at the mains' frequency over that beside it from which a channel hums; chosen: EMG's spectrum is smooth within
a factor of three."""
HUM_S = 1.0
"""Over which the mains' wave changes as a parabola does; chosen: power lines keep their frequency to 0.2 Hz."""
BELOW_ZERO = 0.05
"""Of its peak, by which an envelope is below zero beside a burst, at the most; chosen: 0.02 of a smoothing at 3 Hz."""
SLOW = 0.1
"""Share of an envelope's variance above `low_hz`, at the most; chosen: 0.06 of noise smoothed at 20 Hz, 0.24 and more
of what was rectified alone."""
STEEP = 0.8
"""Share of this that is above twice `low_hz`, at the most; chosen: 0.65 of envelopes, and 0.92 of EMG at 1000 Hz that
drifts far above zero."""
DEAD_S = 0.1
"""Of one value in a channel, above which nothing was recorded there, s; chosen: noise never keeps it."""
CHANGES = 0.8
"""Share of the samples beside such a stretch that differ from the one before; chosen: noise below the steps in which a
channel was stored keeps its values on and off, and is rest. Of 237 channels in steps of half to eight times their noise
at rest, rest of one seemed a failure at most; where ends always counted, that of 81 at their ends."""
CUT_OFF = 0.5
"""Share of samples at the limits from which on the others tell nothing; chosen: an electrode is loose."""
STUCK = 3
"""Samples one after the other at the greatest or least value that noise does not make; chosen."""
SHARPER = 4.0
"""By which the envelope that says on and off is faster; chosen: at 6 Hz a burst seems 60 ms longer than it is."""
QUIET_SHARE = 0.1
"""Of the envelope that counts as rest; chosen: muscles of walking rest longer."""
REST_VARIES = 0.24
"""c of (2); chosen: bursts of known time added to 20 real channels of noise, 4 times as strong as it, are found in 95 %
of their time, and in 5 % of the rest; with the deviation of the quietest tenth it was 84 % of the rest. Of 15 other
channels 87 % and 1 %. White noise has 0.15."""
TENTH = 1.755
"""Standard deviations by which the least tenth of normal values is below their mean; by definition."""
LEAST_OF_PEAK = 0.1
"""Share of the peak that an active muscle exceeds; chosen."""
NOISE_VARIES = 0.5
"""Standard deviation of the faster envelope over its mean, below which it may be noise alone; chosen: 0.15 of white
noise, 0.27 to 0.41 of 25 channels that no muscle was on, 0.58 and more of 20 muscles of walkers."""
NOISE_RESTS = 0.3
"""Mean of its quietest tenth over its mean, above which it may be noise alone; chosen: 0.33 and more of channels
that no muscle was on. A muscle that works for most of the stride, and rests, is below: 0.08 to 0.11 of two."""


@dataclass(frozen=True, slots=True)
class EmgFilter:
    """How (1) and (2) are done: Hz, Hz, Hz, standard deviations, s."""

    low_hz: float = 20.0
    high_hz: float = 450.0
    envelope_hz: float = 6.0
    on_sd: float = 3.0
    shortest_s: float = 0.05

    def __post_init__(self) -> None:
        check_positive(low_hz=self.low_hz, envelope_hz=self.envelope_hz, shortest_s=self.shortest_s)
        if not self.low_hz < self.high_hz:
            raise ValueError(f"the band goes from {self.low_hz} to {self.high_hz} Hz, wanted the lower first")


class Emg(NamedTuple):
    """One channel of N samples.

    Attributes:
        filtered: (N) band-passed, or as it is (5); envelope: (N), both in the unit of the channel, NaN where nothing
            was recorded.
        on: (N) whether the muscle is active; nowhere where there are no bursts.
        bursts: whether it shows more than noise (3).
        saturated: share of samples at the channel's limits.
        hum_hz: 50 or 60 where the mains are heard, else 0. smoothed: whether it was recorded as an envelope (5).
        rate: samples a second, Hz. start: of the first after the first frame, s.
    """

    filtered: Floats
    envelope: Floats
    on: Bools
    bursts: bool
    saturated: float
    hum_hz: float
    smoothed: bool
    rate: float
    start: float


def emg(values: Floats, *, rate: float, start: float = 0.0, how: EmgFilter | None = None) -> Emg:
    """One channel by (1) to (5); (N) samples at `rate` Hz, the first `start` s after the first frame.

    Raises:
        KinemarkError: the rate is too low for the band, the channel too short, or nothing of it is known.
    """
    how = EmgFilter() if how is None else how
    known = np.isfinite(values)
    live = known & _received(values, rate)
    if live.sum() < rate / how.envelope_hz:
        raise KinemarkError(f"{live.sum()} samples are too few for an envelope. Give longer recordings.")
    x = np.interp(np.arange(len(values)), np.flatnonzero(live), values[live])
    smoothed = _is_envelope(x, rate, how)
    if not smoothed and rate < 4 * how.low_hz:
        raise KinemarkError(f"EMG at {rate:g} Hz holds nothing above {rate / 2:g} Hz. Record it at 1000 Hz or more.")
    hum = 0.0 if smoothed else _hum(x, rate)
    filtered, envelope, sharp = (x, *2 * [np.maximum(x, 0.0)]) if smoothed else _enveloped(x, rate, hum, how)
    saturated = _saturated(values[known])
    bursts = saturated < CUT_OFF and _bursts(sharp[live])
    on = _on(np.where(live, sharp, np.nan), rate, how) if bursts else np.zeros(len(x), bool)
    filtered, envelope = (np.where(live, y, np.nan) for y in (filtered, envelope))
    return Emg(filtered, envelope, on, bursts, saturated, hum, smoothed, rate, start)


def _received(values: Floats, rate: float) -> Bools:
    """(N) without stretches in which nothing changes, as before a device sends and where its radio fails: no rest.

    The samples beside a stretch must change. Within a channel it may not be at a limit, where it is saturated.
    """
    live, long = np.ones(len(values), bool), int(DEAD_S * rate)
    changes = np.diff(values) != 0
    for first, stop in true_runs(~changes) if changes.any() else ():
        beside = [side for side in (changes[max(first - long, 0) : first], changes[stop : stop + long]) if len(side)]
        at_end = len(beside) < 2
        abrupt = min(side.mean() for side in beside) >= CHANGES
        if stop + 1 - first > long and abrupt and (at_end or not _at_limit(values, first)):
            live[first : stop + 1] = False
    return live


def _at_limit(values: Floats, place: int) -> bool:
    """Whether a sample is a channel's greatest or least."""
    return bool(values[place] in (np.nanmin(values), np.nanmax(values)))


def _enveloped(x: Floats, rate: float, hum_hz: float, how: EmgFilter) -> tuple[Floats, Floats, Floats]:
    """(1): filtered, its envelope, and the faster one, (N) each."""
    clean = _without_hum(x - x.mean(), rate, hum_hz) if hum_hz else x - x.mean()
    filtered = _band_passed(clean, how.low_hz, min(how.high_hz, 0.45 * rate), rate)
    envelope, sharp = (_low_passed(np.abs(filtered), hz, rate) for hz in (how.envelope_hz, SHARPER * how.envelope_hz))
    return filtered, envelope, sharp


def _is_envelope(x: Floats, rate: float, how: EmgFilter) -> bool:
    """(5)."""
    low, high = np.percentile(x, [1, 99])
    if high <= 0 or low < -BELOW_ZERO * high:
        return False
    if rate < 5 * how.low_hz:  # holds nothing above twice low_hz
        return True
    fast, faster = (np.var(_band_passed(x - x.mean(), hz, 0.45 * rate, rate)) for hz in (how.low_hz, 2 * how.low_hz))
    return bool(fast <= SLOW * np.var(x) and faster <= STEEP * fast)


def _band_passed(x: Floats, low_hz: float, high_hz: float, rate: float) -> Floats:
    """(N) of (1)."""
    band = scipy.signal.butter(4, (low_hz, high_hz), "bandpass", fs=rate, output="sos")
    return np.asarray(scipy.signal.sosfiltfilt(band, x))


def _low_passed(x: Floats, hz: float, rate: float) -> Floats:
    """(N) of (1)."""
    low = scipy.signal.butter(2, min(hz, 0.4 * rate), fs=rate, output="sos")
    return np.maximum(scipy.signal.sosfiltfilt(low, x), 0.0)


def _quietest(known: Floats) -> Floats:
    """The least values of an envelope, without gaps: its rest."""
    return np.sort(known)[: max(2, round(QUIET_SHARE * len(known)))]


def _bursts(known: Floats) -> bool:
    """(3), of an envelope without gaps."""
    mean = known.mean()
    return bool(known.std() >= NOISE_VARIES * mean or _quietest(known).mean() <= NOISE_RESTS * mean)


def _on(envelope: Floats, rate: float, how: EmgFilter) -> Bools:
    """(2)."""
    known = envelope[np.isfinite(envelope)]
    rest = _quietest(known).mean() / (1 - TENTH * REST_VARIES)
    level = max(rest * (1 + how.on_sd * REST_VARIES), LEAST_OF_PEAK * np.percentile(known, 99))
    on = np.nan_to_num(envelope) > level
    least = how.shortest_s * rate
    for first, stop in true_runs(~on):
        if first > 0 and stop < len(on) and stop - first < least:
            on[first:stop] = True
    for first, stop in true_runs(on):
        if stop - first < least:
            on[first:stop] = False
    return on


def _saturated(x: Floats) -> float:
    """Share of samples that stay at the limits for `STUCK` samples or more."""
    if np.ptp(x) == 0:
        return 1.0
    at_limit = [run for limit in (x.max(), x.min()) for run in true_runs(x == limit)]
    stuck = sum(int(stop - first) for first, stop in at_limit if stop - first >= STUCK)
    return stuck / len(x)


def _hum(x: Floats, rate: float) -> float:
    """The mains' frequency that is heard (4), else 0."""
    return next((mains for mains in MAINS_HZ if _heard(x, rate, mains)), 0.0)


def _heard(x: Floats, rate: float, at_hz: float) -> bool:
    """Whether there is more power at a frequency than beside it."""
    hz, power = scipy.signal.welch(x, fs=rate, nperseg=min(len(x), int(2 * rate)))
    at = np.abs(hz - at_hz) <= 1.0
    beside = (np.abs(hz - at_hz) > 3.0) & (np.abs(hz - at_hz) <= 10.0)
    return bool(at.any() and beside.any() and power[at].max() > HUM_TIMES * np.median(power[beside]))


def _without_hum(x: Floats, rate: float, mains_hz: float) -> Floats:
    """(N) without what is heard of the mains, at their frequency and its multiples.

    Each is a wave whose strength and phase change slowly, which needs no samples beyond the ends, as a filter would.
    """
    window = min(int(HUM_S * rate), len(x) - 1) // 2 * 2 + 1
    for hz in np.arange(mains_hz, 0.45 * rate, mains_hz):
        if _heard(x, rate, hz):
            turn = np.exp(2j * np.pi * hz / rate * np.arange(len(x)))
            seen = x * turn.conj()
            wave = [scipy.signal.savgol_filter(part, window, 2) for part in (seen.real, seen.imag)]
            x = x - 2 * (wave[0] * turn.real - wave[1] * turn.imag)
    return x


def peak_of(envelope: Floats) -> float:
    """Greatest value of an envelope (N); 0 where it has none."""
    return float(np.nanmax(envelope, initial=0.0))


def normalised(envelope: Floats, whole: float) -> Floats:
    """(N) % of a value that is above 0; else NaN."""
    return 100 * envelope / whole if whole > 0 else np.full_like(envelope, np.nan)
