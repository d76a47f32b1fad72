"""How fast the markers of a recording move, learned from parts of it.

Tracks are made in WINDOWS short windows. Of four points of a track a time h apart, of covariances V, the third
difference of a marker whose acceleration changes by white noise q has in each axis the variance

    d = x₃ − 3 x₂ + 3 x₁ − x₀,   var d = 11/20 q² h⁵ + (V₃ + 9 V₂ + 9 V₁ + V₀)           (1)

as 11/20 is the integral of the squared quadratic B-spline. The process noise is the q that explains the share INNER of
all d, |d|² being χ² with three degrees of freedom in units of (1) (2). The standard deviation of velocities is that of
which the 99th percentile of speeds is USUAL_REACH (3). That of accelerations, a, by which new tracks begin, explains
the same share of second differences as (2) does of third ones,

    b = x₂ − 2 x₁ + x₀,   var b = a² h⁴ + (V₂ + 4 V₁ + V₀)                               (4)

These only ever raise them: a part may be quieter than the whole. What was not followed the first time may be followed
then, so this is done up to ROUNDS times; and as runners whom no new track keeps up with leave no track at all, windows
are also tracked as if all were runners, which counts where tracks then have GAIN times as many images (5).

Where few frames are taken a second, what markers usually may do reaches beyond their neighbours, and tracks begin and
go on with images of several. So where frames are farther apart than LOW windows are also tracked with half of the
process noise and of a, and again with a quarter, which counts where tracks then have FEWER_WRONG times as many images
(8).

Where few frames are taken a second of something that moves evenly, as a plate that is carried about at 10 Hz, the
usual process noise reaches beyond the neighbours, and tracks break. Of tracks of L frames the length

    Σ L² / Σ L                                                                           (6)

is that of the track on which a point is on average. Where it is less than FOLLOWED of a window, windows are also
tracked as if all moved evenly, which counts, in place of (8), where (6) grows by LONGER. Then, and where tracks break
by (8) too, they are tracked as if images were noisier by NOISIER, which counts where tracks have GAIN times as many
images (7): a calibration that fits in the middle and not at the sides, or cameras out of step, make images noisy in a
part of the recording, of which the noise of the whole says nothing.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ....data.array_types import Floats, Ints
from ..detection_index import Images
from ..points.neighbouring_points import TrackPoints, rows_of
from ..simultaneous_method import Simultaneous
from .candidate_points import intersect
from .passes import Associations, Run
from .room_scale import room_scale, scaled

WINDOWS, MIN_WINDOW, WINDOW = 4, 24, 0.24
"""Windows, frames of each at least, and s of each at least; chosen: they are gone through side by side, which takes the
time of one."""

SPACING = 0.04
"""h of (1), s, and one frame at least: short beside a movement, and long enough that noise does not hide it; chosen
(see benchmarks/tracking_scenes.py)."""

INNER, INNER_CHI2 = 0.97, 8.947
"""Share of (2) and (4), and the quantile of χ² with three degrees of freedom; chosen (see
benchmarks/tracking_scenes.py)."""

USUAL_REACH = 2.5
"""Of (3): new tracks are looked for within three standard deviations; chosen (see benchmarks/tracking_scenes.py)."""


class Movement(NamedTuple):
    """Process noise in mm/s² per √s by (2), standard deviations of velocities in mm/s by (3) and of accelerations in
    mm/s² by (4)."""

    process_noise: float
    velocity_sd: float
    acceleration_sd: float


NO_MOVEMENT = Movement(0.0, 0.0, 0.0)
"""What too few points tell, mm/s² per √s, mm/s and mm/s²; by definition."""

MOST_MOVEMENT = Movement(400_000.0, 6000.0, 120_000.0)
"""mm/s² per √s, mm/s and mm/s²: about what the feet of a sprinter have; chosen (see benchmarks/tracking_scenes.py)."""

RUNNING, GAIN = Movement(150_000.0, 4000.0, 30_000.0), 1.05
"""mm/s² per √s, mm/s and mm/s² of runners, and the number of (5); chosen (see benchmarks/tracking_scenes.py)."""

MOST = 0.75
"""Share of the images in tracks from which on nobody runs unseen; chosen: the others are false or one camera's."""

