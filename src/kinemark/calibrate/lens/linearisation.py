"""The lens of a camera from pictures of a plane grid (KISS 3.2), and how straight its lines are before and after.

KISS looks at a grid of 300 points from close by, at the focal length of the measurement, and calculates a
"linearisation filter" from the grid lines' deviation from straightness. Here the whole picture of the plane is fitted
(`plane_views`): a pose for each view, the camera's focal lengths and centre, and as many lens terms as predict points
left out best (`lens_choice`). A point that misses its place by more than `reject` standard deviations, with

    s² = median(d²) / (2 ln 2)                                           (1)

of the normalised residuals d, is left out and the camera fitted again (as in `control_points`).

One view that faces the camera tells the lens, but no focal length: the camera then has the nominal one, the longer side
of the image, as the unit of its lens terms, and `focal_known` is false. The map from pixels to straightened pixels does
not depend on that unit; by a zoom of `plane_views` (2), lens terms for any other focal length follow.

Straightness is the RMS distance of the points of all rows and columns of the grid from the line that fits each best,
in the picture as it is and in the picture as an ideal lens would draw it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import NamedTuple

import numpy as np
import scipy
from numpy.typing import ArrayLike

from ...data import Camera, KinemarkError
from ...data.array_types import Bools, Floats
from ...data.method import Method, parameter
from ...geometry import undistort
from ...geometry.sphere_offset import sphere_offset
from ...numerics.robust import plane_scale
from .lens_choice import LensScore, lens_terms, score_lenses, simplest
from .plane_views import (
    POSE,
    SHARED,
    START_NOISE,
    STEPS,
    ZOOM,
    KnownOptics,
    PlaneFit,
    PlanePoints,
    fit_planes,
    known_of,
    normalised_residuals,
    seen_at,
    shared_covariance,
    shared_values,
    start_planes,
    zoomed,
)

FEWEST, FEWEST_OF_MANY = 15, 8  # points of a single view, and of each of several; chosen (see studies/linearisation.py)
MOST_KEPT = 0.7  # of the points that must remain; chosen (see studies/linearisation.py)
FOCAL_KNOWN = 0.05
"""Standard deviation of ln f up to which the focal length counts as known; chosen (see studies/linearisation.py)."""
IMPLAUSIBLE = (
    0.02  # of the images' spread; a residual beyond is no linearisation; chosen (see studies/linearisation.py)
)
ROUNDS = 10  # of leaving out outliers, at most; chosen (see studies/linearisation.py)
START_STEPS = 12  # tries from each start; chosen, as only the best one goes on (see studies/linearisation.py)


@dataclass(frozen=True, slots=True)
class Linearisation(Method):
    """A lens of Brown's model fitted to planes (Zhang 2000), its terms chosen by cross-validation."""

    radial: int | None = parameter(
        None, unit="lens terms", low=0, high=3,
        meaning="how many of k1, k2, k3 are fitted; None: as many as predict points left out best",
    )  # fmt: skip
    tangential: bool | None = parameter(
        None, meaning="p1 and p2 are fitted; None: if they predict points left out better"
    )
    reject: float = parameter(
        5.0, unit="standard deviations", low=3, high=math.inf,
        meaning="outliers: points so far off are left out; infinite keeps them all",
    )  # fmt: skip


class GridView(NamedTuple):
    """A picture of a plane grid.

    uv (N, 2) px, NaN where a point is not seen; xy (N, 2) mm on the plane; cov (N, 2, 2) px² of uv, right in
    proportion from view to view too, or None if all points are alike. Where one view states none, none counts.
    """

    uv: Floats
    xy: Floats
    cov: Floats | None = None


