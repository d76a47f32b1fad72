"""Cameras from a wand waved through the volume, from what they see of it alone.

1. Which detection is which marker, without a rig (`identify`); of gaps nearly alike from both ends, with one from the
   ends alone (`direction`).
2. A first rig from some poses, spread over the images, by bundle adjustment from the image sizes (`bundle`).
3. With it, markers that the first reading had to leave out (`completion`), and the offset between the centroid of
   a sphere's image and the projection of its centre (`geometry.sphere_offset`), where the spheres' diameter is known.
4. The rig from these, by bundle adjustment that goes on from the first.
5. If cameras took their images later than others, all of it again with what they saw moved in time (`film_delays`),
   and if one lost images in the course of the film, with the others put in their frames (`whole_film`).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import chain
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ...data import PARAMETERS, Camera, Detections, Rig
from ...data.array_types import Bools, Floats, Ints
from ...data.method import ONE, Method, parameter
from ...geometry.sphere_offset import sphere_offset
from ..bundle import Bundle, BundleFit, Freedom, bundle, calibrate_sticks, sticks_through
from ..bundle.adjust import check_calibration
from ..bundle.camera_step import CameraStep, camera_step
from ..bundle.from_sizes import odd_one
from ..bundle.misfit import Mirrored, Misfit, NoBeginning
from ..bundle.parts import complete
from ..bundle.solver import placed
from ..bundle.stick_gaps import places_of
from ..stage import CALIBRATE
from .completion import completed
from .direction import from_other_end, looks_alike
from .few_poses import first_poses, shared_frames, thinned
from .film_delays import InTime, WandFit, with_delays
from .identify import (
    FEWEST,
    Wanted,
    at_rows,
    identify_wand,
    marker_places,
    read_wand,
    wanted,
    with_open_ends,
    wrong_gaps,
)
from .moved_camera import THIRDS, rigs_of_parts, since_step, step_words, without_move
from .whole_film import with_lost_images

KNOWN_LENS = Freedom(np.isin(PARAMETERS, ("fx", "fy", "rx", "ry", "rz", "tx", "ty", "tz")), True, True)
WITNESSES = 4  # cameras by which another is judged to have been moved, at most; chosen for speed
AGREEING = 0.5  # of the frames that seem to show the wand; chosen (see benchmarks/bundle.py)
SAME_MM = 1e-6  # gaps that differ by less are the same but for rounding; chosen


@dataclass(frozen=True, slots=True)
class Wand(Method):
    """All cameras from a wand waved through the volume, by bundle adjustment."""

    radial: int = parameter(
        2, unit="lens terms", low=0, high=3, meaning="at most so many radial lens terms are fitted: k1, k2, k3"
    )
    tangential: bool = parameter(False, meaning="p1 and p2 are fitted as well")
    principal_point: bool = parameter(
        True, meaning="the principal point is fitted; else it stays in the image's centre, or the lens's"
    )
    square_pixels: bool = parameter(True, meaning="pixels have the shape that aspect says; else it is fitted")
    aspect: float | None = parameter(
        None, unit=ONE, low=0.1, high=10,
        meaning="height of a round marker's image by its width, fy / fx, where no lens is known; None: 0.5 for a "
        "session's interlaced video, else 1",
    )  # fmt: skip
    usual_lens: bool = parameter(
        True, meaning="lens terms that are not fitted, and the pixels' shape, may differ from what is taken as much as "
        "is usual of lenses; else, and where no lens term is fitted, they are exact",
    )  # fmt: skip
    reject: float = parameter(
        5.0, unit="standard deviations", low=3, high=math.inf, meaning="outliers: points so far off are left out"
    )
    search_radius: float = parameter(
        3.0, unit="px", above=0, meaning="how near to its place a marker is looked for once there is a first rig"
    )
    most_poses: int = parameter(
        1500, unit="poses", low=FEWEST, meaning="at most so many poses are used, spread over the images"
    )
    marker_diameter: float | None = parameter(
        None, unit="mm", above=0, meaning="diameter of the spheres; None leaves centroids as they are"
    )
    seed: int = parameter(0, unit=ONE, meaning="of the random samples that the bundle's start draws")

    @property
    def bundle(self) -> Bundle:
        """What the bundle adjustment fits."""
        return Bundle(
            radial=self.radial, tangential=self.tangential, principal_point=self.principal_point,
            square_pixels=self.square_pixels, aspect=self.aspect, usual_lens=self.usual_lens, reject=self.reject,
            seed=self.seed,
        )  # fmt: skip


@CALIBRATE.method("wand", Wand, ways=("wand",))
def calibrate_wand(
    detections: Detections,
    *,
    lengths: ArrayLike,
    sizes: ArrayLike,
    method: Wand | None = None,
    lenses: Sequence[Camera] | None = None,
) -> BundleFit:
    """The rig of C cameras that saw a wand over F frames.

    Args:
        detections: of all cameras. Those that took their images later than others are found out.
        lengths: (K − 1) gaps between the wand's K markers, mm; K is 2 to 5.
        sizes: (C, 2) width and height of the images, px.
        method: what to fit.
        lenses: (C) cameras of a linearisation, if there is one.

    Returns:
        The fit; N = F K points, NaN in frames that took no part. The world is the first camera's: see
        `world.moved_to`.

    Raises:
        ValueError: lengths or sizes are not as above.
        KinemarkError: as `points` and `calibrate_sticks`, or the cameras do not agree on the wand.
    """
    method = method or Wand()
    along = marker_places(lengths)
    sizes = np.asarray(sizes, np.int64)
    if sizes.shape != (len(detections.cameras), 2):
        raise ValueError(f"sizes has shape {sizes.shape}, wanted ({len(detections.cameras)}, 2)")
    given = (along, sizes, method, lenses)
    calibrated = partial(_synchronous, along=along, sizes=sizes, method=method, lenses=lenses)
    one_side = partial(with_delays, along=along, calibrated=calibrated, pairs=False)
    in_time = np.zeros(len(sizes))

    def again(whole: Detections) -> BundleFit:
        return without_move(with_delays(whole, along, calibrated), whole, one_side)

    try:
        found = with_delays(detections, along, calibrated)
    except Misfit as error:
        cause = _explained(error, detections, *given)
        if fit := with_lost_images(detections, along, in_time, cause.parts, again):
            return fit
        if cause.step and (moved := since_step(cause.step, detections, one_side)):
            return moved
        raise cause.error from error
    rigs = chain((found.fit.rig,), _parts_to_ask(found, detections, *given))
    if fit := with_lost_images(detections, along, found.fit.delay, rigs, again):
        return fit
    return without_move(found, detections, one_side)


def _parts_to_ask(
    found: InTime,
    detections: Detections,
    along: Floats,
    sizes: Ints,
    method: Wand,
    lenses: Sequence[Camera] | None,
) -> Iterator[Rig]:
    """Rigs of parts of the film, where that of all of it may have pleased two cameras that do not fit each other."""
    if (len(sizes) == 2 or found.step) and not np.rint(found.fit.delay).any():
        rows = identify_wand(detections, wanted(detections), along)
        first = partial(_first_cameras, detections, sizes=sizes, along=along, method=method, lenses=lenses)
        yield from rigs_of_parts(detections, rows, first)


def _synchronous(
    detections: Detections,
    known: BundleFit | None = None,
    *,
    along: Floats,
    sizes: Ints,
    method: Wand,
    lenses: Sequence[Camera] | None,
) -> WandFit:
    """The rig of cameras that took their images at the same moments, from a wand with markers `along` (K) mm, and from
    a rig that is nearly right where one is `known`."""
    want = wanted(detections)
    cameras = known.rig.cameras if known else None
    rows = identify_wand(detections, want, along, cameras)
    if looks_alike(along):
        if cameras is None:
            cameras = _first_rig(detections, rows[..., [0, -1]], sizes, along[[0, -1]], method, lenses)[0].cameras
        turned = from_other_end(cameras, at_rows(detections, rows)[0], along)
        rows = np.where(turned[:, None], rows[..., ::-1], rows)
    first = _rig_of(known, len(along)) if known else _first_rig(detections, rows, sizes, along, method, lenses)
    fit, chosen = _calibrated(detections, want, rows, sizes, *first, method, lenses is not None)
    fit = fit._replace(step=_step(fit.rig, detections, rows, read_wand(detections, want, along).rows))
    there = fit.xyz[np.isfinite(fit.xyz).all(1)]
    volume = np.stack([there.min(0), there.max(0)])
    words = _words(detections, want, chosen, fit, np.diff(along))
    return WandFit(fit._replace(rig=Rig(fit.rig.cameras, words, volume)), chosen)


def _step(rig: Rig, detections: Detections, rows: Ints, read: Ints) -> CameraStep | None:
    """A move by rows (C, F, K), and by those that were `read` whose ends nothing tells."""
    return camera_step(rig, at_rows(detections, with_open_ends(rows, read, detections, rig.cameras))[0])


def _calibrated(
    detections: Detections,
    want: Wanted,
    rows: Ints,
    sizes: Ints,
    first: Rig,
    along: Floats,
    method: Wand,
    lens_known: bool,
) -> tuple[BundleFit, Ints]:
    """Steps 3 and 4 from a first reading and rig: the fit, and the rows (C, F, K) that it was made from."""
    shared = int(shared_frames(rows).sum())
    rows, xyz = completed(first, detections, want.use, rows, along, search_radius=method.search_radius)
    _check_agreement(detections, rows, shared)
    chosen = thinned(detections, rows, sizes, method.most_poses)
    return _final_fit(first, detections, chosen, xyz, along, method, lens_known), chosen


def _first_rig(
    detections: Detections,
    rows: Ints,
    sizes: Ints,
    along: Floats,
    method: Wand,
    lenses: Sequence[Camera] | None,
    few: Ints | None = None,
) -> tuple[Rig, Floats]:
    """The cameras, or a few of them, and where the markers are along the wand by them (K) mm."""
    few = np.arange(len(sizes)) if few is None else few
    rows, sizes, names = rows[few], sizes[few], [detections.cameras[c] for c in few]
    lenses = lenses and [lenses[c] for c in few]
    uv, cov = at_rows(detections, first_poses(detections, rows, sizes))
    plain = replace(method.bundle, usual_lens=False)  # else the final fit would be told of its lens what these tell
    return _rig_of(calibrate_sticks(names, sizes, uv, along=along, cov=cov, method=plain, lenses=lenses), len(along))


def _first_cameras(detections: Detections, rows: Ints, **given: Any) -> Rig:
    """The cameras of `_first_rig`."""
    return _first_rig(detections, rows, **given)[0]


def _rig_of(fit: BundleFit, K: int) -> tuple[Rig, Floats]:
    """The cameras, and where K markers are along the wand by them, mm."""
    return fit.rig, places_of(fit.xyz.reshape(-1, K, 3))


def _final_fit(
    first: Rig, detections: Detections, rows: Ints, xyz: Floats, along: Floats, method: Wand, lens_known: bool
) -> BundleFit:
    """Step 4, from a first rig and the wand (F, K, 3) as it sees it; NaN in frames without rows (C, F, K)."""
    frames = np.flatnonzero((rows >= 0).any((0, 2)))
    uv, cov = (x.reshape(len(first), -1, *x.shape[3:]) for x in at_rows(detections, rows[:, frames]))
    if method.marker_diameter is not None:
        points = xyz[frames].reshape(-1, 3)
        uv = uv - np.stack([sphere_offset(camera, points, diameter=method.marker_diameter) for camera in first])
    freedom = KNOWN_LENS if lens_known else method.bundle.freedom
    fit = bundle(
        first,
        (sticks_through(xyz[frames], along),),
        uv,
        cov=cov,
        freedoms=[freedom] * len(first),
        method=method.bundle,
    )
    check_calibration(fit, complete(uv), np.repeat(frames, len(along)))
    return _among_frames(fit, frames, rows.shape[1], len(along))


def _among_frames(fit: BundleFit, frames: Ints, n_frames: int, K: int) -> BundleFit:
    """The fit to some frames as one of all F, with N = F K points, in the frame of its first camera again.

    It lies within the calibration's error of it, too near to matter to the covariances.
    """
    R, t = fit.rig[0].R, fit.rig[0].t
    rig = Rig(tuple(placed(camera, R, t) for camera in fit.rig))
    at = (frames[:, None] * K + np.arange(K)).ravel()
    xyz = np.full((n_frames * K, 3), np.nan)
    residual = np.full((len(fit.rig), n_frames * K, 2), np.nan)
    kept = np.zeros(residual.shape[:2], np.bool_)
    xyz[at], residual[:, at], kept[:, at] = fit.xyz @ R.T + t, fit.residual, fit.kept
    return fit._replace(rig=rig, xyz=xyz, residual=residual, kept=kept)


def _check_agreement(detections: Detections, rows: Ints, shared: int) -> None:
    """Of the frames that cameras seem to share, most show a stick of the wand's length; every camera takes part."""
    agreed = int(shared_frames(rows).sum())
    if agreed < max(AGREEING * shared, FEWEST):
        raise Misfit(
            f"In {shared} frames two cameras or more see what may be the wand, but in {agreed} only do they agree on "
            "a stick of its length. Check that the cameras are synchronised and their recordings begin at the same "
            "moment, the wand's lengths, and that no second wand was in view."
        )
    for c in np.flatnonzero(((rows >= 0).sum(2) >= 2).sum(1) < FEWEST):
        raise Misfit(
            f"Camera {detections.cameras[c]} does not agree with the others where the wand is. Check that it is "
            "synchronised, and that its images are not mirrored or another camera's.",
            detections.cameras[c],
        )


