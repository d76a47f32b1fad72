"""Three periodic motions of an arm, as three magnetic sensors once recorded them (Swamidas 4.1.3, at 30 Hz).

Markers A at the hand, B at the elbow and C at the shoulder; in the third motion D, close to B on the forearm, takes
A's place. The world's origin is the magnetic transmitter, whose range was three feet, 914 mm: all markers stay in it.

Of the periods the thesis gives two, in its conclusions: "approximately 2.2 seconds" in run 1 and "approximately 1
second" in run 3. Run 2 is "a faster one" than run 1 and run 3 "still faster": its 1.6 s is set between them.

The hand's path is given, and the shoulder's small sway; both limbs keep their lengths u (upper arm) and f (forearm).
With the hand at distance d from the shoulder, along the unit vector a, the elbow hangs below the line at

    B = C + s a + h n,    s = (u² − f² + d²) / 2d,    h = √(u² − s²)                             (1)

where n is the unit vector perpendicular to a that points down most.
"""

from __future__ import annotations

import numpy as np

from ..data.array_types import Floats
from .smooth_noise import smooth_noise
from .subjects import Capsules, Subject, pairs

UPPER, FOREARM, NEAR = 290.0, 260.0, 45.0
"""Shoulder to elbow, elbow to hand, elbow to D, mm; chosen."""

PERIODS_S = (2.2, 1.6, 1.0)
"""Of the three motions; chosen."""

SHOULDER = np.array([250.0, -450.0, 300.0])
"""C at rest, seen from the transmitter, mm; chosen."""


def circle_over_cylinder(
    *,
    duration_s: float = 10.0,
    rate: float = 30.0,
    seed: int = 0,
    period_s: float = PERIODS_S[0],
    radius_mm: float = 120.0,
    unsteady_mm: float = 2.0,
) -> Subject:
    """Run 1: the hand slowly circles over the top of a cylinder; much motion in x and y, little in z.

    Args:
        duration_s: length of the recording, s.
        rate: frames a second, Hz.
        seed: of the unsteadiness.
        period_s: of one circle, s.
        radius_mm: of the circle.
        unsteady_mm: standard deviation of the hand about its path, mm.
    """
    t = _times(duration_s, rate)
    angle = 2 * np.pi * t / period_s
    centre = np.array([300.0, -120.0, 130.0])
    hand = centre + radius_mm * np.stack([np.cos(angle), np.sin(angle), 0.08 * np.sin(2 * angle)], -1)
    return _hand_elbow_shoulder(hand, angle, rate, seed, unsteady_mm)


def tilted_rectangle(
    *,
    duration_s: float = 10.0,
    rate: float = 30.0,
    seed: int = 0,
    period_s: float = PERIODS_S[1],
    sides_mm: tuple[float, float] = (260.0, 180.0),
    unsteady_mm: float = 2.0,
) -> Subject:
    """Run 2: the hand follows an upright rectangle with rounded corners, at 45° in the x-y plane.

    Args:
        duration_s: length of the recording, s.
        rate: frames a second, Hz.
        seed: of the unsteadiness.
        period_s: of one round, s.
        sides_mm: level and upright side, mm.
        unsteady_mm: standard deviation of the hand about its path, mm.
    """
    angle = 2 * np.pi * _times(duration_s, rate) / period_s
    # The superellipse |x|⁴ + |y|⁴ = 1 is a square with round corners; this runs round it evenly enough.
    round_it = np.stack([np.cos(angle), np.sin(angle)]) / (np.cos(angle) ** 4 + np.sin(angle) ** 4) ** 0.25
    level, upright = round_it * np.array(sides_mm)[:, None] / 2
    centre = np.array([290.0, -130.0, 180.0])
    hand = centre + np.stack([level * np.sqrt(0.5), level * np.sqrt(0.5), upright], -1)
    return _hand_elbow_shoulder(hand, angle, rate, seed, unsteady_mm)


def elbow_flexion(
    *,
    duration_s: float = 10.0,
    rate: float = 30.0,
    seed: int = 0,
    period_s: float = PERIODS_S[2],
    unsteady_mm: float = 1.5,
) -> Subject:
    """Run 3: the arm flexes, with markers D, B and C; D and B are so close that their regions of acceptance overlap.

    Args:
        duration_s: length of the recording, s.
        rate: frames a second, Hz.
        seed: of the unsteadiness.
        period_s: of one flexion and extension, s.
        unsteady_mm: standard deviation of the whole arm's drift, mm.
    """
    angle = 2 * np.pi * _times(duration_s, rate) / period_s
    C = SHOULDER + _sway(angle) + unsteady_mm * smooth_noise((3, len(angle)), rate, seed, cut_hz=0.8).T
    forward = np.array([0.35, 0.80, 0.0]) / np.hypot(0.35, 0.80)
    down, side = np.array([0.0, 0.0, -1.0]), np.array([forward[1], -forward[0], 0.0])
    lift = np.radians(35 - 22 * np.cos(angle))[:, None]  # the upper arm
    bend = lift + np.radians(70 - 55 * np.cos(angle))[:, None]  # the forearm
    B = C + UPPER * (np.sin(lift) * forward + np.cos(lift) * down)
    line = np.sin(bend) * (0.94 * forward + 0.34 * side) + np.cos(bend) * down
    line = line / np.linalg.norm(line, axis=-1, keepdims=True)
    return _subject(("D", "B", "C"), np.array([B + NEAR * line, B, C]), rate)


def _times(duration_s: float, rate: float) -> Floats:
    if min(duration_s, rate) <= 0:
        raise ValueError(f"duration_s and rate must be positive, found {duration_s} and {rate}")
    return np.arange(max(round(duration_s * rate), 1)) / rate


def _sway(angle: Floats) -> Floats:
    """(F, 3) the body's rocking in time with the hand, in one plane, mm."""
    return np.outer(np.sin(angle), [8.0, 10.0, 0.0]) + np.outer(np.cos(angle), [0.0, 0.0, 5.0])


def _hand_elbow_shoulder(hand: Floats, angle: Floats, rate: float, seed: int, unsteady_mm: float) -> Subject:
    """A, B, C for a hand's path (F, 3)."""
    A = hand + unsteady_mm * smooth_noise((3, len(hand)), rate, seed, cut_hz=1.5).T
    C = SHOULDER + _sway(angle)
    return _subject(("A", "B", "C"), np.array([A, elbow_between(A, C), C]), rate)


def elbow_between(hand: Floats, shoulder: Floats) -> Floats:
    """(F, 3) the elbow (1) between hand and shoulder.

    Raises:
        ValueError: the hand is out of the arm's reach.
    """
    line = hand - shoulder
    d = np.linalg.norm(line, axis=-1, keepdims=True)
    if not ((d < UPPER + FOREARM) & (d > abs(UPPER - FOREARM))).all():
        raise ValueError(f"the hand is {d.min():.0f} to {d.max():.0f} mm from the shoulder, out of reach")
    a = line / d
    below = np.array([0.0, 0.0, -1.0]) + a[:, 2:] * a
    n = below / np.linalg.norm(below, axis=-1, keepdims=True)
    s = (UPPER**2 - FOREARM**2 + d**2) / (2 * d)
    elbow: Floats = shoulder + s * a + np.sqrt(UPPER**2 - s**2) * n  # (1)
    return elbow


def _subject(names: tuple[str, ...], xyz: Floats, rate: float) -> Subject:
    links = pairs(names, (names[0], names[1]), (names[1], names[2]))
    return Subject(names, rate, xyz, np.array(10.0), Capsules.none(xyz.shape[1]), links)
