"""A walking person with the fifteen markers of the lower limb set.

The body is a chain of hinges: pelvis, hips (three angles), knees and ankles (one each). In a frame with x forward, y
to the left and z up, the right-handed turns of the left leg's segments are, in terms of the clinical angles,

    thigh = pelvis · Rᵧ(−flexion) · Rₓ(−adduction) · R_z(external rotation)                       (1)
    shank = thigh · Rᵧ(knee flexion),   foot = shank · Rᵧ(−dorsiflexion)                          (2)

and the right leg mirrors them half a stride later. Flexion curves are those of normal gait, read at every 5 % of the
stride and joined by their Fourier series; adduction, obliquity and rotation are first harmonics.

The angles alone say where the four sole points pᵢ (heels and balls of both feet) are relative to the pelvis. The floor
gives the rest. With τ a few mm and weights wᵢ = exp(−zᵢ/τ)/Σⱼ exp(−zⱼ/τ), which pick the points that bear weight,

    pelvis height    h = τ ln Σᵢ exp(−zᵢ/τ) ≥ −min zᵢ                                             (3)
    pelvis velocity  v = −Σᵢ wᵢ ṗᵢ                                                                 (4)

so that no sole point sinks below the floor (3) and what bears weight does not slide (4). The mean of (4) over a stride
is its length, and the asked speed sets how long it lasts. Of the pelvis's path six harmonics are kept, which leaves a
standing foot a few mm to slide and lift, and the pelvis as smooth as a person's.

Sources: Winter 1991, The Biomechanics and Motor Control of Human Gait; Perry 1992, Gait Analysis (curves, rounded);
Kadaba, Ramakrishnan and Wootten 1990, J Orthop Res 8:383 (marker set); Drillis and Contini 1966 (segment lengths).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy
from numpy.typing import ArrayLike, NDArray

from ..data import Angles, Events
from ..data.array_types import Floats
from .body_segments import LINKS, NAMES, BodySegments, WalkingPose, build
from .smooth_noise import smooth_noise
from .subjects import Subject, pairs

HIP = (27, 26, 24, 20, 15, 10, 5, 0, -4, -8, -10, -8, 0, 9, 19, 27, 32, 33, 32, 29.5)
"""deg, flexion at 0, 5, … 95 % of the stride; typical of normal gait, chosen."""
KNEE = (
    4,
    10,
    16,
    17,
    14,
    10,
    7,
    4,
    3,
    4,
    9,
    19,
    34,
    51,
    59,
    60,
    51,
    35,
    18,
    7,
)  # deg, flexion as of `HIP`; typical of normal gait, chosen
ANKLE = (0, -3, -1, 6, 8, 9, 11, 12, 13, 13, 9, -2, -14, -14, -6, 0, 2, 3, 3, 2)
"""Flexion and dorsiflexion, deg, at 0, 5, … 95 % of the stride from foot strike; chosen."""

TILT = 8.0
"""Forward tilt of the pelvis, deg; chosen."""

FOOT_OFF = 0.60
"""Share of the stride at which a foot leaves the floor; chosen."""

FLOOR_SOFTNESS = 4.0
"""τ of (3), mm; chosen."""

HARMONICS = 6  # of the pelvis's path; chosen: gait has hardly any above six
GRID = 512  # instants of a stride; chosen, a power of two


class Stride(NamedTuple):
    """Length of a stride, mean height of the pelvis, and the Fourier series (3, HARMONICS) of its path besides, mm."""

    length: float
    height: float
    series: NDArray[np.complex128]


def walking(
    *,
    duration_s: float = 1.6,
    rate: float = 50.0,
    seed: int = 0,
    speed_mm_s: float = 1100.0,
    height_mm: float = 1730.0,
    wobble_mm: float = 0.0,
    marker_radius_mm: float = 12.5,
    middle: ArrayLike = (1200.0, 700.0),
    phase: float = 0.80,
) -> Subject:
    """A person who walks along +X and passes `middle` (2) mm on the floor half-way through.

    The markers are SACR, LASI, RASI and on each side THI (thigh wand), KNE (lateral epicondyle), TIB (shank wand),
    ANK (lateral malleolus), HEE and TOE (second metatarsal head). `angles` holds hips (flexion, adduction, external
    rotation), knees and ankles (flexion); `events` the foot strikes and foot offs.

    Args:
        duration_s: length of the recording, s.
        rate: frames a second, Hz.
        seed: of the wobble; the walking itself is the same for all seeds.
        speed_mm_s: of the pelvis on average, mm/s.
        height_mm: of the person; all lengths are in proportion.
        wobble_mm: standard deviation of soft tissue artefact, mm per axis; zero leaves segments rigid.
        marker_radius_mm: of the markers.
        middle: (2) x, y on the floor, mm.
        phase: of the left leg's stride in the first frame; at the default both feet are under the body then.

    Raises:
        ValueError: duration, rate, speed or height is not positive.
    """
    if min(duration_s, rate, speed_mm_s, height_mm, marker_radius_mm) <= 0 or wobble_mm < 0:
        raise ValueError("duration_s, rate, speed_mm_s, height_mm and marker_radius_mm must be positive")
    n_frames = max(round(duration_s * rate), 1)
    body = BodySegments.of(height_mm, marker_radius_mm)
    stride = stride_of(body)
    period = stride.length / speed_mm_s
    cycles = phase + np.arange(n_frames) / rate / period
    pose = pose_at(cycles, pelvis_path(stride, cycles, np.asarray(middle, np.float64)))
    markers, capsules = build(body, pose)
    markers = markers + wobble_mm * smooth_noise(markers.shape, rate, seed, cut_hz=6.0)
    angles, events = _angles(cycles, rate), _events(phase, period, n_frames, rate)
    return Subject(
        NAMES, rate, markers, np.array(marker_radius_mm), capsules, pairs(NAMES, *LINKS), angles=angles, events=events
    )


def curve(samples: ArrayLike, cycles: Floats) -> Floats:
    """A periodic curve given by evenly spaced samples of one cycle, by its Fourier series, at `cycles` (F)."""
    values = np.asarray(samples, np.float64)
    series = np.fft.rfft(values) / len(values)
    if len(values) % 2 == 0:
        series[-1] = 0.0  # its sine part is unknown
    return series[0].real + _sum(2 * series[1:], cycles)


def _sum(series: NDArray[np.complex128], cycles: Floats) -> Floats:
    """Σₖ Re(cₖ exp(2πi k cycles)) for k = 1, 2, …; (…, K) and (F) → (…, F)."""
    wave = np.exp(2j * np.pi * np.outer(np.arange(1, series.shape[-1] + 1), cycles))
    summed: Floats = (series @ wave).real
    return summed


def leg_angles(cycles: Floats) -> Floats:
    """(5, F) deg: hip flexion, adduction, external rotation, knee flexion, dorsiflexion at strides of that leg."""
    adduction = 1.0 + 5.5 * np.cos(2 * np.pi * (cycles - 0.20))
    external = 6.0 + 5.0 * np.cos(2 * np.pi * cycles)  # undoes the pelvis, so that the feet point steadily
    return np.stack([curve(HIP, cycles), adduction, external, curve(KNEE, cycles), curve(ANKLE, cycles)])


def pose_at(cycles: Floats, pelvis: Floats) -> WalkingPose:
    """Turns of all segments (1) (2) where the left leg's stride is at `cycles` (F), the pelvis at (F, 3) mm."""
    yaw, up = -5.0 * np.cos(2 * np.pi * cycles), 4.0 * np.cos(2 * np.pi * (cycles - 0.13))
    hips = scipy.spatial.transform.Rotation.from_euler(
        "ZXY", np.stack([yaw, up, np.full_like(cycles, TILT)], -1), degrees=True
    )
    legs = []
    for mirror, late in ((1.0, 0.0), (-1.0, 0.5)):
        flexion, adduction, external, knee, ankle = leg_angles(cycles + late)
        thigh = hips * scipy.spatial.transform.Rotation.from_euler(
            "YXZ", np.stack([-flexion, -mirror * adduction, mirror * external], -1), degrees=True
        )
        shank = thigh * scipy.spatial.transform.Rotation.from_euler("y", knee[:, None], degrees=True)
        foot = shank * scipy.spatial.transform.Rotation.from_euler("y", -ankle[:, None], degrees=True)
        legs.append((thigh.as_matrix(), shank.as_matrix(), foot.as_matrix()))
    swing = 18.0 * np.cos(2 * np.pi * cycles)
    arms = np.stack([-swing, swing])  # each arm goes with the other leg
    return WalkingPose(pelvis, hips.as_matrix(), (legs[0], legs[1]), arms)


