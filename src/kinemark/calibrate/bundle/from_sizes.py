"""A rig from pixels and image sizes alone: of a stick with markers in a row, or of a single marker waved about.

1. `initial`: a first guess of all cameras, with focal length and one lens term.
2. The bundle adjustment with all that the method fits free (`adjust`).
3. The world becomes the first camera's, and what is no calibration is refused.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from ...data import Camera, KinemarkError, Rig
from ...data.array_types import Bools, Floats
from ..stage import CALIBRATE
from .adjust import Bundle, BundleFit, adjusted, check_calibration, completed, observed
from .camera_step import camera_step
from .initial import TargetViews, start
from .initial.growth import BENT
from .initial.odd_camera import odd_camera
from .initial.unknown_optics import UnknownOptics, unknown_optics
from .misfit import Misfit, NoBeginning
from .one_side import from_one_side, uncertain
from .parts import Sticks, all_points, complete
from .solver import BundleState, Freedom, placed, residuals
from .stick_gaps import seen_places

BASE = 1000.0  # mm between the first two cameras where nothing has a length; a convention
WORSE = 3.0  # right calibrations, of real files too, have at most 1.5 times the residual of two cameras alone; chosen
FINE = 0.3  # px of residual, below which no camera is suspected; chosen (see benchmarks/bundle.py)
OTHER_ORDER = 0.5
"""Of the images; a projection keeps the order, but for wrong points and sticks seen end on; chosen (see
benchmarks/bundle.py)."""
ROUGH = 0.002
"""Of a stick's length; how well cameras of the first guess tell its gaps; chosen (see benchmarks/bundle.py)."""
HOPELESS = 0.7
"""Share of a camera's points that lie more than `growth.BENT` beside in the first guess; chosen: of a camera that was
moved meanwhile a half fits, and of another one's images a fifth at most."""
FINAL = 0.0002
"""The same of adjusted cameras, whose centroids may all be off alike; chosen (see benchmarks/bundle.py)."""


def calibrate_sticks(
    names: Sequence[str],
    sizes: ArrayLike,
    uv: Floats,
    *,
    along: ArrayLike,
    cov: Floats | None = None,
    method: Bundle | None = None,
    lenses: Sequence[Camera] | None = None,
) -> BundleFit:
    """A rig from F poses of a stick with K markers in a row, in the frame of its first camera, mm.

    Where the images show other gaps between three markers or more than stated, theirs are taken, and the whole length
    as stated (`stick_gaps`): `stick_gaps.places_of(fit.xyz.reshape(F, K, 3))` are the places that were fitted.

    Args:
        names: (C).
        sizes: (C, 2) width and height of the images, px.
        uv: (C, F, K, 2) px; NaN where not seen.
        along: (K) where the markers are along the stick, mm.
        cov: (C, F, K, 2, 2) px², right in proportion; without it, or with NaN in it, all points count alike.
        method: what to fit.
        lenses: (C) cameras of a linearisation; centre, pixel shape and lens are theirs and kept in pixels.

    Raises:
        ValueError: the arrays do not fit each other.
        KinemarkError: a camera shares too few poses with the others, the poses lie in a plane or tell too little
            about a focal length, or they do not fit together.
    """
    along = np.asarray(along, np.float64).ravel()
    if len(along) < 2 or len(np.unique(along)) < len(along) or not np.isfinite(along).all():
        raise ValueError(f"along is {along.tolist()}, wanted at least two different places, mm")
    if uv.ndim != 4 or uv.shape[2:] != (len(along), 2):
        raise ValueError(f"uv has shape {uv.shape}, wanted (cameras, poses, {len(along)}, 2)")
    flat = uv.reshape(len(uv), -1, 2)
    flat_cov = None if cov is None else cov.reshape(len(uv), -1, 2, 2)
    return _calibrated(names, sizes, flat, along, flat_cov, method or Bundle(), lenses)


