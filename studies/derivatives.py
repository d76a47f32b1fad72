"""Errors of velocities and accelerations (KISS 6, ii), against truth.

    python studies/derivatives.py [seeds, 3]

"Errors in smoothing and differentiation of the trajectories for marker velocities and accelerations" are the second of
the five factors of section 6 of Shafiq, Tümer and Güler (2001), which the paper does not evaluate; all figures here are
computed. The fifteen markers of a walk of 2 s, whose true derivatives are those of the same walk at twenty times the
rate, are given white noise. Ways:

    kinemark      `marker_derivatives`, with its own standard deviations
    woltring      the quintic spline by cross-validation, and its central differences
    butterworth   the filter by residual analysis, and its central differences
    central       central differences of what was measured

The columns of kinemark: RMS error; the root mean square of what it states; and the share of the components that lie
within 1.96 of it, which is 95 % where it is true. A fifth of a second at either end is left out.
"""

from __future__ import annotations

import sys
from typing import NamedTuple

import numpy as np

from kinemark.data import MarkerTrajectory, Trajectories
from kinemark.data.array_types import Floats
from kinemark.kinematics import Butterworth, WoltringSpline, marker_derivatives, smooth
from kinemark.synth import walking

RATES, NOISES = (50.0, 100.0, 200.0), (0.1, 0.5, 2.0)
"""Hz, and mm along an axis."""
FINER, END_S = 20, 0.2  # times the rate, and s left out at either end; chosen


class Walk(NamedTuple):
    """Markers without noise (M, F, 3) mm, their velocity mm/s and acceleration mm/s²."""

    names: tuple[str, ...]
    xyz: Floats
    velocity: Floats
    acceleration: Floats


def walk(rate: float) -> Walk:
    """The truth."""
    fine = walking(duration_s=2.0, rate=rate * FINER)
    velocity = np.gradient(fine.xyz, 1 / fine.rate, axis=1)
    acceleration = np.gradient(velocity, 1 / fine.rate, axis=1)
    return Walk(fine.names, *(x[:, ::FINER] for x in (fine.xyz, velocity, acceleration)))


def measured(true: Walk, rate: float, noise: float, seed: int) -> Trajectories:
    """The walk with noise."""
    rng = np.random.default_rng(seed)
    paths = (
        MarkerTrajectory.measured(name, p + rng.normal(0, noise, p.shape))
        for name, p in zip(true.names, true.xyz, strict=True)
    )
    return Trajectories(tuple(paths), rate, 1)


def central(xyz: Floats, rate: float) -> tuple[Floats, Floats]:
    """Velocity and acceleration by central differences of (M, F, 3)."""
    velocity = np.gradient(xyz, 1 / rate, axis=1)
    return velocity, np.gradient(velocity, 1 / rate, axis=1)


def row(rate: float, noise: float, seeds: int) -> str:
    """One line: velocity mm/s, then acceleration m/s²."""
    true, end = walk(rate), round(END_S * rate)
    inner = (slice(None), slice(end, -end))
    truth = (true.velocity[inner], true.acceleration[inner] / 1000)
    off: dict[str, list[list[Floats]]] = {way: [[], []] for way in ("kinemark", "woltring", "butterworth", "central")}
    stated: list[list[Floats]] = [[], []]
    for seed in range(seeds):
        there = measured(true, rate, noise, seed)
        ours = marker_derivatives(there)
        found = {"kinemark": (ours.velocity, ours.acceleration), "central": central(there.xyz, rate)}
        for way, method in (("woltring", WoltringSpline()), ("butterworth", Butterworth())):
            found[way] = central(smooth(there, method=method).xyz, rate)
        for way, (velocity, acceleration) in found.items():
            for k, got in enumerate((velocity[inner], acceleration[inner] / 1000)):
                off[way][k].append(got - truth[k])
        for k, sd in enumerate((ours.velocity_sd[inner], ours.acceleration_sd[inner] / 1000)):
            stated[k].append(np.broadcast_to(sd[..., None], truth[k].shape))
    line = f"{rate:5.0f}{noise:6.1f}"
    for k in range(2):
        e, sd = np.array(off["kinemark"][k]), np.array(stated[k])
        line += f"{_root(e):11.2f}{_root(sd):8.2f}{100 * (np.abs(e) < 1.96 * sd).mean():7.1f}"
        line += "".join(f"{_root(np.array(off[way][k])):12.2f}" for way in ("woltring", "butterworth", "central"))
    return line


def _root(x: Floats) -> float:
    return float(np.sqrt(np.mean(x**2)))


def main() -> None:
    seeds = int(sys.argv[1]) if len(sys.argv) > 1 else 3
    print(f"{'':11}{'velocity, mm/s':^62}{'acceleration, m/s²':^62}")
    ways = f"{'kinemark':>11}{'stated':>8}{'% in':>7}{'woltring':>12}{'butterworth':>12}{'central':>12}"
    print(f"{'Hz':>5}{'mm':>6}{ways}{ways}")
    for rate in RATES:
        for noise in NOISES:
            print(row(rate, noise, seeds), flush=True)


if __name__ == "__main__":
    main()
