"""Whether fitted discs are such as markers on each other, or behind a limb, would be.

All must leave less than `MISFIT` of the brightness at the rim (RMS), and every centre must be known within `KNOWN`.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..data.array_types import Floats
from ..native.shape_images import Patches
from .discs import DiscFit
from .patches import CutOut

MISFIT = 0.10  # of the brightness, RMS at the rim; studies/overlapping_markers.py judges it
RIM = 0.03  # of the brightness; chosen (see studies/overlapping_markers.py)
KNOWN = 0.5  # px, standard deviation; chosen (see studies/overlapping_markers.py)
SMALLEST = 2.0  # px, radius of the smallest disc that is believed; chosen (see studies/overlapping_markers.py)
ALIKE = 0.5  # the smaller radius by the larger; chosen (see studies/overlapping_markers.py)
IN_SIGHT = 0.2  # share of each disc's outline outside of the others; chosen (see studies/overlapping_markers.py)
HIDDEN = (0.02, 0.62)  # share of a cut disc's area; chosen (see studies/overlapping_markers.py)
APART = 0.6
"""Of the sum of the radii; the outline of two discs so far apart has a waist that nothing else has; chosen (see
studies/overlapping_markers.py)."""
AROUND = np.arange(24) * 2 * np.pi / 24  # rad; directions round a disc; chosen (see studies/overlapping_markers.py)


def rim(patches: Patches, model: Floats) -> NDArray[np.bool_]:
    """(n, N) the used pixels where a model is neither at its ground nor at its peak."""
    low, high = model.min(1, keepdims=True), model.max(1, keepdims=True)
    step = RIM * (high - low)
    return np.asarray((model > low + step) & (model < high - step) & (patches.weight > 0))


def plausible_discs(fit: DiscFit, cut: CutOut, k: int) -> NDArray[np.bool_]:
    """(n) whether k discs are of not too unequal size, each with enough of its outline in sight."""
    x, y, r = (fit.parameters[:, i : 3 * k : 3] for i in range(3))
    good = (r.min(1) > ALIKE * r.max(1)) & (r.min(1) > SMALLEST)
    u, v = x[..., None] + r[..., None] * np.cos(AROUND), y[..., None] + r[..., None] * np.sin(AROUND)
    beyond = np.hypot(u[:, :, None] - x[:, None, :, None], v[:, :, None] - y[:, None, :, None]) > r[:, None, :, None]
    beyond[:, np.arange(k), np.arange(k)] = True
    good &= beyond.all(2).mean(2).min(1) > IN_SIGHT
    variance = np.stack([fit.cov[:, i, i] for i in range(3 * k) if i % 3 < 2], 1).max(1)
    return np.asarray(good & _explains(fit, cut, variance))


def plausible_cut(fit: DiscFit, cut: CutOut) -> NDArray[np.bool_]:
    """(n) whether a cut disc lacks a part that can be seen, and is not mostly a guess."""
    x, y, r, turn, h = fit.parameters[:, :5].T
    d = np.clip((h - x * np.cos(turn) - y * np.sin(turn)) / np.maximum(r, SMALLEST), -1, 1)
    share = (np.arccos(d) - d * np.sqrt(1 - d * d)) / np.pi
    good = (share > HIDDEN[0]) & (share < HIDDEN[1]) & (r > SMALLEST)
    return np.asarray(good & _explains(fit, cut, np.maximum(fit.cov[:, 0, 0], fit.cov[:, 1, 1])))


def whole_disc(fit: DiscFit, cut: CutOut) -> NDArray[np.bool_]:
    """(n) whether one disc is known well and leaves little."""
    return np.asarray((fit.parameters[:, 2] > SMALLEST) & _explains(fit, cut, fit.cov[:, [0, 1], [0, 1]].max(1)))


def apart(fit: DiscFit, k: int) -> NDArray[np.bool_]:
    """(n) whether no two of k discs are nearer than `APART`."""
    x, y, r = (fit.parameters[:, i : 3 * k : 3] for i in range(3))
    i, j = np.triu_indices(k, 1)
    return np.asarray((np.hypot(x[:, i] - x[:, j], y[:, i] - y[:, j]) > APART * (r[:, i] + r[:, j])).all(1))


def _explains(fit: DiscFit, cut: CutOut, variance: Floats) -> NDArray[np.bool_]:
    """(n) whether the misfit is small, and the greatest variance (n) of the centres as well."""
    at_rim = rim(cut.patches, fit.model)
    number = np.maximum(at_rim.sum(1), 1)
    off = np.where(at_rim, cut.patches.grey - fit.model, 0.0)
    misfit = np.sqrt((off * off).sum(1) / number) / np.maximum(fit.parameters[:, -2], 1.0)
    scale = np.maximum(1.0, (cut.patches.weight * off * off).sum(1) / number)
    return np.asarray((misfit < MISFIT) & (variance * scale < KNOWN**2))