@CALIBRATE.method("bundle", Bundle, source="Triggs et al. 2000", ways=("single_marker",))
def calibrate_points(
    names: Sequence[str],
    sizes: ArrayLike,
    uv: Floats,
    *,
    cov: Floats | None = None,
    method: Bundle | None = None,
    lenses: Sequence[Camera] | None = None,
) -> BundleFit:
    """A rig, up to scale, from N places of one marker waved about.

    The world is the first camera's frame, in units of which the first two cameras are 1000 apart; any known distance
    gives the scale (`world.scaled`). Two cameras alone need `lenses`, whose focal lengths are then held.

    Args:
        names: (C).
        sizes: (C, 2) width and height of the images, px.
        uv: (C, N, 2) px, in order of time, as images before a camera was moved are left out; NaN where not seen.
        cov: (C, N, 2, 2) px², right in proportion; without it, or with NaN in it, all points count alike.
        method: what to fit.
        lenses: (C) as in `calibrate_sticks`.

    Raises:
        ValueError: the arrays do not fit each other.
        KinemarkError: as in `calibrate_sticks`.
    """
    if uv.ndim != 3 or uv.shape[2] != 2:
        raise ValueError(f"uv has shape {uv.shape}, wanted (cameras, places, 2)")

    def fitted(images: Bools) -> BundleFit:
        seen = np.where(images[..., None], uv, np.nan)
        fit = _calibrated(names, sizes, seen, None, cov, method or Bundle(), lenses)
        return fit._replace(step=camera_step(fit.rig, seen[:, :, None]))

    fit = fitted(np.ones(uv.shape[:2], np.bool_))
    if (step := fit.step) is None:
        return fit
    return from_one_side(step, names, uv.shape[1], fitted) or uncertain(fit, step)


def _calibrated(
    names: Sequence[str],
    sizes: ArrayLike,
    uv: Floats,
    along: Floats | None,
    cov: Floats | None,
    method: Bundle,
    lenses: Sequence[Camera] | None,
) -> BundleFit:
    """`calibrate_sticks` or, where `along` is None, `calibrate_points`, of pixels (C, N, 2)."""
    optics = _optics(names, sizes, len(uv), lenses, method.aspect or 1.0)
    held = along is None and len(uv) == 2
    if len(uv) < 2 or (held and lenses is None):
        raise KinemarkError(
            f"{len(uv)} camera{'s see' if len(uv) > 1 else ' sees'} the {'marker' if along is None else 'stick'}; "
            f"{'three' if along is None else 'two'} are needed to calibrate from image sizes alone. "
            "Use more cameras, or control points."
        )
    if along is not None and len(along) > 2:
        _check_order(uv, along)
    first, noise = start(TargetViews(optics, uv, along), seed=method.seed, focal_known=held)
    if along is not None and len(along) > 2:
        places = seen_places(first.cameras, uv, along, least=ROUGH)
        if places is not along:
            first, noise = start(TargetViews(optics, uv, places), seed=method.seed, focal_known=held)
    _check_beginning(first, uv)
    seen = observed(uv, cov)
    freedoms = tuple(_freedom(o, method, held) for o in optics)
    if lenses is None and method.radial == 0:  # the first guess has k1
        first = first._replace(cameras=tuple(replace(camera, distortion=np.zeros(5)) for camera in first.cameras))
    found = adjusted(first, seen, freedoms, reject=method.reject)
    if (regapped := _with_seen_gaps(found.state, uv)) is not found.state:
        found = adjusted(regapped, seen, freedoms, reject=method.reject)
    found = found._replace(state=_in_place(found.state, along is None))
    what = "bundle adjustment of " + ("single points" if along is None else "sticks")
    fit = completed(found, seen, what=what)
    frame = np.arange(uv.shape[1]) // (1 if along is None else len(along))
    check_calibration(fit, seen.used, frame, focus_held=held)
    _check_found(fit.rig, noise)
    return fit


def odd_one(
    names: Sequence[str],
    sizes: ArrayLike,
    uv: Floats,
    *,
    along: Floats,
    method: Bundle,
    lenses: Sequence[Camera] | None = None,
) -> str | None:
    """The camera without which the others fit each other, as in `calibrate_sticks`; None where there is no such one."""
    optics = _optics(names, sizes, len(uv), lenses, method.aspect or 1.0)
    return odd_camera(TargetViews(optics, uv.reshape(len(uv), -1, 2), along), seed=method.seed)