def stride_of(body: BodySegments) -> Stride:
    """The stride that makes the weight-bearing foot stand still, (3) and (4)."""
    cycles = np.arange(GRID) / GRID
    return stride_of_soles(body.soles(pose_at(cycles, np.zeros((GRID, 3)))))


def stride_of_soles(points: Floats) -> Stride:
    """The same of sole points (4, GRID, 3) mm over one stride, as the pelvis sees them."""
    cycles = np.arange(GRID) / GRID
    lift = np.exp(-(points[..., 2] - points[..., 2].min()) / FLOOR_SOFTNESS)
    weight = lift / lift.sum(0)
    wave = 2j * np.pi * np.fft.rfftfreq(GRID, 1 / GRID)
    rate = np.fft.irfft(np.fft.rfft(points, axis=1) * wave[:, None], GRID, axis=1)
    velocity = -(weight[..., None] * rate).sum(0)  # (4)  mm per stride
    path: NDArray[np.complex128] = np.fft.rfft(velocity, axis=0)[1 : HARMONICS + 1] / wave[1 : HARMONICS + 1, None]
    height = FLOOR_SOFTNESS * np.log(lift.sum(0)) - points[..., 2].min()  # (3)
    path[:, 2] = np.fft.rfft(height)[1 : HARMONICS + 1]
    series = 2 * path.T / GRID
    lowest = (points[..., 2] + _sum(series[2], cycles)).min()
    return Stride(float(velocity[:, 0].mean()), -float(lowest), series)


