"""Cameras from nothing but their image sizes: a first guess from which a bundle adjustment converges.

1. Fundamental matrices of all pairs, wrong points left out; lines straightened (`optics`).
2. For a pair with many common points, focal lengths and pose from a grid (`pairs`). A stick gives the scale.
3. Growth: the camera that sees most of the points so far is found from them (`resection`); then
   all cameras so far are adjusted together, with poses, focal lengths and k1 free, on some of the points, and the
   points that two of them now see are added (`robust_points`). A camera that sees no such points, but
   sticks together with one known camera, is placed by that pair alone.
4. A pair and grid cell that lead to a rig in which the points fit as well as they fit the fundamental matrices is
   taken at once; so is one that the beginnings of two pairs lead to; else the best of several.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ....data import Camera, KinemarkError
from ....data.array_types import Floats, Ints
from ....numerics.evenly import evenly
from ..misfit import Mirrored, NoBeginning
from ..parts import FreePoints, Part, all_points, complete, sticks_through, supported
from ..robust_adjustment import solve_robust
from ..robust_points import robust_points
from ..solver import BundleState, placed
from .rough_resection import equal_covariances, resected, rough_freedom
from .seeds import Seed, known_focus_seed, point_seeds, stick_seeds
from .unknown_optics import UnknownOptics
from .view_pairs import FEWEST_COMMON, Pair, common_points, find_pairs, weakest_link

BODIES = 120  # bodies of a rough adjustment at most; chosen for speed
PAIRS = 6  # pairs of cameras that beginnings are taken from; chosen (see benchmarks/bundle.py)
SEEDS = 8  # beginnings that are tried at most; chosen; seen by `benchmarks/bundle.py start`
AMPLE = 150  # points in common that are enough for a first guess; chosen for speed
FEWEST_KNOWN = 12  # known points that a new camera must see; chosen: twice the six of a DLT (see benchmarks/bundle.py)
GOOD = 2.0  # times the noise of two cameras alone, within which a start is taken at once; chosen
BLAMED = 3  # pairs whose points one camera sees mirrored: it is the wrong one; chosen: a pair with it blames any other
SAME = 0.01  # of the residuals by which those of one rig from the beginnings of two pairs differ; chosen
BENT = 0.02
"""Of the image's diagonal; no right point is further off in the first guess; chosen (see benchmarks/bundle.py)."""
LONGER = 0.2  # a stick whose length is more than this share off has a wrong end; chosen (see benchmarks/bundle.py)


class TargetViews(NamedTuple):
    """What the cameras see: optics (C); uv (C, N, 2) px; along (K) mm of a stick, or None for single points."""

    optics: list[UnknownOptics]
    uv: Floats
    along: Floats | None

    @property
    def markers(self) -> int:
        """How many there are to a body."""
        return 1 if self.along is None else len(self.along)

    @property
    def poses(self) -> Floats:
        """uv (C, F, K, 2)."""
        return self.uv.reshape(len(self.uv), -1, self.markers, 2)


class Start(NamedTuple):
    """A first guess of all cameras (C), and the scale of its residuals, px."""

    cameras: tuple[Camera, ...]
    scale: float


def start(views: TargetViews, *, seed: int = 0, focal_known: bool = False) -> tuple[BundleState, float]:
    """Cameras and points near enough to the truth for a bundle adjustment, and how well two cameras fit alone, px.

    Raises:
        KinemarkError: cameras do not share enough views, all points lie in a plane, or nothing fits.
    """
    check_connected(views)
    whole, views = views, thinned(views)
    optics, pairs = find_pairs(views.optics, views.uv, seed=seed)
    views = views._replace(optics=optics)
    best = best_start(views, pairs, focal_known=focal_known)
    return BundleState(best.cameras, (_part(whole, dict(enumerate(best.cameras))),)), noise_of(pairs)


