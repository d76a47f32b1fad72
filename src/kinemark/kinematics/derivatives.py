"""Velocities and accelerations of markers, with their standard deviations.

Differences of positions multiply their noise: at 100 Hz a millimetre of noise is 70 mm/s of velocity and 12 m/s² of
acceleration by central differences. Here a path is taken for a motion whose acceleration walks at random, seen with
noise: the model of `signal.smoother` (1) and (2), of which the mean, given all samples, is a smoothing spline (Wecker
and Ansley 1983), and whose state holds velocity and acceleration with their covariance. That needs two numbers,
σ of the samples and U, by how much the acceleration changes from frame to frame. With r = U / σ and the innovations
e_k of the filter at σ = 1, of variance s_k, the likelihood of the samples is greatest where

    σ² = mean e² / s,    −2 log L = n log σ² + Σ log s                                        (1)

(Schweppe 1965), and r is that of the least (1) among `RATIOS`, and between its neighbours by a parabola. The three axes
of a marker share both numbers, so that the result turns with the laboratory.

The acceleration a(k) of the model holds from frame k to k + 1; at frame k it is (a(k − 1) + a(k)) / 2          (2).

The standard deviations count noise and what the smoothing takes away of a motion like the model's. One U serves a whole
path: where a foot strikes, the acceleration changes faster than at other times and errors are greater than stated, and
smaller elsewhere. Errors that change slowly, as of a calibration or of skin, are not in them.
"""

from __future__ import annotations

import numpy as np

from ..data import Trajectories
from ..data.array_types import Floats
from ..data.derivatives import MarkerDerivatives
from ..signal.smoother import filter_positions, smooth_positions

RATIOS = np.geomspace(1e-3, 30.0, 24)
"""U / σ that are tried, 1/frame²; chosen: from a still marker to one whose noise does not show."""
FEWEST = 8
"""Samples of a path, a number; chosen: two thirds of them are left once a start is found."""
MOST = 1500
"""Frames from which r is learned; chosen for time: more change it by less than its step."""
TOGETHER = 8
"""Markers worked on at once, a number; chosen for memory: 24 ratios and 3 axes of each."""
START = 3
"""Samples that only find the start, a number; by definition: position, velocity and acceleration."""


def marker_derivatives(trajectories: Trajectories) -> MarkerDerivatives:
    """Velocities and accelerations in all frames in which markers have positions, filled ones too."""
    xyz, rate = trajectories.xyz, trajectories.rate
    there = np.isfinite(xyz).all(2)
    x, sd, noise = np.full((*xyz.shape, 2), np.nan), np.full((*there.shape, 2), np.nan), np.full(len(xyz), np.nan)
    enough = np.flatnonzero(there.sum(1) >= FEWEST)
    for some in np.array_split(enough, -(-len(enough) // TOGETHER) or 1):
        if len(some):
            x[some], sd[some], noise[some] = _derivatives(xyz[some])
    x[~there] = sd[~there] = np.nan
    scale = rate ** np.array([1, 2])
    velocity, acceleration = np.moveaxis(x * scale, -1, 0)
    velocity_sd, acceleration_sd = np.moveaxis(sd * scale, -1, 0)
    return MarkerDerivatives(
        trajectories.names, rate, velocity, velocity_sd, acceleration, acceleration_sd, noise_sd=noise
    )


def _derivatives(xyz: Floats) -> tuple[Floats, Floats, Floats]:
    """(M, F, 3, 2) velocity and acceleration a frame, (M, F, 2) their deviations, (M) σ, of paths (M, F, 3)."""
    first = np.isfinite(xyz[..., 0]).argmax(1)
    y = (xyz - xyz[np.arange(len(xyz)), first][:, None]).swapaxes(1, 2)  # (M, 3, F)
    noise, ratio = noise_and_ratio(y)
    flat = np.repeat(noise, 3), np.repeat(ratio * noise, 3)
    found = smooth_positions(y.reshape(-1, y.shape[2]), sd=flat[0], process_sd=flat[1])
    x = found.x[..., 1:].reshape(*y.shape, 2).swapaxes(1, 2)
    x[:, 1:, :, 1] = (x[:, 1:, :, 1] + x[:, :-1, :, 1]) / 2  # (2)
    return x, np.sqrt(found.P[::3][..., [1, 2], [1, 2]]), noise


def noise_and_ratio(y: Floats) -> tuple[Floats, Floats]:
    """σ (M) mm and r (M) 1/frame² of the greatest likelihood by (1) for paths (M, 3, F) mm, NaN where missing."""
    y = np.stack([_stretch(path) for path in y])
    cost = _likelihoods(y, np.broadcast_to(RATIOS, (len(y), len(RATIOS))))[1]
    best = np.clip(cost.argmin(1), 1, len(RATIOS) - 2)
    a, b, c = (cost[np.arange(len(y)), best + k] for k in (-1, 0, 1))
    shift = np.clip(0.5 * (a - c) / np.maximum(a - 2 * b + c, 1e-12), -1, 1)
    ratio = RATIOS[best] * (RATIOS[1] / RATIOS[0]) ** shift
    return np.sqrt(_likelihoods(y, ratio[:, None])[0][:, 0]), ratio


def _stretch(path: Floats) -> Floats:
    """The frames (3, at most MOST) about the middle of the samples of a path (3, F)."""
    seen = np.flatnonzero(np.isfinite(path[0]))
    most = min(path.shape[1], MOST)
    begin = int(np.clip(seen[len(seen) // 2] - most // 2, 0, path.shape[1] - most))
    return path[:, begin : begin + most]


def _likelihoods(y: Floats, ratios: Floats) -> tuple[Floats, Floats]:
    """σ² (M, R) mm² and −2 log L (M, R) by (1) of paths (M, 3, F) mm for ratios (M, R)."""
    every = np.repeat(y[:, None], ratios.shape[1], 1)  # (M, R, 3, F)
    flat = every.reshape(-1, y.shape[2])
    found = filter_positions(flat, sd=np.ones(len(flat)), process_sd=np.repeat(ratios.ravel(), 3))
    seen = np.isfinite(flat)
    counted = seen & (np.cumsum(seen, 1) > START)
    s = np.where(counted, found.P_before[..., 0, 0] + 1.0, 1.0)
    e = np.where(counted, flat - found.x_before[..., 0], 0.0)
    n, squares, logs = (part.reshape(*ratios.shape, -1).sum(-1) for part in (counted, e**2 / s, np.log(s)))
    variance = np.maximum(squares / np.maximum(n, 1), 1e-12)
    return variance, n * np.log(variance) + logs
