"""Kinemark's own tracker: matching and tracking at once.

The paper of the Kiss system (Shafiq, Tümer and Güler 2001) notes that no method had been reported that does both at the
same time. The order of the work:

1. Images are read by the rig as given, and their noise is learned (`measurement_noise`). They are associated with an
   adjusted rig (`adjusted_rig`) where they agree better with it (1). What agrees may be chance meetings, which stay for
   many frames where many markers move slowly; but no tracks come of them, so the rig as given is used where parts of
   the recording are tracked with far more images by it (2). These parts tell how markers move (`motion_scale`).
2. First pass: tracks, predicted with their covariance (`kalman_states`), are associated with images in all cameras
   (`associate`), forwards and then backwards (`passes`). Images that no track has initiate new tracks (`initiate`).
   Where two cameras alone see a track, what explains one of its images better takes its place (`rival_pairs`). A track
   is confirmed by its evidence (`likelihood`). Its points are solved from their images, or as its motion says where
   these tell little (`solved_points`).
3. A rig adjusted to the tracks takes the place of the one before where the images agree better with it
   (`rig_of_tracks`), and 2 is done again.
4. Fragments of one marker's trajectory are stitched (`stitch`).
5. Merged images that a file does not mark are inferred (`unmarked_merging`); they, and images of other markers, are
   given up with the points that they make (`given_up_points`).
6. Images that are left make new tracks where they do not drift (`remaining_images`). The second pass looks for missing
   and uncertain points (`second_pass`), and 5 is done again.
7. Tracks of a rigid body that breaks are told by their place on it (`rigid_pass`).
8. Positions are solved by the rig as given.
9. What an impact ended is joined after it (`impacts`), as what is smooth across it is wrong; so is what companions tell
   (`companions`). Tracks that go on as each other are changed back (`exchanged_tails`).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...data import Cloud, Detections, Finding, Rig, Tracks
from ...data.array_types import Bools, Floats, Ints
from ...geometry.weighted_points import ImageErrors, usable_points
from ...numerics.returned_memory import return_memory
from ...numerics.runs import begins
from .detection_index import Images, read_images
from .following.candidate_points import fundamentals
from .following.likelihood import SURE, disagreement, evidence, point_evidence
from .following.motion_scale import count_images, in_windows, with_learned_motion
from .following.passes import Associations, run
from .ghosts.drifting_pairs import usual_residuals
from .ghosts.given_up_points import with_merging, without_drifting, without_reflections
from .ghosts.rival_pairs import without_rivalled
from .ghosts.unmarked_merging import Merging, with_merging_in_images
from .joining.companions import joined_pieces
from .joining.exchanged_tails import with_exchanged_tails
from .joining.stitch import Stitch, stitched
from .noise.measurement_noise import Noise, sampled_frames
from .noise.standing_noise import lasting_variance
from .points.found_points import with_remaining, with_rigid_pass, with_second_pass
from .points.neighbouring_points import TrackPoints
from .points.solved_points import (
    Held,
    Solver,
    Working,
    by_motion,
    on_given_rig,
    precise_enough,
    solved_columns,
    solver_for,
    with_few_smoothed,
)
from .rig.adjusted_rig import adjusted_rig
from .rig.missing_lens import MissingLenses
from .rig.moved_cameras import MovedCamera
from .rig.told_by_tracks import of_tracks, with_noise
from .rig.unfitting_stretches import Stretch
from .simultaneous_method import Simultaneous

ADJUSTED_VARIANCE_RATIO = 0.7
"""Of the variance that residuals of images have with the rig as given, the most that is left where the adjusted rig is
used; chosen (see benchmarks/tracking_scenes.py)."""

MOST_TRACKED_RATIO = 1.5
"""Images that tracks of parts of the recording have with the rig as given, as a ratio to those with the adjusted one,
above which the rig as given is used; chosen: of 51 scenes (seeds 131000 to 131100 and 136000 to 136129 of
benchmarks/tracking_scenes.py) 47 have 0.8 to 1.2. One of 2.1 had 36 % of its samples, and 99.8 with the rig as given;
others of 1.3 to 3.1 are sprints, which find the same samples by either rig."""


class CameraTimes(NamedTuple):
    """Of C cameras: delay (C) s by which they take their images later than the others, and what the last row is taken
    later than the middle one, line (C) s, with their standard errors; unsteady (C) s, the standard deviation of the
    times of their images; 0 where nothing was found."""

    delay: Floats
    delay_error: Floats
    line: Floats
    line_error: Floats
    unsteady: Floats


class ImageOffset(NamedTuple):
    """By how many px, about, the images of a camera, a number, lay beside where the others expect them."""

    camera: int
    u: float
    v: float


class TrackingResult(NamedTuple):
    """What the method gives.

    Attributes:
        tracks: the tracks.
        seen: the associations of all tracks, also of those that were dropped, but for what lost tracks found without
            evidence and for the second pass, without `cov` and `squared`; its rows are of `images`.
        id: (N) the track that each of `seen` became, −1 for none.
        evidence: (N) for each of `seen`.
        stitches: those that were made or considered, of tracks of `seen`.
        images: what the cameras saw; noise: what was learned of them.
        outside: (K, 3) mm, points that were left out as they lie outside the volume.
        times: of the cameras, by which all was tracked.
        unfitting: stretches in which a camera fits the others no more, and was left out.
        lenses: by the images, where the rig has lost their terms, by which all was tracked; None where none is missing.
        rig: by which the points were solved: as given, but for lost lens terms and cameras that were put right.
        put_right: these cameras, and how far their images lay beside.
        doubtful: cameras, numbers, that seem to fit the others nowhere, where none was left out.
        shifted: of cameras that lay beside by little, in stretches of `unfitting` or of `moved`, what was found.
        moved: stretches in which a camera that was knocked has its images where it would have had them before.
        resolution: px, below which two markers are one image that the file does not mark; 0 where none are merged.
        scale: `room_scale`, by which the method's lengths counted.
    """

    tracks: Tracks
    seen: Associations
    id: Ints
    evidence: Floats
    stitches: list[Stitch]
    images: Images
    noise: Noise
    outside: Floats
    times: CameraTimes
    rig: Rig
    unfitting: tuple[Stretch, ...] = ()
    lenses: MissingLenses | None = None
    put_right: tuple[ImageOffset, ...] = ()
    doubtful: tuple[int, ...] = ()
    shifted: tuple[Finding, ...] = ()
    moved: tuple[MovedCamera, ...] = ()
    resolution: float = 0.0
    scale: float = 1.0


def track_once(
    detections: Detections,
    rig: Rig,
    method: Simultaneous,
    errors: ImageErrors,
    volume_margin: float | None,
    timing: Floats | None = None,
) -> TrackingResult:
    """`track_simultaneously` with all cameras taken for synchronous, but for errors `timing` (D, 2) px of `Images`."""
    T = 1 / detections.rate
    images, noise, working, method, scale, first = _learned(detections, rig, method, errors, timing)
    every, speaks, shared, cloud, ids = first
    del first  # its arrays end with the names that they have now
    return_memory()
    whole = stitched(TrackPoints.of(cloud, ids), T, method)
    whole = whole.of(int(every.id.max(initial=-1)) + 1)
    ids = whole.id[ids]
    return_memory()
    solver = solver_for(detections, shared, working, errors)
    held = [cloud]
    del cloud
    cloud, ids, became, merging = _passes_over(held, ids, solver, len(whole.id), method)
    whole = whole.of(len(became))
    whole = whole._replace(id=np.append(became, np.arange(len(became), len(whole.id)))[whole.id])
    adjusted, lasting = working.rig is not rig, solver.lasting
    del working, solver
    return_memory()
    if adjusted:
        images = with_noise(read_images(detections, rig, timing, other=images), method)[0]
        order, begins, images = images.by_cell.order, images.by_cell.first, merging.marked(images.unplaced())
        given = Working(rig, images, noise)
        solver = merging.told_apart(cloud, ids, solver_for(detections, shared, given, errors))
        cloud, lasting = on_given_rig(cloud, solver), solver.lasting
        del given, solver
        images = images.placed(detections, rig, order, begins)
    else:
        images = merging.marked(images)
    cloud = with_few_smoothed(cloud, ids, images, method, lasting)
    return_memory()
    inside = usable_points(cloud, rig, margin=volume_margin)
    outside, cloud, ids = cloud.xyz[~inside], cloud.keep(inside), ids[inside]
    cloud, ids, whole = joined_pieces(cloud, ids, whole, T, method)
    ids, every, whole = with_exchanged_tails(cloud, ids, every, whole, T, method)
    kept, number = np.unique(ids, return_inverse=True)
    final = np.where(np.isin(whole.id, kept), np.searchsorted(kept, whole.id), -1)
    tracks, times = Tracks(cloud, number), CameraTimes(*np.zeros((5, len(rig))))
    result = TrackingResult(tracks, every, final, speaks, whole.stitches, images, noise, outside, times, rig)
    return result._replace(resolution=merging.resolution, scale=scale)


def _learned(
    detections: Detections, rig: Rig, method: Simultaneous, errors: ImageErrors, timing: Floats | None
) -> tuple[Images, Noise, Working, Simultaneous, float, FirstPass]:
    """The images by the rig as given and their noise; the rig, noise and motion that images and tracks tell, by which
    the first pass was done, the scale of the room, and the tracks."""
    images, noise = with_noise(with_merging_in_images(read_images(detections, rig, timing)), method)
    working, seen = _working(detections, rig, images, noise, method)
    images = _waiting(images, working, rig)
    moving = with_learned_motion(working.images, detections.rate, method, seen)
    del seen
    return_memory()
    working, method, broke, scale = working._replace(images=moving.images), *moving[1:]
    del moving
    first = _first_pass(detections, images, working, method, errors)
    if not broke:  # tracks that break need the room they have
        held = [working]
        del working  # its places are given up while another rig's are looked at
        working, better = of_tracks(detections, images, held, Tracks(first.cloud, first.id), method)
        if better:
            del first  # before there are two in memory
            return_memory()
            first = _first_pass(detections, images, working, method, errors)
    return _waiting(images, working, rig), noise, working, method, scale, first


def _passes_over(
    held: Held, ids: Ints, solver: Solver, first: int, method: Simultaneous
) -> tuple[Cloud, Ints, Ints, Merging]:
    """The points of stitched tracks ids (P) after all that is given up and found, with new tracks from number `first`
    on; what tracks became, and the images that are of two markers.

    What is found after merged images were told has such images too: so they are told once more.
    """
    unmarked = solver
    held, ids, merging, solver = with_merging(held, ids, unmarked, method)
    images = solver.working.images
    return_memory()
    usual = usual_residuals(held[0].frame, ids, held[0].detection.T, images, method.gate)
    held, ids = without_drifting(held, ids, merging, images, usual, solver, method)
    held, ids = with_remaining(held, ids, first, images, usual, merging.resolution, solver, method)
    held, ids = with_second_pass(held, ids, images, solver, method)
    del solver, images  # before there are two in memory
    held, ids, merging, solver = with_merging(held, ids, unmarked, method)
    images = solver.working.images
    held, ids = without_drifting(held, ids, merging, images, usual, solver, method)
    held, ids = without_reflections(held, ids, images, method.gate)
    held, ids, became = with_rigid_pass(held, ids, images, solver, method)
    return held.pop(), ids, became, merging


def _waiting(images: Images, working: Working, rig: Rig) -> Images:
    """The images by the rig as given, laid aside where another rig is worked with until the end."""
    images = images if working.rig is rig else images.laid_aside()
    return_memory()
    return images


class FirstPass(NamedTuple):
    """What the first pass gives: `TrackingResult.seen` and `evidence`; whether tracks share an image (D); the points
    that are given, and the id (P) of the track of each."""

    every: Associations
    evidence: Floats
    shared: Bools
    cloud: Cloud
    id: Ints


def _first_pass(
    detections: Detections, images: Images, working: Working, method: Simultaneous, errors: ImageErrors
) -> FirstPass:
    """The tracks that are confirmed, their points solved, before any is stitched."""
    T = 1 / detections.rate
    every, seen, speaks = _followed(detections.rate, images, working, method)
    return_memory()
    own = _unshared(seen, images)
    shared = np.zeros(len(images.usable), bool)
    shared[seen.detection[seen.shared & (seen.detection >= 0)]] = True
    solver, number = solver_for(detections, shared, working, errors), own.sum(0)
    filtered, detection = TrackPoints(seen.frame, seen.id, seen.xyz.T, seen.cov.transpose(2, 0, 1)), seen.detection
    del seen, own  # what no longer counts, before the points are in memory twice
    return_memory()
    columns = solved_columns(filtered.frame, detection, filtered.xyz.T, solver)
    points = TrackPoints(filtered.frame, filtered.id, *columns[:2])
    moved = by_motion(points, filtered, number >= 2, T, method, solver.lasting)
    columns[0][moved.row], columns[1][moved.row] = moved.xyz, moved.cov
    good = np.isfinite(points.xyz).all(1) & precise_enough(points.cov, number, method)
    good &= (speaks > SURE)[points.id]
    frame, ids = points.frame[good], points.id[good]
    del filtered, points, solver, moved
    return_memory()
    start = np.searchsorted(frame, np.arange(images.n_frames + 1))
    xyz, cov, residual = (columns.pop(0)[good] for _ in range(3))  # none is in memory twice for long
    cloud = Cloud(detections.rate, start, xyz, cov, residual, np.ascontiguousarray(detection[:, good].T))
    return FirstPass(every, speaks, shared, cloud, ids)


def _followed(
    rate: float, images: Images, working: Working, method: Simultaneous
) -> tuple[Associations, Associations, Floats]:
    """The associations of all tracks, without `cov` and `squared`; those of tracks that have enough; the evidence (N).

    What this needs in between takes much memory, and ends with it.
    """
    T = 1 / rate
    least = min(max(method.min_duration / T, 4), images.n_frames)
    F = fundamentals(working.images.P)
    every = run(working.images, rate, method, lasting_variance(working.images, F, T, method.gate))
    evident, columns = ~_without_evidence(every, _unshared(every, images), least, method), list(every)
    del every
    columns = list(Associations.of(columns, evident))
    return_memory()
    rivalled = without_rivalled(columns, working.images, F, T, method)
    return_memory()
    seen = _kept_associations(rivalled.associations, least)
    every = rivalled.associations._replace(cov=np.zeros((3, 3, 0)), squared=np.zeros(0))  # only those of `seen` count
    rivalled = rivalled._replace(associations=every)
    speaks = _evidence(seen, images, working, method)
    speaks = np.pad(speaks, (0, len(rivalled.whole()) - len(speaks)))[rivalled.whole()]
    every, seen = (one._replace(id=rivalled.pieces(one.id, one.frame)) for one in (every, seen))
    return_memory()
    return every, seen, speaks


def _working(
    detections: Detections, rig: Rig, images: Images, noise: Noise, method: Simultaneous
) -> tuple[Working, Associations | None]:
    """The adjusted rig where its images agree better than those of the rig as given (1), and tracks have about as many
    of them (2), otherwise that; and what was tracked by it in parts of the recording, where that was asked.

    Cameras whose images fit nothing are left out.
    """
    given = Working(rig, images.without(noise.inconsistent), noise)
    if not given.images.usable.any() or (images.stated and not noise.added.any()):
        return given, None  # nothing seen, or images that agree as well as they say
    adjusted = adjusted_rig(given.images, rig, sampled_frames(images))
    moved = read_images(detections, adjusted, images.timing, other=images)
    moved, left = with_noise(moved, method)
    if not _agree_better(noise, left, images):
        return given, None
    working = Working(adjusted, moved.without(left.inconsistent), left)
    by_given, seen = (in_windows(one.images, detections.rate, method) for one in (given, working))
    fewer = count_images(by_given) > MOST_TRACKED_RATIO * count_images(seen)
    return (given, by_given) if fewer else (working, seen)  # (2)


def _agree_better(noise: Noise, left: Noise, images: Images) -> bool:
    """Whether residuals of the median image have less variance by `left` than by `noise` (1), of images by the latter.

    The images' own variances hide it: with any rig they are no less than what is stated. But where residuals have
    less than that with the rig as given, nothing is to be gained.
    """
    camera = images.camera[images.usable]
    before, after = (np.median(one.seen[camera]) for one in (noise, left))
    stated = np.median(images.variance[images.usable] - noise.added[camera] ** 2)
    return bool(before > stated and after <= ADJUSTED_VARIANCE_RATIO * before)


def _evidence(seen: Associations, images: Images, working: Working, method: Simultaneous) -> Floats:
    """(N) the evidence for each track, by how its images agree in the working rig, of two as these cameras' do."""
    own = _unshared(seen, images)
    off = disagreement(working.images, np.where(own, seen.detection, -1))
    two = own.sum(0) == 2
    a, b = np.nonzero(own[:, two].T)[1].reshape(-1, 2).T
    off[two] /= working.noise.pairs[a, b]
    return evidence(seen._replace(squared=off), own, method.gate)