class LensFit(NamedTuple):
    """A lens and how well it is known.

    Attributes:
        camera: K, distortion, their covariance (rows of pose zero) and the residual, px RMS; R = I and t = 0 mean
            nothing.
        focal_known: whether the views determine the focal length; where not, K has the nominal one, without error.
        straightness: (before, after) RMS distance of grid points from straight lines, px; NaN without rows of three.
        scores: of all lens models tried; one without comparison if the method leaves no choice.
        views: the camera of each view as fitted, with R and t of the plane.
        kept: per view (N) which points took part.
        residual: per view (N, 2) px, NaN where not seen.
        coverage: share of the image within the outline of all points; NaN where its size is unknown. Beyond, the lens
            is extrapolated.
    """

    camera: Camera
    focal_known: bool
    straightness: tuple[float, float]
    scores: tuple[LensScore, ...]
    views: tuple[Camera, ...]
    kept: tuple[Bools, ...]
    residual: tuple[Floats, ...]
    coverage: float

    @property
    def radial(self) -> int:
        """How many of k1, k2, k3 the lens has."""
        return int((np.diag(self.camera.cov)[[4, 5, 8]] > 0).sum())

    @property
    def tangential(self) -> bool:
        """Whether the lens has p1 and p2."""
        return bool(self.camera.cov[6, 6] > 0)


def linearise(
    name: str,
    size: ArrayLike,
    views: Sequence[GridView],
    *,
    method: Linearisation | None = None,
    diameter: float | None = None,
) -> LensFit:
    """The lens of a camera with images of `size` (2) px, (0, 0) where unknown, from pictures of plane grids.

    Args:
        name: of the camera.
        size: (2) width and height, px.
        views: one or more, of the same grid or of different ones.
        method: what to fit.
        diameter: of the points where they are spheres with their centres in the plane, mm: their centroids are
            corrected for perspective.

    Raises:
        ValueError: there is no view, or the arrays of one do not fit each other.
        KinemarkError: too few points, points on a line, points that leave the middle of the image out, or that no
            lens of this kind sees so.
    """
    method, size = method or Linearisation(), np.asarray(size, np.int64).reshape(2)
    points = _points(name, views)
    models = _models(method, len(points.uv), len(views))
    if diameter is not None:
        largest = replace(method, radial=models[-1][0], tangential=models[-1][1])
        views = _centred(views, linearise(name, size, views, method=largest), diameter)
        points = _points(name, views)
    known = known_of(size, points.uv)
    lens = lens_terms(*models[-1])
    starts = [
        fit_planes(start, points, lens=lens, known=known, noise=START_NOISE, steps=START_STEPS)
        for start in start_planes(name, size, points, known)
    ]
    fit, kept = _without_outliers(_best(starts), points, known, method.reject, steps=START_STEPS)
    scores = score_lenses(models, fit, points.part(kept), known) if len(models) > 1 else []
    if scores:
        lens = lens_terms(*simplest(scores)[:2])
    fit = fit_planes(fit.planes, points.part(kept), lens=lens, known=known)
    fit, kept = _without_outliers(fit, points, known, method.reject)
    return _result(fit, views, points, kept, known, tuple(scores))


def straightness(uv: Floats, xy: Floats) -> float:
    """RMS distance, px, of points (N, 2) from the lines that fit the rows and columns of their grid xy (N, 2) best.

    A row or column has at least three points; without any the result is NaN.
    """
    seen = np.isfinite(uv).all(1)
    squares: list[Floats] = []
    for k in (0, 1):
        level = np.round(xy[:, k] / max(float(np.ptp(xy[:, k])), 1e-300), 6)
        for value in np.unique(level[seen]):
            line = uv[seen & (level == value)]
            if len(line) >= 3:
                across = np.linalg.svd(line - line.mean(0), full_matrices=False)[2][1]
                squares.append(((line - line.mean(0)) @ across) ** 2)
    return float(np.sqrt(np.concatenate(squares).mean())) if squares else float("nan")


def _centred(views: Sequence[GridView], found: LensFit, diameter: float) -> list[GridView]:
    """The views with what spheres' centroids lie beside their centres taken off."""
    centred = []
    for view, camera in zip(views, found.views, strict=True):
        xyz = np.column_stack([view.xy, np.zeros(len(view.xy))])
        centred.append(view._replace(uv=view.uv - sphere_offset(camera, xyz, diameter=diameter)))
    return centred


