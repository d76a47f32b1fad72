"""Tracking by extrapolation (KISS 4.3).

From each track's last points the next one is predicted by the ladder of `signal.extrapolation`. Among the points of the
next frame that lie in a search region about the prediction, the track takes one, by the assignment that is cheapest for
all tracks together. Points that no track takes start tracks of their own.

KISS searches a sphere. Here the region follows from the rate 1/T and from the covariances: after n missed frames a
prediction is off by the acceleration a that the fit does not know, and the points scatter,

    s = a ((n + 1) T)² / 2 + scatter                                     (1)
    S = C_point + C_last Σ w² + s² I                                     (2)
    |x − x̂|²_S = (x − x̂)ᵀ S⁻¹ (x − x̂) ≤ gate²                           (3)

with the weights w of the extrapolation. Where good views make a point sure to the millimetre, (3) is a sphere of radius
gate · s; where two cameras look along nearly the same line, it is long in that direction. A single point, of which
no motion is known, may move v T a frame: s = (n + 1) v T / gate.

KISS ends a track at its first miss and afterwards blends tracks that end and start within two fields. Here a track that
finds no point coasts on its own prediction for as long (`max_coasting`), which comes to the same without a second pass.

One image is one marker: a point that shares an image with a point of an older track is a ghost of it and starts
nothing. At the end short tracks, most of them ghosts, lose their identity.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..data import Cloud, Tracks
from ..data.array_types import Floats, Ints
from ..data.method import Method, parameter
from ..data.progress import tell
from ..numerics.small_matrices import solve3
from ..signal import PAST, assign, extrapolate, gain
from .stage import CLOUD, TRACK


@dataclass(frozen=True, slots=True)
class ExtrapolationLadder(Method):
    """Extrapolation by polynomials of rising order, and the nearest point within what their errors allow."""

    gate: float = parameter(
        5.0,
        former="reach",
        unit="standard deviations",
        above=0,
        meaning="half size of the search region (gate); of (3)",
    )
    max_speed: float = parameter(
        5000.0,
        former="speed",
        unit="mm/s",
        above=0,
        meaning="greatest speed of a marker of which one point is known; v",
    )
    acceleration_sd: float = parameter(
        10_000.0,
        former="acceleration",
        unit="mm/s²",
        low=0,
        meaning="standard deviation of the acceleration that the fit does not predict; a of (1)",
    )
    scatter: float = parameter(
        3.0, unit="mm", above=0, meaning="scatter of the points about their paths beyond their covariance; of (1)"
    )
    max_coasting: float = parameter(
        0.04, former="patience", unit="s", low=0, high=60,
        meaning="coasting: how long a track without points goes on; KISS's two fields of 50 Hz are 0.04 s",
    )  # fmt: skip
    min_points: int = parameter(
        10, former="shortest", unit="points", low=1, meaning="tracks of fewer points than this lose their identity"
    )


@dataclass(frozen=True, slots=True)
class ActiveLadderTrack:
    """Tracks that may still grow.

    Attributes:
        id: (T) identity; known: (T) points so far; missed: (T) frames since the last.
        past: (T, 5, 3) last positions, predictions among them, mm; cov: (T, 3, 3) of the last point, mm².
    """

    id: Ints
    known: Ints
    missed: Ints
    past: Floats
    cov: Floats


@TRACK.method("extrapolation_ladder", ExtrapolationLadder, source="Shafiq, Tümer and Güler 2001, 4.3", takes=CLOUD)
def track_ladder(cloud: Cloud, *, method: ExtrapolationLadder) -> Tracks:
    """The cloud with identities, numbered in the order in which the tracks begin."""
    identity = np.full(len(cloud), -1)
    active = _no_tracks()
    max_missed = round(method.max_coasting * cloud.rate)
    n_tracks = 0
    for f in range(cloud.n_frames):
        tell(f, cloud.n_frames)
        rows = cloud.rows(f)
        points, cov, detection = cloud.xyz[rows], cloud.cov[rows], cloud.detection[rows]
        predicted = extrapolate(active.past, active.known)
        which, taken = _associate(active, predicted, points, cov, detection, cloud.rate, method)
        fresh = _unassociated(detection, taken)
        identity[rows][taken] = active.id[which]
        identity[rows][fresh] = np.arange(n_tracks, n_tracks + len(fresh))
        n_tracks += len(fresh)
        grown = _advance(active, predicted, points, cov, which, taken, max_missed)
        active = _initiate(grown, identity[rows][fresh], points[fresh], cov[fresh])
    return Tracks(cloud, _without_short(identity, method.min_points))


def _no_tracks() -> ActiveLadderTrack:
    """No tracks."""
    zero = np.zeros(0, np.int64)
    return ActiveLadderTrack(zero, zero, zero, np.zeros((0, PAST, 3)), np.zeros((0, 3, 3)))


def _associate(
    active: ActiveLadderTrack,
    predicted: Floats,
    points: Floats,
    cov: Floats,
    detection: Ints,
    rate: float,
    method: ExtrapolationLadder,
) -> tuple[Ints, Ints]:
    """Which tracks take which points; of two that share an image, the younger track goes without."""
    sd = method.acceleration_sd * ((active.missed + 1) / rate) ** 2 / 2 + method.scatter  # (1)
    sd = np.where(active.known > 1, sd, method.max_speed * (active.missed + 1) / rate / method.gate)
    own = active.cov * gain(active.known)[:, None, None] + np.eye(3) * sd[:, None, None] ** 2
    off = points - predicted[:, None]
    squared = (off * solve3(own[:, None] + cov, off)).sum(-1)  # (3)
    which, taken = assign(squared, np.full(len(active.id), method.gate**2))
    oldest = np.argsort(-active.known[which], kind="stable")
    which, taken = which[oldest], taken[oldest]
    alone = _first_users(detection[taken])
    return which[alone], taken[alone]


def _first_users(detection: Ints) -> NDArray[np.bool_]:
    """Which points (n) of detections (n, C) use no image that an earlier one uses."""
    used: set[int] = set()
    alone = np.zeros(len(detection), bool)
    for k, images in enumerate(detection.tolist()):
        own = {image for image in images if image >= 0}
        alone[k] = used.isdisjoint(own)
        if alone[k]:
            used |= own
    return alone


def _unassociated(detection: Ints, taken: Ints) -> Ints:
    """Points that may start tracks: those without an image of a point that is taken."""
    images = detection[taken]
    shared = np.isin(detection, images[images >= 0]).any(1)
    return np.flatnonzero(~shared)


def _advance(
    active: ActiveLadderTrack, predicted: Floats, points: Floats, cov: Floats, which: Ints, taken: Ints, max_missed: int
) -> ActiveLadderTrack:
    """The tracks one frame on: with the point taken or, for at most `max_missed` frames, with the prediction."""
    here, known, missed, last = predicted.copy(), active.known.copy(), active.missed + 1, active.cov.copy()
    here[which], last[which] = points[taken], cov[taken]
    known[which] += 1
    missed[which] = 0
    past = np.concatenate([active.past[:, 1:], here[:, None]], 1)
    alive = missed <= max_missed
    return ActiveLadderTrack(active.id[alive], known[alive], missed[alive], past[alive], last[alive])


def _initiate(active: ActiveLadderTrack, identity: Ints, points: Floats, cov: Floats) -> ActiveLadderTrack:
    """The active tracks and new ones of a single point each."""
    n = len(points)
    return ActiveLadderTrack(
        np.concatenate([active.id, identity]),
        np.concatenate([active.known, np.ones(n, np.int64)]),
        np.concatenate([active.missed, np.zeros(n, np.int64)]),
        np.concatenate([active.past, np.repeat(points[:, None], PAST, 1)]),
        np.concatenate([active.cov, cov]),
    )


def _without_short(identity: Ints, least: int) -> Ints:
    """Identities renumbered without tracks of fewer than `least` points; −1 stays."""
    lengths = np.bincount(identity[identity >= 0], minlength=1)
    long = lengths >= least
    number = np.where(long, np.cumsum(long) - 1, -1)
    return np.where(identity >= 0, number[identity], -1)