MIN_POINTS, ROOM = 30, 400
"""Third differences from which something can be said, and those for which windows have room; chosen: a single marker
tells how it moves although it is hidden at times. With 100 differences, five of twelve fast ones had fewer than half of
their samples in 60 frames; with 30 the worst had 82 %."""

ROUNDS = 3
"""Times that parts are tracked; chosen (see benchmarks/tracking_scenes.py)."""


LOW, HALVINGS, FEWER_WRONG = 0.03, 2, 1.003
"""s from frame to frame, the number of times and that of (8); chosen on 20 scenes at 25 Hz (970000 to 970159 of
benchmarks/tracking_scenes.py). A third halving changes nothing in 27 others. At 50 Hz fingers are exchanged either way:
of six grids of 30 markers two have fewer swaps, and four more."""

FOLLOWED, LONGER = 0.7, 1.2
"""Of the length of a window, and of (6); chosen (see studies/infrared_footage.py): of seeds 0 to 19 of
benchmarks/tracking_scenes.py none has less than 0.77 of a window, and the infrared footage 0.55."""

EVENLY = Movement(4000.0, 400.0, 3000.0)
"""mm/s² per √s, mm/s and mm/s² of what moves evenly: a tenth and less of walking; chosen (see
studies/infrared_footage.py)."""

NOISIER = 1.0
"""px by which images may be noisier than learned; chosen (see studies/infrared_footage.py)."""


class Learned(NamedTuple):
    """The images, noisier where that is so; the method with the motion of the recording; whether (7) changed either, as
    tracks broke; the `room_scale` by which the method's lengths count."""

    images: Images
    method: Simultaneous
    broke: bool = False
    scale: float = 1.0


class _InWindows(NamedTuple):
    """A method, and the tracks that it makes in windows."""

    method: Simultaneous
    seen: Associations


def with_learned_motion(images: Images, rate: float, method: Simultaneous, seen: Associations | None = None) -> Learned:
    """The method with more process noise, velocity and acceleration, or less where tracks break or the room is small.

    Args:
        seen: `in_windows` of these, where it is known.
    """
    if not method.learn_motion:
        return Learned(images, method)
    seen = in_windows(images, rate, method) if seen is None else seen
    if (scale := room_scale(images, seen)) < 1:
        method = scaled(method, scale)
        seen = in_windows(images, rate, method)
    return _of_movement(images, rate, method, seen)._replace(scale=scale)


def _of_movement(images: Images, rate: float, method: Simultaneous, seen: Associations) -> Learned:
    """The method with what moves as tracks `seen` in windows do."""
    if _share(images, seen) < MOST:
        running = in_windows(images, rate, _raised(method, RUNNING))
        seen = running if count_images(running) > GAIN * count_images(seen) else seen  # (5)
    for _ in range(ROUNDS):
        faster = _raised(method, movement(images, seen, rate))
        if faster == method:
            break
        method = faster
        seen = in_windows(images, rate, method)
    broken = FOLLOWED * _window_length(images, rate)
    even = _moving_evenly(images, rate, method, seen) if _track_length(seen) < broken else None
    method, seen = even or _with_less(images, rate, method, seen)
    if not even and _track_length(seen) >= broken:
        return Learned(images, method)
    noisier = images.noisier(np.full(len(images.P), NOISIER**2))
    more = count_images(in_windows(noisier, rate, method)) > GAIN * count_images(seen)
    return Learned(noisier if more else images, method, broke=more or even is not None)


def _moving_evenly(images: Images, rate: float, method: Simultaneous, seen: Associations) -> _InWindows | None:
    """The method for what moves evenly, where it keeps tracks whole that break in windows `seen`, by (7)."""
    even = replace(method, **{name: min(least, getattr(method, name)) for name, least in EVENLY._asdict().items()})
    tried = in_windows(images, rate, even)
    return _InWindows(even, tried) if _track_length(tried) > LONGER * _track_length(seen) else None


def _with_less(images: Images, rate: float, method: Simultaneous, seen: Associations) -> _InWindows:
    """The method, by which windows were `seen`, with less process noise and acceleration by (8)."""
    for _ in range(HALVINGS if 1 / rate > LOW else 0):
        halves = {name: getattr(method, name) / 2 for name in ("process_noise", "acceleration_sd")}
        less = replace(method, **halves)
        tried = in_windows(images, rate, less)
        if count_images(tried) <= FEWER_WRONG * count_images(seen):
            break
        method, seen = less, tried
    return _InWindows(method, seen)


