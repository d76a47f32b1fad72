"""One of few cameras that stands elsewhere than its file says: which one, and where it stands.

Cameras all round a subject share each marker by twos, and no third image tells which of two cameras is wrong. But if
camera c alone was moved, there is one pose of c by which its images meet those of all others, while these meet as they
do; another camera that is moved instead mends some pairs and breaks others. So each camera is suspected in turn, and
fitted to some blocks of the recording. G_c is by how much the evidence in the other blocks (`image_pairs` (1)) then
exceeds that for the rig as given, less ln (1 + |d|)² for as many places at which images could lie beside by up to d px.

The pose is looked for by a Hough transform (Hough 1962): if the images of c lie beside by d, a pair with the residual e
has e = l · d, a line in the plane of d, and the lines of pairs of one marker meet (1). From where most do, and from
d = 0, camera c is turned, and then also moved and refocused (`rig_of_tracks` (1)), so that

    Σ w g e² / v + Σ (θ / θ₀)²  is least,                                                 (2)

w being Cauchy's weights and g the probability that a pair is one marker, in rounds with less v. Who moves besides has
to gain MORE than who turns alone. Camera c was moved where, for all other cameras b,

    G_c > ENOUGH,   CLEAR · G_c > G_b   and its images lie beside by FAR and more.        (3)

If only the second is not so, it is one of the cameras within CLEAR that lie as far beside, and nobody can tell which.
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
"""px of d of (1), chosen: by a turn of some 4°; and between the d that are counted, chosen: what a camera's way and
turn about its axis do beside is mostly less."""
AROUND = 9
"""Steps to a side about a d, in which lines are counted as usual there; chosen."""
LEAST_PAIRS = 100
"""Of images with those of other cameras, from which on a camera is suspected; chosen: there are some thousand."""
STARTS, BETTER_STARTS = 4, 2
"""Of (1), and those from which a camera is moved as well; chosen for speed."""
TURNED = np.array([0.1, 0.1, 0.1, 3e-4, 3e-4, 3e-4, 3e-4])
"""θ₀ of (2): rad, shares of the distance, and of the focal length; chosen, as in `turned_camera`."""
MOVED = np.array([0.1, 0.1, 0.1, 0.02, 0.02, 0.02, 3e-3])
"""θ₀ of (2): rad, shares of the distance, and of the focal length; chosen: a knock turns a camera, and one that was put
elsewhere stands some cm away."""
TURNING, MOVING = (5.0, 3.0, 1.5, 0.8, 0.5), (5.0, 3.0, 1.5, 0.8, 0.5, 0.3)
"""px, √v of (2), a round each; chosen: to below the noise of most cameras."""
MORE = 8.0
"""Of (2); chosen: four parameters, each known to a hundredth of what it may be, are ln 100 each, halved for clumps."""
ENOUGH, CLEAR = 20.0, 0.8
"""Of (3), a natural logarithm, and a share; chosen on 130 scenes of three and four cameras, half of them good: these
had G of up to 10 with d of 3 px and more, and wrong ones that were rightly told 27 and more. Where another camera had
0.83 to 0.95 of G, the wrong one was told in two of three."""
FAR = 3.0
"""px of (3); chosen: right cameras of files 1 px off gain by up to 2.6."""


class Suspect(NamedTuple):
    """A camera where it fits best, its gain G, and how far (2) its images lie beside, px."""

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
    near = {c: one for c, one in enumerate(found) if one.gain > CLEAR * best}
    far = {c: one for c, one in near.items() if np.linalg.norm(one.offset) > FAR}
    return Moved(far if len(far) == len(near) else {})


def suspects(detections: Detections, rig: Rig, centre: Floats) -> list[Suspect]:
    """Each camera as if it alone were moved, in a room with this middle (3) mm."""
    images = read_images(detections, rig)
    pairs = read_pairs(detections, images, REACH)
    D = clump_lengths(pairs, pairs.residuals(images.P).e)
    return [_suspect(_Search(c, pairs.of_camera(c), images.P, rig[c], D, centre)) for c in range(len(rig))]


class _Search(NamedTuple):
    """Camera c of the P (C, 3, 4), its pairs, D of `image_pairs`, and the middle of the room."""

    c: int
    pairs: Pairs
    P: Floats
    camera: Camera
    D: Floats
    centre: Floats

    def changed(self, theta: Floats) -> Camera:
        """The camera changed by θ (7)."""
        return changed_camera(self.camera, theta, float(np.linalg.norm(self.camera.centre - self.centre)))

    def cameras(self, theta: Floats) -> Floats:
        """P with it."""
        P, own = self.P.copy(), self.changed(theta)
        P[self.c] = own.K @ np.column_stack([own.R, own.t])
        return P

    def said(self, theta: Floats) -> Floats:
        """(2) L, and that of the blocks for fitting."""
        return np.array([each.sum() for each in evidence(self.pairs, self.cameras(theta), self.D)])


def _suspect(search: _Search) -> Suspect:
    """Camera c where it fits best in the blocks for fitting."""
    if len(search.pairs.judging) < LEAST_PAIRS:
        return Suspect(search.camera, 0.0, np.zeros(2))
    fitting = search._replace(pairs=search.pairs.take(~search.pairs.judging))
    turned = [_fitted(fitting, theta, TURNED, TURNING) for theta in _starts(fitting)]
    said = [search.said(theta) for theta in turned]
    order = np.argsort([-each[1] for each in said])[:BETTER_STARTS].tolist()
    moved = [_fitted(fitting, turned[k], MOVED, MOVING) for k in order]
    said_moved = [search.said(theta) for theta in moved]
    best, other = order[0], int(np.argmax([each[1] for each in said_moved]))
    gains = said[best][0], said_moved[other][0] - MORE
    theta, usual = (turned[best], TURNED) if gains[0] > gains[1] else (moved[other], MOVED)
    theta = _fitted(search, theta, usual, MOVING[-2:])  # by all blocks
    offset = _image_offset(search, theta)
    gain = max(gains) - search.said(np.zeros(7))[0] - 2 * np.log1p(np.linalg.norm(offset))
    return Suspect(search.changed(theta), float(gain), offset)


def _image_offset(search: _Search, theta: Floats) -> Floats:
    """(2) px, the median by which images at the distance of the middle move with θ."""
    camera, own = search.camera, search.pairs.camera == search.c
    rays = search.pairs.x[own] @ np.linalg.inv(camera.K).T
    X = rays * float(camera.R[2] @ search.centre + camera.t[2])
    h = np.column_stack([(X - camera.t) @ camera.R, np.ones(len(X))]) @ search.cameras(theta)[search.c].T
    return np.asarray(np.median(h[:, :2] / h[:, 2:] - search.pairs.x[own][:, :2], axis=0))


def _starts(search: _Search) -> list[Floats]:
    """θ (7) of turns by the d of (1), and none."""
    pairs, P, camera = search.pairs, search.P, search.camera
    e, line = pairs.residuals(P)
    across = np.where((pairs.camera[0] == search.c)[:, None], line[0], line[1])
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
    turns = np.zeros((STARTS + 1, 7))
    turns[1:, 0], turns[1:, 1] = -d[:, 1] / camera.K[1, 1], d[:, 0] / camera.K[0, 0]
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


def _fitted(search: _Search, theta: Floats, usual: Floats, widths: tuple[float, ...]) -> Floats:
    """θ (7) by (2), from there."""
    for sd in widths:
        P = search.cameras(theta)
        found = search.pairs.residuals(P)
        near = np.abs(found.e) < 4 * sd
        pairs, e = search.pairs.take(near), found.e[near]
        g = _probability(e, pairs.group, search.pairs.C**2, sd)
        root = np.sqrt(g * cauchy_weight((e / sd) ** 2, SOFT)) / sd
        J = _jacobian(search, theta, pairs) * root[:, None]
        theta = theta - np.linalg.solve(J.T @ J + np.diag(usual**-2), J.T @ (root * e) + theta / usual**2)
    return theta


def _probability(e: Floats, group: Ints, n: int, sd: float) -> Floats:
    """(N) g of (2), of pairs with residuals e (N) px within 4 sd, of n groups."""
    total, share = np.maximum(np.bincount(group, minlength=n), 1), np.full(n, 0.3)
    one = one_marker(e, sd**2)
    for _ in range(5):
        own = share[group] * one
        g = own / (own + (1 - share[group]) / (8 * sd))
        share = np.clip(np.bincount(group, g, n) / total, 1e-3, 0.99)
    return np.asarray(g)


def _jacobian(search: _Search, theta: Floats, pairs: Pairs) -> Floats:
    """(N, 7) the change of e by θ."""
    step, group, J = 1 / search.camera.K[0, 0], pairs.group, np.zeros((len(pairs.judging), 7))
    P = [search.cameras(theta + change) for change in (np.zeros(7), *(step * np.eye(7)))]
    for g in np.unique(group).tolist():
        own, r, s = group == g, g // pairs.C, g % pairs.C
        e = residuals_of_two(pairs.x[:, own], np.array([fundamental(each[r], each[s]) for each in P])).e
        J[own] = (e[1:] - e[0]).T / step
    return J
