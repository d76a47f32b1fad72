"""What a trial itself says of centroid noise, of the lens model and of the calibration.

Each point was found from its own images by least squares, with equal weights here. To first order an error e of its n
images moves it by H e, H = (Σ JᵀJ)⁻¹ Jᵀ (1), J = d uv / d X, and leaves the residual

    r = (1 − J H) e,    E|r|² = (2 n − 3) s²                             (2)

for errors of standard deviation s. Three kinds of error are told apart by what they have in common:

* **calibration**: e = T δ, T = d uv / d parameters, with one δ for the whole trial. It is what minimises

      Σ |r − (1 − J H) T δ|² / s² + Σ (δ_k / prior_k)²                    (3)

  over focal lengths, principal points and poses of all cameras (one step of a bundle adjustment). The points move by
  −H T δ; a common turn, shift and scale of them all is taken out (4), as no residual tells of it.
* **lens model**: what is left has, in one part of one image, one mean b (5) in all frames and for all markers.
* **centroid noise**: the rest (6).
* **disturbed images**: points whose residuals are far beyond all others take no part in this. A part of the marker was
  hidden in one image, two ran together, or it was another marker. By (2) such a point has Σ |r|² / (2 n − 3) of its own
  (9), and points of two cameras, whose residuals tell nothing, are taken to be disturbed as often.

A mean of noisy residuals is never nothing. So the trial is cut into two halves (alternating stretches of time, so that
both have every marker and every place), δ and b are found in each, and what both have in common, m₁ · m₂ averaged, is
free of the noise (7); negative means that nothing is seen. Points absorb a part of any error (2), so variances of b in
residuals are made larger by Σ 2 n / Σ (2 n − 3) (8).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..data import PARAMETERS, Rig
from ..data.array_types import Bools, Floats, Ints
from ..geometry import origin_near, parameter_jacobian, point_jacobian, refine, rig_about
from ..numerics.small_matrices import inverse3

FREE = (0, 1, 2, 3, 9, 10, 11, 12, 13, 14)
"""Of `data.PARAMETERS`: focal lengths, principal point, turn, place; by definition."""
PRIOR = (0.02, 0.02, 20.0, 20.0, 0.02, 0.02, 0.02, 30.0, 30.0, 30.0)
"""Standard deviations of (3): share of the focal length, px, rad, mm; wide, to hold what no residual tells of.
Chosen."""
CELLS = (8, 6)  # of an image, across and down; chosen
FEWEST = 3
"""Images in a cell and half, below which its mean is not used; chosen."""
OUTLIER = 6.0
"""Residuals this many times the usual are mistakes of matching or of detection, and not counted; chosen."""
ROUNDS = 20  # of reweighting at most; chosen
STRETCH_S = 0.25  # s of a stretch that goes to one half or the other; chosen, longer than noise lasts


class Gains(NamedTuple):
    """Of N points and C cameras: by (1) H (N, C, 3, 2), zero where unseen; T (N, C, 2, 15); J (N, C, 2, 3)."""

    H: Floats
    T: Floats
    J: Floats


class Shown(NamedTuple):
    """What N points of a trial show.

    Attributes:
        used: (N) which of the points were counted; they have three cameras.
        placed: (N) points of two cameras or more, on which the same errors of the cameras act.
        residual: (N, C, 2) px, NaN where unseen or where the point has no three cameras.
        disturbed: (N) px², the variance (9) of a disturbed point's images; 0 for those that were counted.
        noise_px: standard deviation of a centroid along an axis (6); NaN where no point has three cameras.
        calibration_px, lens_px: the same of what is common (7); 0 where nothing is seen.
        calibration, lens: (N, 3) mm by which placed points are off; NaN where no point has three cameras.
        cells: (C, 8, 6, 2) px the mean residual by parts of the image (5), NaN where there are too few.
        edges: (C, 2, 2) px corners of the grid of cells.
        freedom: Σ (2 n − 3).
    """

    used: Bools
    placed: Bools
    residual: Floats
    disturbed: Floats
    noise_px: float
    calibration_px: float
    lens_px: float
    calibration: Floats
    lens: Floats
    cells: Floats
    edges: Floats
    freedom: int


def gains(rig: Rig, xyz: Floats, seen: Bools) -> Gains:
    """(1) and the derivatives behind it at points (N, 3) mm that cameras see (N, C)."""
    J = np.zeros((*seen.shape, 2, 3))
    T = np.zeros((*seen.shape, 2, len(PARAMETERS)))
    for c, camera in enumerate(rig):
        J[seen[:, c], c] = point_jacobian(camera, xyz[seen[:, c]])
        T[seen[:, c], c] = parameter_jacobian(camera, xyz[seen[:, c]])
    inverse = np.where((seen.sum(1) >= 2)[:, None, None], inverse3(np.einsum("ncki,nckj->nij", J, J)), np.nan)
    return Gains(np.einsum("nij,nckj->ncik", inverse, J), T, J)


def shown(rig: Rig, xyz: Floats, uv: Floats, time_s: Floats) -> Shown:
    """What images (N, C, 2) px, NaN where unseen, of points (N, 3) mm at times (N) s show by (3) to (8)."""
    origin = origin_near(xyz)  # about which the priors of (3) hold
    plain = rig_about(rig.as_known(), origin)
    xyz = xyz - origin
    place = refine(plain, xyz, uv, np.broadcast_to(np.eye(2), (*uv.shape, 2)))
    views = np.isfinite(uv[..., 0]).sum(1)
    used = _without_outliers(place.residual, (views >= 3) & np.isfinite(place.xyz).all(1))
    seen: Bools = np.isfinite(uv[..., 0]) & used[:, None]
    r = np.where(seen[..., None], place.residual, 0.0)
    freedom = int((2 * views[used] - 3).sum())
    later = np.floor(time_s / STRETCH_S).astype(np.int64) % 2 == 1
    common = _common_errors(plain, place.xyz, uv, r, [used & later, used & ~later, used])
    widen = 2 * int(views[used].sum()) / max(freedom, 1)  # (8)
    placed, calibration, lens = _displacements(plain, place.xyz, uv, common)
    known = 1.0 if freedom else float("nan")
    noise_px, calibration_px, lens_px = _deviations(r, common.explained, common.bent, freedom)
    return Shown(
        used=used,
        placed=placed,
        residual=np.where((views >= 3)[:, None, None], place.residual, np.nan),
        disturbed=_disturbed(place.residual, views, used),
        noise_px=noise_px * known,
        calibration_px=calibration_px,
        lens_px=lens_px,
        calibration=calibration * known,
        lens=lens * np.sqrt(widen) * known,
        cells=common.field.means(r - common.explained[2], uv, seen),
        edges=common.field.edges,
        freedom=freedom,
    )


class _CommonErrors(NamedTuple):
    """Of both halves: δ of (3), what it explains of residuals, means of (5) and these at the images; δ of all third."""

    delta: list[Floats]
    explained: list[Floats]
    field: _Field
    means: list[Floats]
    bent: list[Floats]


def _common_errors(rig: Rig, xyz: Floats, uv: Floats, r: Floats, parts: list[Bools]) -> _CommonErrors:
    """What residuals r (N, C, 2) have in common in two halves and in all used points, (N) each."""
    seen: Bools = np.isfinite(uv[..., 0]) & parts[2][:, None]
    gain, freedom = gains(rig, xyz, seen), int((2 * np.isfinite(uv[..., 0]).sum(1)[parts[2]] - 3).sum())
    delta = [_change(rig, gain, r, part, freedom) for part in parts]
    explained = [_left_by(gain, _images(gain, d)) for d in delta]
    field = _Field.over(rig, uv)
    means = [field.means(r - explained[2], uv, seen & half[:, None]) for half in parts[:2]]
    return _CommonErrors(delta, explained, field, means, [field.at(mean, uv, seen) for mean in means])


def _deviations(r: Floats, explained: list[Floats], bent: list[Floats], freedom: int) -> tuple[float, float, float]:
    """Standard deviations, px, of noise (6), calibration and lens model (7), from residuals and what halves explain."""
    common = [max(float((a * b).sum()), 0.0) for a, b in (explained[:2], bent)]  # (7)
    noise = max(float((r**2).sum()) - sum(common), 0.0)  # (6)
    own, calibration, lens = (float(np.sqrt(part / max(freedom, 1))) for part in (noise, *common))
    return own, calibration, lens


def _displacements(rig: Rig, xyz: Floats, uv: Floats, common: _CommonErrors) -> tuple[Bools, Floats, Floats]:
    """Which points (N) have two cameras, and by how much the changes and the means of both halves move these, mm."""
    seen: Bools = np.isfinite(uv[..., 0])
    placed = (seen.sum(1) >= 2) & np.isfinite(xyz).all(1)
    seen = seen & placed[:, None]
    gain = gains(rig, np.where(placed[:, None], xyz, xyz[placed].mean(0) if placed.any() else 0.0), seen)
    moves = [_shape(xyz, _moved(gain, _images(gain, d)), placed) for d in common.delta[:2]]
    bends = [_moved(gain, common.field.at(mean, uv, seen)) for mean in common.means]
    return placed, _common(moves[0], moves[1], placed), _common(bends[0], bends[1], placed)


def _without_outliers(residual: Floats, usable: Bools) -> Bools:
    """The usable points (N) without a residual (N, C, 2) that is beyond all others.

    What is usual is found again without those that were left out, until none is: where a third of all images are
    disturbed, the median of all is no measure of the good ones.
    """
    size = np.sqrt(np.nansum(residual**2, axis=-1))
    left = usable & (size > 0).any(1)
    for _ in range(ROUNDS):
        usual = float(np.median(size[left][size[left] > 0])) if left.any() else np.inf
        kept = left & (size.max(1, initial=0.0) <= OUTLIER * usual)
        if (kept == left).all():
            break
        left = kept
    return np.asarray(left)


def _disturbed(residual: Floats, views: Ints, used: Bools) -> Floats:
    """(N) px² by (9)."""
    three = (views >= 3) & np.isfinite(residual).any((1, 2))
    own = np.where(three & ~used, np.nansum(residual**2, axis=(1, 2)) / np.maximum(2 * views - 3, 1), 0.0)
    usual = float(own[three].mean()) if three.any() else 0.0
    return np.where(views == 2, usual, own)


def _images(gain: Gains, delta: Floats) -> Floats:
    """T δ (N, C, 2) px of a change (C, 15) of the parameters."""
    return np.einsum("ncik,ck->nci", gain.T, delta)


def _moved(gain: Gains, e: Floats) -> Floats:
    """How far errors (N, C, 2) px move the points, H e (N, 3) mm; 0 for points that do not count."""
    return np.nan_to_num(np.einsum("ncij,ncj->ni", gain.H, e))


def _left_by(gain: Gains, e: Floats) -> Floats:
    """(1 − J H) e (N, C, 2) px."""
    seen = (gain.J != 0).any((2, 3))
    return np.where(seen[..., None], e - np.einsum("ncij,nj->nci", gain.J, _moved(gain, e)), 0.0)


def _change(rig: Rig, gain: Gains, r: Floats, part: Bools, freedom: int) -> Floats:
    """δ (C, 15) of (3) from some of the points (N)."""
    C, k = len(rig), len(FREE)
    scale = np.tile(PRIOR, (C, 1)) * np.array([[camera.K[0, 0], abs(camera.K[1, 1])] + [1.0] * 8 for camera in rig])
    T = gain.T[part][..., FREE] * scale[:, None]
    J, H = gain.J[part], np.nan_to_num(gain.H[part])
    both = np.einsum("ncij,nciq->njcq", J, T).reshape(-1, 3, C * k)  # Jᵀ T
    gone = np.einsum("ncij,ncjq->nicq", H, T).reshape(-1, 3, C * k)  # H T
    A = -np.einsum("niq,nip->qp", both, gone, optimize=True)
    for c in range(C):
        A[c * k : (c + 1) * k, c * k : (c + 1) * k] += np.einsum("niq,nip->qp", T[:, c], T[:, c], optimize=True)
    s2 = float((r**2).sum()) / max(freedom, 1)
    pull = np.einsum("nciq,nci->cq", T, r[part]).reshape(-1)
    delta = np.zeros((C, len(PARAMETERS)))
    delta[:, FREE] = np.linalg.solve(A + max(s2, 1e-12) * np.eye(C * k), pull).reshape(C, k) * scale  # (3)
    return delta


def _shape(xyz: Floats, move: Floats, used: Bools) -> Floats:
    """Moves (N, 3) mm of points (N, 3) without a common shift, turn and scale (4)."""
    if used.sum() < 4:
        return move
    near = xyz[used] - xyz[used].mean(0)
    x, y, z = near.T
    zero = np.zeros_like(x)
    rotations = [np.stack(v, -1) for v in ((zero, -z, y), (z, zero, -x), (-y, x, zero), (x, y, z))]
    G = np.stack([*rotations, *(np.broadcast_to(axis, near.shape) for axis in np.eye(3))], -1).reshape(-1, 7)
    fit = np.linalg.lstsq(G, move[used].reshape(-1))[0]
    out = np.zeros_like(move)
    out[used] = move[used] - (G @ fit).reshape(-1, 3)
    return out


def _common(a: Floats, b: Floats, used: Bools) -> Floats:
    """What two estimates (N, 3) mm have in common: their mean, made smaller so that its square sum is that of (7)."""
    mean = np.where(used[:, None], (a + b) / 2, 0.0)
    share = float((a[used] * b[used]).sum()) / max(float((mean**2).sum()), 1e-300)
    return mean * np.sqrt(min(max(share, 0.0), 1.0))


class _Field(NamedTuple):
    """A grid of cells over every image; edges (C, 2, 2) px."""

    edges: Floats

    @classmethod
    def over(cls, rig: Rig, uv: Floats) -> _Field:
        """Over the parts of the images in which anything was seen (N, C, 2)."""
        low = np.array([np.nanmin(uv[:, c], axis=0, initial=1e9) for c in range(len(rig))])
        high = np.array([np.nanmax(uv[:, c], axis=0, initial=-1e9) for c in range(len(rig))])
        return cls(np.stack([low, np.maximum(high, low + 1)], 1))

    def cell(self, uv: Floats, seen: Bools) -> Ints:
        """(N, C) which cell of all each image lies in."""
        share = (np.nan_to_num(uv) - self.edges[:, 0]) / (self.edges[:, 1] - self.edges[:, 0])
        at = np.clip((share * CELLS).astype(np.int64), 0, np.array(CELLS) - 1)
        return np.where(seen, at[..., 0] * CELLS[1] + at[..., 1], 0)

    def means(self, r: Floats, uv: Floats, seen: Bools) -> Floats:
        """(C, 8, 6, 2) px the mean of residuals (N, C, 2) in each cell (5)."""
        cell, n = self.cell(uv, seen), CELLS[0] * CELLS[1]
        out = np.full((r.shape[1], n, 2), np.nan)
        for c in range(r.shape[1]):
            here = cell[seen[:, c], c]
            counts = np.bincount(here, minlength=n)
            for k in (0, 1):
                total = np.bincount(here, r[seen[:, c], c, k], minlength=n)
                out[c, :, k] = np.where(counts >= FEWEST, total / np.maximum(counts, 1), np.nan)
        return out.reshape(-1, *CELLS, 2)

    def at(self, means: Floats, uv: Floats, seen: Bools) -> Floats:
        """(N, C, 2) px the mean of the cell that each image lies in; 0 where it is not known."""
        flat = np.nan_to_num(means.reshape(len(means), -1, 2))
        return np.where(seen[..., None], flat[np.arange(len(means)), self.cell(uv, seen)], 0.0)