def best_start(views: TargetViews, pairs: list[Pair], *, focal_known: bool = False, tries: int = SEEDS) -> Start:
    """Step 4, by the pairs of cameras whose lines are straightened, from so many beginnings at most.

    Raises:
        Mirrored: by `BLAMED` pairs, and none fits.
        NoBeginning: nothing fits.
    """
    best: tuple[Start, Pair] | None = None
    blamed: dict[str, set[tuple[int, int]]] = {}  # camera: by which pairs
    trouble = NoBeginning(
        "No focal lengths make sense of what any two cameras see. Check that points of one place have one index in all "
        "cameras and, for a stick, that its lengths are right and its ends are not mixed up. Cameras that face each "
        "other tell least: linearise them first, add a camera, or move one aside."
    )
    for guess in _beginnings(views, pairs, focal_known)[:tries]:
        try:
            found = grow(views, guess, pairs)
        except NoBeginning as error:
            trouble = error
            if isinstance(error, Mirrored) and error.camera and not best:
                blamed.setdefault(error.camera, set()).add((guess.pair.a, guess.pair.b))
                if len(blamed[error.camera]) == BLAMED:
                    raise
            continue
        again = best and best[1] is not guess.pair and abs(found.scale / best[0].scale - 1) < SAME
        best = (found, guess.pair) if best is None or found.scale < best[0].scale else best
        if again or best[0].scale <= GOOD * noise_of(pairs):
            break
    if best is None:
        raise trouble
    return best[0]


def noise_of(pairs: list[Pair]) -> float:
    """How well two cameras fit alone, px."""
    return float(np.median([pair.scale for pair in pairs]))