def _optics(
    names: Sequence[str], sizes: ArrayLike, c: int, lenses: Sequence[Camera] | None, aspect: float
) -> list[UnknownOptics]:
    size = np.asarray(sizes, np.int64).reshape(-1, 2)
    if not len(names) == len(size) == c or (lenses is not None and len(lenses) != c):
        raise ValueError(f"{len(names)} names, {len(size)} sizes, pixels of {c} cameras: wanted as many of each")
    if (size < 1).any():
        raise ValueError(f"sizes are {size.tolist()}, wanted width and height of every image, px")
    if lenses is None:
        return [unknown_optics(name, s, aspect) for name, s in zip(names, size, strict=True)]
    return [
        UnknownOptics(replace(lens, name=name, size=s, R=np.eye(3), t=np.zeros(3)), 0.0, True)
        for name, s, lens in zip(names, size, lenses, strict=True)
    ]


def _freedom(optics: UnknownOptics, method: Bundle, focus_held: bool) -> Freedom:
    """All that the method fits, or pose and focal length with the lens in pixels."""
    if not optics.lens:
        return method.freedom
    free = np.zeros(15, np.bool_)
    free[[0, 1]] = not focus_held
    free[9:15] = True
    return Freedom(free, True, True)


def _in_place(state: BundleState, unscaled: bool) -> BundleState:
    """The state in the first camera's frame; without a scale, with `BASE` between the first two cameras."""
    R, t = state.cameras[0].R, state.cameras[0].t
    base = float(np.linalg.norm(state.cameras[1].centre - state.cameras[0].centre))
    scale = BASE / base if unscaled else 1.0
    cameras = [placed(camera, R, scale * t, scale) for camera in state.cameras]
    cameras[0] = replace(cameras[0], R=np.eye(3), t=np.zeros(3))
    return BundleState(tuple(cameras), tuple(part.placed(R, scale * t, scale) for part in state.parts))


def _check_order(uv: Floats, along: Floats) -> None:
    """Most images (C, N, 2) show the stick's markers in their order, from one end or the other."""
    views = uv.reshape(-1, len(along), 2)[:, np.argsort(along)]
    views = views[complete(views).all(1)]
    place = ((views - views[:, :1]) * (views[:, -1:] - views[:, :1])).sum(-1)
    other = 1 - (np.diff(place, axis=1) > 0).all(1).mean() if len(views) else 0.0
    if other > OTHER_ORDER:
        raise KinemarkError(
            f"In {other:.0%} of its images the stick's markers do not lie in the order of their places, "
            f"{', '.join(f'{mm:g}' for mm in along)} mm. Check which marker is which, and give them in order."
        )


def _with_seen_gaps(state: BundleState, uv: Floats) -> BundleState:
    """The state with the sticks' gaps as its cameras see them at uv (C, N, 2), or the state itself."""
    (part,) = state.parts
    if not isinstance(part, Sticks) or len(part.along) < 3:
        return state
    places = seen_places(state.cameras, uv, part.along, least=FINAL)
    return state if places is part.along else state._replace(parts=(replace(part, along=places),))


def _check_beginning(first: BundleState, uv: Floats) -> None:
    """Raises a NoBeginning where a camera of the first guess has next to nothing to do with what is seen (C, N, 2)."""
    seen = complete(uv) & complete(all_points(first.parts))
    for camera, mine, off in zip(first.cameras, seen, residuals(first, uv), strict=True):
        near = np.linalg.norm(off[mine], axis=1) <= BENT * np.hypot(*camera.size)  # not those behind it
        if len(near) and (beside := 1 - near.mean()) > HOPELESS:
            raise NoBeginning(
                f"Camera {camera.name} does not fit the others: {beside:.0%} of its points lie beside where the others "
                "see them. Check that it is synchronous and did not move, and that its images are neither mirrored nor "
                "another camera's; or leave it out.",
                camera.name,
            )


def _check_found(rig: Rig, noise: float) -> None:
    """Raises a KinemarkError where all cameras fit much worse than any two of them do alone, to `noise` px."""
    largest = max(rig, key=lambda camera: camera.residual)
    if largest.residual > max(WORSE * noise, FINE):
        raise Misfit(
            f"Two cameras fit each other within {noise:.2f} px, but all together leave {largest.residual:.2f} px in "
            f"camera {largest.name}: these are not the cameras. Wave through the whole volume, in depth too, and check "
            "the lengths; a lens that bends lines strongly needs more lens terms, or a linearisation; pixels that are "
            "not square need square_pixels = false in [calibrate].",
            largest.name,
        )