def count_images(seen: Associations) -> int:
    """Images that tracks have."""
    return int((seen.detection >= 0).sum())


def _track_length(seen: Associations) -> float:
    """(6), frames."""
    length = np.bincount(seen.id).astype(float)
    return float((length**2).sum() / max(length.sum(), 1.0))


def _share(images: Images, seen: Associations) -> float:
    """Share of the usable images of the frames that were looked at that tracks have."""
    looked_at = images.usable & np.isin(images.frame, seen.frame)
    return len(np.unique(seen.detection[seen.detection >= 0])) / max(int(looked_at.sum()), 1)


def _raised(method: Simultaneous, to: Movement) -> Simultaneous:
    """The method with so much movement, where it has less."""
    most = MOST_MOVEMENT._asdict()
    return replace(
        method, **{name: max(getattr(method, name), min(much, most[name])) for name, much in to._asdict().items()}
    )


def in_windows(images: Images, rate: float, method: Simultaneous) -> Associations:
    """Tracks in short windows all over the recording, forwards only."""
    n = images.n_frames
    length = _window_length(images, rate)
    count = int(np.clip(n // max(length, 1), 1, WINDOWS))
    first = np.linspace(0, n - length, count).astype(int)
    return Run(images, rate, method).forwards(first, length)


def _window_length(images: Images, rate: float) -> int:
    """Frames of a window: more where there are so few markers that windows would tell nothing of their motion."""
    n, usual = images.n_frames, max(MIN_WINDOW, round(WINDOW * rate))
    markers = np.bincount(images.camera[images.usable]).max(initial=1) / max(n, 1)
    room = 3 * _spacing(rate) + int(np.ceil(ROOM / (WINDOWS * markers)))
    if room <= usual:
        return min(usual, n)
    return room if WINDOWS * room <= n else n


def _spacing(rate: float) -> int:
    """Frames of SPACING."""
    return max(round(SPACING * rate), 1)


def movement(images: Images, seen: Associations, rate: float) -> Movement:
    """How the tracks move, 0 where there are too few points."""
    points = _points(images, seen)
    if not len(points.id):
        return NO_MOVEMENT
    rows, k = rows_of(points), _spacing(rate)
    if rows.shape[1] <= 3 * k:  # a recording of so few frames
        return NO_MOVEMENT
    four = np.array([rows[:, i * k : rows.shape[1] - (3 - i) * k] for i in range(4)])
    four = four[:, (four >= 0).all(0)]
    if four.shape[1] < MIN_POINTS:
        return NO_MOVEMENT
    h = k / rate
    x, V = points.xyz[four], np.trace(points.cov[four], axis1=-2, axis2=-1)
    jerk, bend = x[3] - 3 * x[2] + 3 * x[1] - x[0], x[2] - 2 * x[1] + x[0]
    q = _deviation(jerk, V[3] + 9 * V[2] + 9 * V[1] + V[0], 11 / 20 * h**5)  # (1), (2)
    a = _deviation(bend, V[2] + 4 * V[1] + V[0], h**4)  # (4)
    speed = np.linalg.norm(np.diff(x, axis=0), axis=-1) / h
    return Movement(q, float(np.percentile(speed, 99)) / USUAL_REACH, a)  # (3)


def _deviation(difference: Floats, noise: Floats, scale: float) -> float:
    """What explains the share INNER of differences (N, 3) mm: its square times `scale` is their variance in each axis,
    beside noise of the variance (N) mm² in all three axes together."""
    squared = ((difference**2).sum(-1) / INNER_CHI2 - noise / 3) / scale
    return float(np.sqrt(max(np.quantile(squared, INNER), 0.0)))


def _points(images: Images, seen: Associations) -> TrackPoints:
    """The points of the tracks by their images alone, as a filter would smooth what it does not expect."""
    detection: Ints = np.where(seen.shared | images.merged[seen.detection], -1, seen.detection)
    placed = intersect(images, detection)
    cov: Floats = placed.cov.transpose(2, 0, 1)
    good = ((detection >= 0).sum(0) >= 2) & np.isfinite(placed.xyz).all(0) & np.isfinite(cov).all((1, 2))
    return TrackPoints(seen.frame, seen.id, placed.xyz.T, cov).take(good)