def thinned(views: TargetViews) -> TargetViews:
    """Every so many-th body, as few as let all cameras hang together by `AMPLE` points that two have in common."""
    uv = views.poses
    for step in range(uv.shape[1] // AMPLE, 1, -1):
        some = uv[:, ::step].reshape(len(uv), -1, 2)
        if weakest_link(common_points(some)).shared >= AMPLE:
            return views._replace(uv=some)
    return views


def check_connected(views: TargetViews) -> None:
    """Raises a KinemarkError that names cameras which do not see enough together with the others."""
    common = common_points(views.uv)
    names = [o.camera.name for o in views.optics]
    what, per = ("places", 1) if views.along is None else ("poses", views.markers)
    linked = {int(common.diagonal().argmax())}
    while len(linked) < len(names):
        rest = [c for c in range(len(names)) if c not in linked]
        table = common[np.ix_(sorted(linked), rest)]
        a, b = np.unravel_index(table.argmax(), table.shape)
        if table[a, b] < FEWEST_COMMON:
            raise KinemarkError(
                f"Camera{'s' if len(rest) > 1 else ''} {', '.join(names[c] for c in rest)} cannot be joined to the "
                f"others: {names[rest[b]]} and {names[sorted(linked)[a]]} have {table[a, b] // per} {what} in common, "
                f"the most of all, and {-(-FEWEST_COMMON // per)} are needed. Wave where these cameras see it together "
                "with the others, or leave them out."
            )
        linked.add(rest[b])


def _beginnings(views: TargetViews, pairs: list[Pair], focal_known: bool) -> list[Seed]:
    """Beginnings, the most promising first."""
    found: list[Seed] = []
    for pair in pairs[:PAIRS]:
        if focal_known:
            found.append(known_focus_seed(views.optics, pair, views.uv))
        elif views.along is None:
            found += point_seeds(views.optics, pair, views.uv)
        else:
            found += stick_seeds(views.optics, pair, views.poses, views.along)
    return sorted(found, key=lambda s: s.score)


def grow(views: TargetViews, guess: Seed, pairs: list[Pair]) -> Start:
    """All cameras from a beginning, one after the other (step 3).

    Raises:
        KinemarkError: a camera sees too few of the points that the others know.
    """
    cameras, scale = _two(views, guess), float("nan")
    if views.along is not None or len(views.optics) == 2:  # two cameras tell f1 and f2 from a stick, not from points
        cameras, scale = _adjusted(views, cameras, focus_held=views.along is None)
    while len(cameras) < len(views.optics):
        cameras |= _next_camera(views, cameras) or _by_pair(views, cameras, pairs)
        cameras, scale = _adjusted(views, cameras)
    return Start(tuple(cameras[c] for c in range(len(cameras))), scale)


def _two(views: TargetViews, guess: Seed) -> dict[int, Camera]:
    """The pair's cameras in the first one's frame."""
    a, b = guess.pair.a, guess.pair.b
    return {
        a: views.optics[a].with_focus(guess.f[0], np.eye(3), np.zeros(3)),
        b: views.optics[b].with_focus(guess.f[1], guess.R, guess.t),
    }


def _adjusted(
    views: TargetViews, cameras: dict[int, Camera], *, focus_held: bool = False
) -> tuple[dict[int, Camera], float]:
    """The cameras so far, adjusted together on some of the bodies, and the scale of residuals."""
    order = sorted(cameras)
    part = _part(views, cameras)
    rows = _some_bodies(part, views.uv[order])
    points = (rows[:, None] * views.markers + np.arange(views.markers)).ravel()
    freedoms = tuple(rough_freedom(views.optics[c], focus_held=focus_held) for c in order)
    state = BundleState(tuple(cameras[c] for c in order), (part.take(rows),))
    state, scale = solve_robust(state, equal_covariances(views.uv[order][:, points]), freedoms)
    return dict(zip(order, state.cameras, strict=True)), scale


def _part(views: TargetViews, cameras: dict[int, Camera]) -> Part:
    """What the cameras see, as bodies; sticks whose length is far off are not known."""
    order = sorted(cameras)
    known = [cameras[c] for c in order]
    limit = [BENT * np.hypot(*camera.size) for camera in known]
    xyz = robust_points(known, views.uv[order], limit=limit)
    if views.along is None:
        return FreePoints(xyz)
    markers = xyz.reshape(-1, views.markers, 3)
    sticks = sticks_through(markers, views.along)
    distance = np.linalg.norm(sticks.xyz - markers, axis=-1)
    wrong = ~(np.where(np.isnan(distance), 0.0, distance).max(1) <= LONGER * np.ptp(views.along))
    return type(sticks)(np.where(wrong[:, None], np.nan, sticks.centre), sticks.direction, sticks.along)


def _some_bodies(part: Part, uv: Floats) -> Ints:
    """At most `BODIES` of those that are supported, evenly."""
    n, K = part.xyz.shape[:2]
    good = np.flatnonzero(supported((part,), complete(uv)).any(0).reshape(n, K).any(1))
    if len(good) < FEWEST_KNOWN // 2:
        raise NoBeginning(
            f"Only {len(good)} of {n} poses or places are seen whole by two cameras and fit each other. Wave longer, "
            "where the cameras look, and check the lengths and the order of the markers, that all recordings begin at "
            "the same moment, and that no camera's images are mirrored or another's: leave out one camera after "
            "the other."
        )
    return good[evenly(len(good), BODIES)]


def _next_camera(views: TargetViews, cameras: dict[int, Camera]) -> dict[int, Camera]:
    """The camera that sees most of the points that are known, placed by them; none where they are too few."""
    xyz = all_points((_part(views, cameras),))
    seen = {c: complete(xyz) & complete(views.uv[c]) for c in range(len(views.uv)) if c not in cameras}
    c = max(seen, key=lambda i: int(seen[i].sum()))
    if seen[c].sum() < FEWEST_KNOWN:
        return {}
    return {c: resected(views.optics[c], xyz[seen[c]], views.uv[c, seen[c]])}


def _by_pair(views: TargetViews, cameras: dict[int, Camera], pairs: list[Pair]) -> dict[int, Camera]:
    """A camera that shares sticks with a known one only, by their pair alone.

    Raises:
        KinemarkError: there is none.
    """
    for pair in pairs:
        if views.along is None or (pair.a in cameras) == (pair.b in cameras):
            continue
        if (two := _adjusted_pair(views, pair)) is not None:
            known, new = (pair.a, pair.b) if pair.a in cameras else (pair.b, pair.a)
            R = cameras[known].R.T @ two[known].R  # the pair's world → this one
            t = cameras[known].R.T @ (two[known].t - cameras[known].t)
            return {new: placed(two[new], R, t)}
    missing = [o.camera.name for c, o in enumerate(views.optics) if c not in cameras]
    raise NoBeginning(
        f"Camera{'s' if len(missing) > 1 else ''} {', '.join(missing)}: fewer than {FEWEST_KNOWN} points are seen by "
        "it and by two other cameras at the same time. Wave where three cameras see it together, or leave it out."
    )


def _adjusted_pair(views: TargetViews, pair: Pair) -> dict[int, Camera] | None:
    """The two cameras of a pair by the beginning from which they fit best; None where none leads anywhere."""
    assert views.along is not None
    found: list[tuple[dict[int, Camera], float]] = []
    for guess in stick_seeds(views.optics, pair, views.poses, views.along):
        try:
            found.append(_adjusted(views, _two(views, guess)))
        except NoBeginning:
            continue
        if found[-1][1] <= GOOD * pair.scale:
            break
    return min(found, key=lambda each: each[1])[0] if found else None