def _models(method: Linearisation, points: int, views: int) -> list[tuple[int, bool]]:
    """(radial, tangential) to choose from, the largest last: those with no more parameters than points."""
    radial = range(4) if method.radial is None else [method.radial]
    tangential = [False, True] if method.tangential is None else [method.tangential]
    models = list(product(radial, tangential))
    return [m for m in models if points >= 4 + lens_terms(*m).sum() + POSE * views] or models[:1]


def _points(name: str, views: Sequence[GridView]) -> PlanePoints:
    """The points that are seen, of all views."""
    if not views:
        raise ValueError("there is no view, wanted at least one")
    parts, weighted = [], all(_states_cov(view) for view in views)
    for v, view in enumerate(views):
        n = len(view.uv)
        shapes: dict[str, tuple[tuple[int, ...], tuple[int, ...]]] = {
            "uv": (view.uv.shape, (n, 2)),
            "xy": (view.xy.shape, (n, 2)),
        }
        if view.cov is not None:
            shapes["cov"] = (view.cov.shape, (n, 2, 2))
        for what, (have, want) in shapes.items():
            if have != want:
                raise ValueError(f"{what} of view {v + 1} has shape {have}, wanted {want}")
        rows, fewest = _seen(view), FEWEST if len(views) == 1 else FEWEST_OF_MANY
        _refuse_few_or_line(f"Camera {name}, view {v + 1}", view.uv[rows], view.xy[rows], fewest)
        xyz = np.column_stack([view.xy[rows], np.zeros(rows.sum())])
        parts.append(
            PlanePoints(np.full(rows.sum(), v), xyz, view.uv[rows], _whitening(view.cov if weighted else None, rows))
        )
    return PlanePoints(*(np.concatenate(part) for part in zip(*parts, strict=True)))


def _seen(view: GridView) -> Bools:
    return np.asarray(np.isfinite(view.uv).all(1) & np.isfinite(view.xy).all(1))


def _states_cov(view: GridView) -> bool:
    return view.cov is not None and view.cov.ndim == 3 and bool(np.isfinite(view.cov[_seen(view)]).all())


def _whitening(cov: Floats | None, rows: Bools) -> Floats:
    each = np.tile(np.eye(2), (rows.sum(), 1, 1)) if cov is None else cov[rows]
    return np.asarray(np.linalg.inv(np.linalg.cholesky(each)))


def _refuse_few_or_line(where: str, uv: Floats, xy: Floats, fewest: int) -> None:
    if len(uv) < fewest:
        raise KinemarkError(
            f"{where}: {len(uv)} points are seen, and a lens needs {fewest}. Use a grid with more points."
        )
    for points, what in ((xy, "on the grid"), (uv, "in the picture")):
        s = np.linalg.svd(points - points.mean(0), compute_uv=False)
        if s[1] < 1e-3 * s[0]:
            raise KinemarkError(f"{where}: all points lie on one line {what}. A lens needs points spread over a plane.")


def _best(fits: list[PlaneFit]) -> PlaneFit:
    fit = min(fits, key=lambda fit: fit.chi2)
    if not np.isfinite(fit.chi2):
        raise KinemarkError(
            f"Camera {fit.planes.camera.name}: no camera has the whole grid before it and sees it so. Check which "
            "point was taken for which."
        )
    return fit


def _without_outliers(
    fit: PlaneFit, points: PlanePoints, known: KnownOptics, reject: float, *, steps: int = STEPS
) -> tuple[PlaneFit, Bools]:
    """The fit to the points that agree with each other, and which (N) they are."""
    kept = np.ones(len(points.uv), np.bool_)
    for turn in range(ROUNDS):
        d = normalised_residuals(fit.planes, points)
        s = plane_scale(d[kept])  # (1)
        now = np.nan_to_num(d, nan=np.inf) <= reject * s + 1e-6
        if turn and (now == kept).all():
            break
        kept = now
        if (
            kept.mean() < MOST_KEPT
            or np.bincount(points.view[kept], minlength=len(fit.planes.t)).min() < FEWEST_OF_MANY
        ):
            raise KinemarkError(
                f"Camera {fit.planes.camera.name}: only {kept.sum()} of {len(kept)} grid points fit one lens. Check "
                "which point was taken for which, and that the grid is flat."
            )
        fit = fit_planes(fit.planes, points.part(kept), lens=fit.lens, known=known, steps=steps)
    return fit, kept