class _Cause(NamedTuple):
    """The error with what is known of its cause, the move of a camera if that is it, and rigs of parts of the film."""

    error: Misfit
    step: CameraStep | None = None
    parts: Iterable[Rig] = ()


def _explained(
    error: Misfit,
    detections: Detections,
    along: Floats,
    sizes: Ints,
    method: Wand,
    lenses: Sequence[Camera] | None,
) -> _Cause:
    """What these detections tell of the cause of an error."""
    if isinstance(error, Mirrored):
        return _Cause(error)
    want = wanted(detections)
    rows, reading = identify_wand(detections, want, along), read_wand(detections, want, along)
    uv = at_rows(detections, first_poses(detections, rows, sizes))[0]
    odd = odd_one(detections.cameras, sizes, uv, along=along, method=method.bundle, lenses=lenses)
    parts: Iterable[Rig] = ()
    step = None
    few = _to_ask(rows, detections.cameras, odd or error.camera)
    if len(few) and not isinstance(error, NoBeginning):
        first = partial(_first_cameras, detections, sizes=sizes, along=along, method=method, lenses=lenses, few=few)
        parts = halves = tuple(rigs_of_parts(detections, rows, first))
        steps = (_step(rig, detections, rows[few], reading.rows[few]) for rig in halves)
        step = next((found for found in steps if found), None)
        if step is None:
            parts = chain(halves, rigs_of_parts(detections, rows, first, THIRDS))
    if not (odd or step) and (gaps := wrong_gaps(reading.ratio, along)):
        return _Cause(Misfit(gaps))
    return _Cause(Misfit(_misfit_words(str(error), step, odd)), step, parts)