def _kept_associations(seen: Associations, least: float) -> Associations:
    """The associations in two and more cameras of tracks that have enough of them, by frame."""
    own = np.flatnonzero((seen.detection >= 0).sum(0) >= 2)
    own = own[np.bincount(seen.id[own], minlength=1)[seen.id[own]] >= least]
    return seen.take(own[np.lexsort([seen.id[own], seen.frame[own]])])


def _unshared(seen: Associations, images: Images) -> Bools:
    """(C, S) images that belong to one marker alone."""
    return (seen.detection >= 0) & ~seen.shared & ~images.merged[seen.detection]


def _without_evidence(every: Associations, own: Bools, least: float, method: Simultaneous) -> Bools:
    """(S) associations of a track after it was lost, its standard deviation above `uncertain_sd`, without evidence for
    it.

    Its unshared images (C, S) until it is lost again must be evidence of a marker, or last as long as the shortest
    track. In `every` a track's associations stand as they were made, forwards from where it was initiated and then
    backwards. In either direction it begins at its first points, and so is not lost there, vague as these may be.
    """
    order = np.argsort(every.id, kind="stable")
    id, frame = every.id[order], every.frame[order]
    back = frame < frame[np.searchsorted(id, id)]
    first = begins(id, back)
    anchored = own.sum(0)[order] >= 2
    lost = (every.before[order] > method.uncertain_sd) & ~np.roll(anchored, 1) & ~first
    spell = np.cumsum(first | lost) - 1
    said = np.bincount(spell, point_evidence(every, own, method.gate)[order])
    sure = (np.bincount(spell, first) > 0) | (said > SURE) | (np.bincount(spell, anchored) >= least)
    out = np.zeros(len(order), bool)
    out[order] = ~sure[spell]
    return out