def _result(
    fit: PlaneFit,
    views: Sequence[GridView],
    points: PlanePoints,
    kept: Bools,
    known: KnownOptics,
    scores: tuple[LensScore, ...],
) -> LensFit:
    camera, focal_known = _camera(fit, points.part(kept), known)
    misfit = points.uv - seen_at(fit.planes, points)
    camera = replace(camera, residual=float(np.sqrt((misfit[kept] ** 2).sum(1).mean())))
    used = points.part(kept)
    if not camera.residual <= IMPLAUSIBLE * float(np.sqrt(used.uv.var(0).sum())):
        raise KinemarkError(
            f"Camera {camera.name}: the best lens misses the grid by {camera.residual:.1f} px RMS. Check which point "
            "was taken for which, and that the grid is flat."
        )
    coverage = _coverage(camera, used.uv, known)
    which, residual = [], []
    for v, view in enumerate(views):
        rows, here = _seen(view), points.view == v
        which.append(np.zeros(len(rows), np.bool_))
        residual.append(np.full((len(rows), 2), np.nan))
        which[v][rows], residual[v][rows] = kept[here], misfit[here]
    poses = [replace(fit.planes.camera, R=R, t=t) for R, t in zip(fit.planes.R, fit.planes.t, strict=True)]
    straight = _straight(camera, used)
    return LensFit(camera, focal_known, straight, scores, tuple(poses), tuple(which), tuple(residual), coverage)


def _camera(fit: PlaneFit, points: PlanePoints, known: KnownOptics) -> tuple[Camera, bool]:
    """The camera, the covariance of its steps turned into that of `data.PARAMETERS`."""
    cov9 = shared_covariance(fit, points, known)
    focal_known = bool(np.sqrt(cov9[0, 0]) <= FOCAL_KNOWN)
    epsilon = 0.0 if focal_known else float(np.log(known.nominal / fit.planes.camera.K[0, 0]))
    camera = zoomed(fit.planes, epsilon).camera
    values = shared_values(camera)
    turn = np.diag(np.exp(epsilon * ZOOM))
    turn[0, 0], turn[1, 1] = 0.0, values[1]
    turn[:, 0] = ZOOM * values if focal_known else 0.0
    cov = np.zeros((15, 15))
    cov[:SHARED, :SHARED] = turn @ cov9 @ turn.T
    return replace(camera, cov=cov), focal_known


def _coverage(camera: Camera, uv: Floats, known: KnownOptics) -> float:
    """Share of the image within the points' outline, which must hold the middle of image and lens."""
    outline = scipy.spatial.Delaunay(uv)
    for what, place in (("middle of the image", known.image_centre), ("centre of the lens", camera.K[:2, 2])):
        if outline.find_simplex(place) < 0:
            low, high = uv.min(0), uv.max(0)
            raise KinemarkError(
                f"Camera {camera.name}: the grid's points, u {low[0]:.0f} … {high[0]:.0f} px and v {low[1]:.0f} … "
                f"{high[1]:.0f} px, leave out the {what} at ({place[0]:.0f}, {place[1]:.0f}) px, and a lens seen on "
                "one side only is guessed on the other. Let the grid fill the image, in one picture or several."
            )
    area = float(camera.size.prod())
    return float(scipy.spatial.ConvexHull(uv).volume / area) if area else float("nan")


def _straight(camera: Camera, points: PlanePoints) -> tuple[float, float]:
    """Over all views: RMS of their straightness, before and after."""
    found = []
    for v in np.unique(points.view):
        p = points.part(points.view == v)
        before, after = (straightness(uv, p.xyz[:, :2]) for uv in (p.uv, undistort(camera, p.uv)))
        found.append((len(p.uv), before**2, after**2))
    n, before2, after2 = np.array(found).T
    lines = np.isfinite(before2)
    total = float(n[lines].sum()) or float("nan")
    return float(np.sqrt((n * before2)[lines].sum() / total)), float(np.sqrt((n * after2)[lines].sum() / total))