def pelvis_path(stride: Stride, cycles: Floats, middle: Floats) -> Floats:
    """(F, 3) mm of the pelvis, which passes above `middle` half-way through."""
    path = _sum(stride.series, cycles).T
    path[:, 0] += stride.length * (cycles - (cycles[0] + cycles[-1]) / 2)
    return path + np.array([*middle, stride.height])


def _angles(cycles: Floats, rate: float) -> Angles:
    """The joint angles as they were put in."""
    joints, deg = [], []
    for side, late in (("left", 0.0), ("right", 0.5)):
        flexion, adduction, external, knee, ankle = leg_angles(cycles + late)
        none = np.zeros_like(knee)
        joints += [f"{side} hip", f"{side} knee", f"{side} ankle"]
        deg += [
            np.stack(three, -1) for three in ((flexion, adduction, external), (knee, none, none), (ankle, none, none))
        ]
    unknown = np.full((6, len(cycles), 3, 3), np.nan)
    return Angles(tuple(joints), ("yxz",) * 6, np.array(deg), unknown, rate)


def _events(phase: float, period: float, n_frames: int, rate: float) -> Events:
    """Foot strikes and foot offs within the recording, in order of time."""
    last = (n_frames - 1) / rate
    found = []
    for side, late in (("Left", 0.0), ("Right", 0.5)):
        for label, when in (("Foot Strike", 0.0), ("Foot Off", FOOT_OFF)):
            first = np.ceil(phase + late - when) + when - phase - late
            found += [(float(t), label, side) for t in np.arange(first * period, last, period)]
    found.sort()
    return Events(tuple(f[1] for f in found), tuple(f[2] for f in found), np.array([f[0] for f in found]))