def _to_ask(rows: Ints, names: Sequence[str], suspect: str | None) -> Ints:
    """The suspect, of rows (C, F, K), and the `WITNESSES` that see the wand with it in most frames, in order; where
    nobody is, all cameras if they are as few, else none."""
    if len(rows) <= 1 + WITNESSES:
        return np.arange(len(rows))
    if suspect is None:
        return np.arange(0)
    c = names.index(suspect)
    seen: Bools = np.asarray((rows >= 0).all(2))
    shared = (seen & seen[c]).sum(1)
    shared[c] = rows.shape[1] + 1
    return np.sort(np.argsort(-shared, kind="stable")[: 1 + WITNESSES])


def _misfit_words(error: str, step: CameraStep | None, odd: str | None) -> str:
    """The error with what else is known: that a camera was moved, or is the one that does not fit."""
    if step is not None:
        return f"{step_words(step)} {error}"
    if odd is None:
        return (
            f"{error} No single camera seems to be the cause: what is wrong may be so in all, as lengths, lenses that "
            "need more terms, or pixels that are not square (square_pixels = false in [calibrate])."
        )
    return f"Without camera {odd} the others fit each other. " + (
        error
        if f"Camera {odd} " in error
        else "Check that it is synchronous, that its images are neither mirrored nor another camera's and their size "
        "is right, and that it did not move; or leave it out."
    )


def _words(detections: Detections, want: Wanted, rows: Ints, fit: BundleFit, stated: Floats) -> str:
    """What was done, for `Rig.method`."""
    poses = int((rows >= 0).any((0, 2)).sum())
    seen = int((rows >= 0).sum())
    words = f"wand: bundle adjustment, {poses} poses of {detections.n_frames} frames"
    words += f"; left out: {seen - int(fit.kept.sum())} of {seen} points"
    crowded = [f"{n} {k}" for n, k in zip(detections.cameras, want.crowded, strict=True) if k]
    words += f"; frames with too many points: {', '.join(crowded)}" if crowded else ""
    gaps = np.diff(places_of(fit.xyz.reshape(detections.n_frames, -1, 3)))
    if np.abs(gaps - stated).max() > SAME_MM:
        found, given = (" + ".join(f"{mm:.6g}" for mm in each) for each in (gaps, stated))
        words += f"; gaps seen as {found} mm, stated as {given} mm"
    return words
