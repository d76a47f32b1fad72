"""One of few cameras that stands elsewhere than its file says: which one, and where it stands.

Cameras all round a subject share each marker by twos, and no third image tells which of two cameras is wrong. But if
camera c alone was moved, there is one pose of c by which its images meet those of all others; another camera that is
moved instead mends some pairs and breaks others. Files are a little off in all cameras, too, and where all are adjusted
by that little, hardly anything may be left for a moved one. So the rig of the file but for what is usual is compared
with the same and one camera that may stand far off: hypotheses that differ in their θ₀ alone. Cameras are turned, moved
and refocused (`rig_of_tracks` (1)) by θ, where

    Σ w g e² / (v D) + Σ (θ / θ₀)²                                                        (1)

is least, w being Cauchy's weights, g the probability that a pair is one marker, and D as in `image_pairs`, in rounds
with less v. With H the matrix of the normal equations of (1) in units of θ₀, and L of `image_pairs` (1),

    S = L − ½ Σ (θ / θ₀)² − ½ ln det H                                                    (2)

is Laplace's approximation of the evidence (MacKay 1992): who may be anywhere pays for each way in which the images tell
where, and nothing for those in which they do not. G_c is S for a moved camera c less that for none. Camera c was moved
where, for all other cameras b,

    G_c > ENOUGH   and   G_c > G_b + ENOUGH.                                              (3)

If only the second is not so, it is one of the cameras within ENOUGH, and nobody can tell which.

A far pose is looked for by a Hough transform (Hough 1962): if the images of c lie beside by d, a pair with the residual
e has e = l · d, a line in the plane of d, and the lines of pairs of one marker meet (4). From where most do, and from
d = 0, camera c is fitted alone, and then the others with it. Its pose is at last fitted by the others as they stand in
the file, as points are solved by these.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.ndimage import maximum_filter, uniform_filter

from ...data import Camera, Detections, Rig
from ...data.array_types import Floats, Ints
from ...geometry import fundamental
from ...geometry.common_view import common_view_centre
from ...numerics.robust import cauchy_weight
from .detection_index import read_images
from .image_pairs import Pairs, clump_lengths, evidence, one_marker, read_pairs, residuals_of_two
from .rig_of_tracks import SOFT, changed_camera

FEWEST, MOST = 3, 4
"""Cameras; by definition: of two nobody can tell; and chosen: of more, three see most markers."""
REACH, STEP = 120.0, 4.0
"""px of d of (4), chosen: by a turn of some 4°; and between the d that are counted, chosen: what a camera's way and
turn about its axis do beside is mostly less."""
AROUND = 9
"""Steps to a side about a d, in which lines are counted as usual there; chosen."""
LEAST_PAIRS = 100
"""Of images with those of other cameras, from which on a camera is suspected; chosen: there are some thousand."""
STARTS, BETTER_STARTS = 4, 2
"""Of (4), and those from which the other cameras are adjusted as well; chosen for speed."""
USUAL = np.full(7, 1e-3)
"""θ₀ of (1): rad, shares of the distance, and of the focal length; chosen: each is 1 to 2 px, what files are off."""
TURNED, MOVED = (np.array([0.05] * 3 + [way] * 3 + [1e-3]) for way in (1e-3, 0.01))
"""θ₀ of (1) of a camera that was moved; chosen: a knock turns it by 3°, and one that was put elsewhere stands 4 cm
away; its lens is not touched. The better S counts."""
WIDTHS = (5.0, 3.0, 1.5, 0.8, 0.5)
"""px, √v of (1), a round each; chosen: from offsets between the d of (4) to LEAST_SD of `image_pairs`."""
LAST = (*WIDTHS[-2:], *5 * WIDTHS[-1:])
"""px, of the camera that is used; chosen: until it stays (turns about its axis are slow)."""
ENOUGH = 10.0
"""Of (3), a natural logarithm; chosen: one camera in a hundred was moved (ln 100), and one such finding in a hundred
may be wrong (as much again)."""


class Suspect(NamedTuple):
    """A camera where it fits best, its G of (3), and how far (2) its images lie beside, px."""

    camera: Camera
    gain: float
    offset: Floats


class Moved(NamedTuple):
    """Cameras, numbers, of which one was moved, and where each then stands; several where nobody can tell which."""

    suspects: dict[int, Suspect]

    @property
    def sure(self) -> bool:
        """Whether it is known which one."""
        return len(self.suspects) == 1


def moved_camera(detections: Detections, rig: Rig) -> Moved:
    """Which camera stands elsewhere, by (3); none where all fit, or nothing is known."""
    centre = common_view_centre(rig)
    if not FEWEST <= len(rig) <= MOST or centre is None or not detections.valid.any():
        return Moved({})
    found = suspects(detections, rig, centre)
    best = max(one.gain for one in found)
    if best < ENOUGH:
        return Moved({})
    return Moved({c: one for c, one in enumerate(found) if one.gain > best - ENOUGH})


def suspects(detections: Detections, rig: Rig, centre: Floats) -> list[Suspect]:
    """Each camera as if it alone were moved, in a room with this middle (3) mm."""
    images = read_images(detections, rig)
    pairs = read_pairs(detections, images, REACH)
    search = _Search(pairs, images.P, rig, clump_lengths(pairs, pairs.residuals(images.P).e), centre)
    usual = np.tile(USUAL, (len(rig), 1))
    fits = [_where_best(search, c) for c in range(len(rig))]
    none = [_fitted(search, np.zeros_like(usual), usual)]
    none += [_fitted(search, one.theta, usual, WIDTHS[1:]) for one in fits]  # some begin near a better one
    least = max(one.evidence for one in none)
    return [_suspect(search, c, fit, fit.evidence - least) for c, fit in enumerate(fits)]


class _Search(NamedTuple):
    """Pairs, P (C, 3, 4) of the rig as given, D of `image_pairs`, and the middle of the room."""

    pairs: Pairs
    P: Floats
    rig: Rig
    D: Floats
    centre: Floats

    def changed(self, c: int, theta: Floats) -> Camera:
        """Camera c changed by θ (7)."""
        return changed_camera(self.rig[c], theta, float(np.linalg.norm(self.rig[c].centre - self.centre)))

    def one(self, c: int, theta: Floats) -> Floats:
        """(3, 4) P of camera c with θ (7)."""
        own = self.changed(c, theta)
        return np.asarray(own.K @ np.column_stack([own.R, own.t]))

    def cameras(self, theta: Floats) -> Floats:
        """P with θ (C, 7)."""
        return np.array([self.one(c, each) for c, each in enumerate(theta)])


class _Fit(NamedTuple):
    """θ (C, 7) by (1) with θ₀ (C, 7), and its evidence S by (2)."""

    theta: Floats
    usual: Floats
    evidence: float


def _where_best(search: _Search, c: int) -> _Fit:
    """Where camera c fits best if it was moved."""
    own, usual = search._replace(pairs=search.pairs.of_camera(c)), np.tile(USUAL, (len(search.rig), 1))
    fits = sorted((_fitted(own, theta, _alone(c, theta, TURNED)) for theta in _starts(own, c)), key=_said)
    usual[c] = TURNED
    turned = max((_fitted(search, one.theta, usual, WIDTHS[1:]) for one in fits[-BETTER_STARTS:]), key=_said)
    moved = np.vstack([usual[:c], [MOVED], usual[c + 1 :]])
    return max(turned, _fitted(search, turned.theta, moved, WIDTHS[1:]), key=_said)


def _suspect(search: _Search, c: int, fit: _Fit, gain: float) -> Suspect:
    """Camera c by the others as they stand in the file, from where it fits best."""
    if (search.pairs.camera == c).any(0).sum() < LEAST_PAIRS:
        return Suspect(search.rig[c], 0.0, np.zeros(2))
    own, usual = search._replace(pairs=search.pairs.of_camera(c)), _alone(c, fit.theta, fit.usual[c])
    theta = _fitted(own, np.where(usual > 0, fit.theta, 0.0), usual, LAST).theta[c]
    return Suspect(search.changed(c, theta), gain, _image_offset(search, c, theta))


def _said(fit: _Fit) -> float:
    """What is told of it."""
    return fit.evidence


def _alone(c: int, like: Floats, usual: Floats) -> Floats:
    """θ₀ (C, 7) of camera c alone, as many as these."""
    out = np.zeros_like(like)
    out[c] = usual
    return out


def _image_offset(search: _Search, c: int, theta: Floats) -> Floats:
    """(2) px, the median by which images of camera c at the distance of the middle move with θ (7)."""
    camera, x = search.rig[c], search.pairs.x[search.pairs.camera == c]
    rays = x @ np.linalg.inv(camera.K).T
    X = rays * float(camera.R[2] @ search.centre + camera.t[2])
    h = np.column_stack([(X - camera.t) @ camera.R, np.ones(len(X))]) @ search.one(c, theta).T
    return np.asarray(np.median(h[:, :2] / h[:, 2:] - x[:, :2], axis=0))


def _starts(search: _Search, c: int) -> list[Floats]:
    """θ (C, 7) of turns of camera c by the d of (4), and none."""
    pairs, camera = search.pairs, search.rig[c]
    e, line = pairs.residuals(search.P)
    across = np.where((pairs.camera[0] == c)[:, None], line[0], line[1])
    half = round(REACH / STEP)
    n = 2 * half + 1
    clear = np.zeros((n, n))
    for group in np.unique(pairs.group).tolist():
        own = pairs.group == group
        count = 9 * uniform_filter(_lines(e[own], across[own], half), 3, mode="constant")
        usual = uniform_filter(count, AROUND, mode="nearest")
        clear += (count - usual) / np.sqrt(usual + 1)
    clear[half, half] = -np.inf
    clear = np.where(clear == maximum_filter(clear, 3), clear, -np.inf)
    best = np.argsort(-clear, axis=None)[:STARTS]
    d = STEP * (np.array(np.unravel_index(best, clear.shape)).T - half)
    turns = np.zeros((STARTS + 1, len(search.rig), 7))
    turns[1:, c, 0], turns[1:, c, 1] = -d[:, 1] / camera.K[1, 1], d[:, 0] / camera.K[0, 0]
    return list(turns)


def _lines(e: Floats, across: Floats, half: int) -> Floats:
    """(n, n) how many lines e = across (N, 2) · d go through each d, u by rows, to `half` steps aside."""
    n, steps = 2 * half + 1, STEP * np.arange(-half, half + 1)
    out = np.zeros((n, n))
    along_u = np.abs(across[:, 1]) > np.abs(across[:, 0])
    for own, a, b in ((along_u, 1, 0), (~along_u, 0, 1)):
        k = np.rint((e[own, None] - across[own, b, None] * steps) / across[own, a, None] / STEP).astype(np.int64) + half
        within = (k >= 0) & (k < n)
        cell = (np.arange(n) * n + k)[within]
        count = np.bincount(cell, minlength=n * n).reshape(n, n)
        out += count if a == 1 else count.T
    return out


def _fitted(search: _Search, theta: Floats, usual: Floats, widths: tuple[float, ...] = WIDTHS) -> _Fit:
    """θ (C, 7) by (1) with θ₀ (C, 7), 0 for what stays, from there."""
    scale, n = usual.ravel(), usual.size
    H = np.eye(n)
    for sd in widths:
        found = search.pairs.residuals(search.cameras(theta))
        near = np.abs(found.e) < 4 * sd
        pairs, e = search.pairs.take(near), found.e[near]
        g = _probability(e, pairs.group, search.pairs.C**2, sd)
        root = np.sqrt(g * cauchy_weight((e / sd) ** 2, SOFT) / search.D[pairs.group]) / sd
        J = _jacobian(search, theta, pairs, np.flatnonzero(usual.any(1))).reshape(-1, n) * root[:, None] * scale
        H = J.T @ J + np.eye(n)
        z = np.divide(theta.ravel(), scale, out=np.zeros(n), where=scale > 0)
        step = np.linalg.solve(H, J.T @ (root * e) + z)
        theta = theta - (scale * step).reshape(theta.shape)
    z = np.divide(theta, usual, out=np.zeros_like(theta), where=usual > 0)
    said = evidence(search.pairs, search.cameras(theta), search.D)
    return _Fit(theta, usual, said - float((z**2).sum() + np.linalg.slogdet(H)[1]) / 2)


def _probability(e: Floats, group: Ints, n: int, sd: float) -> Floats:
    """(N) g of (1), of pairs with residuals e (N) px within 4 sd, of n groups."""
    total, share = np.maximum(np.bincount(group, minlength=n), 1), np.full(n, 0.3)
    one = one_marker(e, sd**2)
    for _ in range(5):
        own = share[group] * one
        g = own / (own + (1 - share[group]) / (8 * sd))
        share = np.clip(np.bincount(group, g, n) / total, 1e-3, 0.99)
    return np.asarray(g)


def _jacobian(search: _Search, theta: Floats, pairs: Pairs, free: Ints) -> Floats:
    """(N, C, 7) the change of e by θ (C, 7) of the cameras that are free, numbers."""
    group, J = pairs.group, np.zeros((pairs.x.shape[1], *theta.shape))
    step = 1 / np.array([one.K[0, 0] for one in search.rig])
    P = search.cameras(theta)
    by = {c: [search.one(c, theta[c] + d) for d in step[c] * np.eye(7)] for c in free.tolist()}
    for pair in np.unique(group).tolist():
        own, (r, s) = group == pair, divmod(pair, pairs.C)
        x = pairs.x[:, own]
        e = residuals_of_two(x, fundamental(P[r], P[s])).e
        for c in {r, s} & {*by}:
            F = np.array([fundamental(P[r], each) if c == s else fundamental(each, P[s]) for each in by[c]])
            J[own, c] = (residuals_of_two(x, F).e - e).T / step[c]
    return J
