"""Merged images that a file does not mark: known by the tracks of both markers."""

import numpy as np
import pytest

from kinemark.data import Cloud, Detections
from kinemark.geometry import project
from kinemark.geometry.weighted_points import ImageErrors
from kinemark.native import index_images
from kinemark.track.simultaneous import Simultaneous, track_detections
from kinemark.track.simultaneous.detection_index import read_images
from kinemark.track.simultaneous.following.associate import predict_images
from kinemark.track.simultaneous.following.candidate_points import intersect
from kinemark.track.simultaneous.following.kalman_states import KalmanStates
from kinemark.track.simultaneous.ghosts import unmarked_merging
from kinemark.track.simultaneous.ghosts.unmarked_merging import (
    LEAST,
    inferred_merging,
    possible_claims,
    resolution,
    scores,
)
from kinemark.track.simultaneous.noise.measurement_noise import Noise
from kinemark.track.simultaneous.points.neighbouring_points import LOOK, TrackPoints
from kinemark.track.simultaneous.points.second_pass import expected_between
from kinemark.track.simultaneous.points.solved_points import Solver, Working
from support.laboratory import observe, ring
from support.motions import dance
from support.scenes import make, scene, tally

T, METHOD, FRAMES, RUN = 0.01, Simultaneous(), 60, slice(20, 40)


def two_markers(*, merged, frames=FRAMES, run=RUN):
    """Images of two markers 12 mm apart, their points, and those of the first in camera 0 in frames of a run.

    There the second has no image: it is in that of the first, or hidden. The first has images in two cameras only.
    """
    rig = ring(4)
    first = dance(n=1, frames=frames, seed=2)
    both = np.concatenate([first, first + np.array([3.0, 4.0, 11.0])])
    detections, marker = observe(rig, both, noise=0.05, seed=3)
    images = read_images(detections, rig)
    detection = np.full((4, 2, frames), -1)
    detection[images.camera, marker, images.frame] = np.arange(len(marker))
    uv, own, other = images.uv.copy(), detection[0, 0, run], detection[0, 1, run].copy()
    apart = np.hypot(*(uv[own] - uv[other]).T).max()
    if merged:
        uv[own] = (uv[own] + uv[other]) / 2
    usable = images.usable.copy()
    usable[other] = False
    images = images._replace(uv=uv, usable=usable, by_cell=images.by_cell.keep(usable))
    detection[0, 1, run] = -1
    detection[2:, 0] = -1
    held = detection.reshape(4, -1)
    point = intersect(images, held)
    points = TrackPoints(
        np.tile(np.arange(frames), 2), np.repeat([0, 1], frames), point.xyz.T, point.cov.transpose(2, 0, 1)
    )
    return images, points, held, own, apart


@pytest.mark.parametrize("merged", [True, False])
def test_an_image_of_both_is_told_from_a_marker_that_is_hidden(merged):
    images, points, held, own, apart = two_markers(merged=merged)
    claims = possible_claims(points, held, images, 1.6 * apart)
    said = scores(claims, points, held, images, T, METHOD)
    first = claims.row < FRAMES
    assert set(held[0, claims.row[first]]) == set(own)
    assert (said[first] > LEAST).all() == merged
    assert (said[first] < LEAST).all() == (not merged)


def without_second(images, points, held, run):
    """The same without the points of the second marker in frames of a run."""
    kept = (points.id == 0) | ~np.isin(points.frame, np.arange(run.start, run.stop))
    return images, points.take(kept), held[:, kept]


@pytest.mark.parametrize("merged", [True, False])
def test_an_image_of_both_is_told_where_the_other_has_no_point(merged):
    run = slice(20, 27)
    images, points, held, own, apart = two_markers(merged=merged, run=run)
    images, points, held = without_second(images, points, held, run)
    assert not len(possible_claims(points, held, images, 1.6 * apart).row)
    claims = possible_claims(points, held, images, 1.6 * apart, expected_between(points, FRAMES, T, METHOD))
    said = scores(claims, points, held, images, T, METHOD)
    of_it = claims.camera[0]
    assert set(held[0, claims.row[of_it]]) == set(own) and (claims.other == 1).all()
    assert (said[of_it] > LEAST).all() == merged
    assert (said[of_it] < LEAST).all() == (not merged)


def test_an_image_where_a_track_without_a_point_is_expected_may_be_its_own():
    run = slice(20, 27)
    images, points, held, own, apart = two_markers(merged=True, run=run)
    images, points, held = without_second(images, points, held, run)
    unseen = expected_between(points, FRAMES, T, METHOD)
    uv = images.uv.copy()
    uv[own] = predict_images(images.P, KalmanStates(unseen.xyz.T, unseen.cov.transpose(1, 2, 0))).uv[0].T + 0.05
    cell = images.frame * len(images.P) + images.camera
    images = images._replace(uv=uv, by_cell=index_images(uv, cell, images.usable, n_cells=FRAMES * len(images.P)))
    claims = possible_claims(points, held, images, 1.6 * apart, unseen)
    assert not claims.camera[0].any()


def test_tracks_are_expected_between_their_points_and_near_one_of_them():
    xyz = dance(n=1, frames=FRAMES, seed=2)[0]
    frame = np.delete(np.arange(5, FRAMES), np.arange(20, 20 + 2 * LOOK + 3))
    points = TrackPoints(
        frame, np.full(len(frame), 3), xyz[frame], np.broadcast_to(0.01 * np.eye(3), (len(frame), 3, 3))
    )
    found = expected_between(points, FRAMES, T, METHOD)
    assert sorted(found.frame) == np.setdiff1d(np.arange(25, 28 + 2 * LOOK), 25 + LOOK + np.arange(3)).tolist()
    off = found.xyz - xyz[found.frame]
    assert (found.id == 3).all()
    assert (np.einsum("pi,pij,pj->p", off, np.linalg.inv(found.cov), off) < 16).all()


@pytest.mark.parametrize("merged", [True, False])
def test_the_longer_a_run_the_less_its_begin_says_of_its_end(merged):
    """What is left out between both is predicted: where nothing is known of the place there, more noise is the same."""
    images, points, held, own, apart = two_markers(merged=merged, frames=300, run=slice(20, 280))
    claims = possible_claims(points, held, images, 1.6 * apart)
    said = [scores(claims, points, held, images, 1.0, Simultaneous(process_noise=q)) for q in (1e8, 1e10)]
    first = claims.row < 300
    assert len(own) == 260 and (said[0][first] > LEAST).all() == merged
    np.testing.assert_allclose(said[0], said[1], rtol=1e-6)


def test_the_image_of_both_says_where_that_of_one_alone_would_be(monkeypatch):
    images, points, held, own, apart = two_markers(merged=True)
    monkeypatch.setattr(unmarked_merging, "resolution", lambda images: 1.6 * apart)
    merging = inferred_merging(points, held, images, T, METHOD)
    rig, first = ring(4), dance(n=1, frames=FRAMES, seed=2)[0]
    alone = project(rig[0], first[images.frame[own]])
    at = np.searchsorted(merging.image, own)
    assert (merging.image[at] == own).all()
    assert merging.clear[at].all()
    assert (merging.track[at] == 0).all()
    told = np.linalg.norm(images.uv[own] + merging.beside[at] - alone, axis=1)
    assert (told < 0.4 * np.linalg.norm(images.uv[own] - alone, axis=1)).all()
    assert (told**2 < 9 * merging.own_variance[at]).all()


@pytest.mark.parametrize("left", [0.0, 2.0])
def test_what_the_given_rig_leaves_open_is_in_the_variance_once(monkeypatch, left):
    images, points, held, own, apart = two_markers(merged=True)
    monkeypatch.setattr(unmarked_merging, "resolution", lambda images: 1.6 * apart)
    merging = inferred_merging(points, held, images, T, METHOD)
    rig, first = ring(4), dance(n=1, frames=FRAMES, seed=2)
    both = np.concatenate([first, first + np.array([3.0, 4.0, 11.0])])
    detections, _ = observe(rig, both, noise=0.05, seed=3)
    order = np.argsort(points.frame, kind="stable")
    start = np.searchsorted(points.frame[order], np.arange(FRAMES + 1))
    cloud = Cloud(100.0, start, points.xyz[order], points.cov[order], np.zeros(len(order)), held.T[order])
    given = merging.marked(images)
    none, more = np.zeros(len(rig)), np.full(len(rig), left)
    noise = Noise(none, none, more, none, none, none)
    working = Working(rig, given._replace(variance=given.variance + given.margin()), noise)
    solver = Solver(detections, working, np.zeros(len(detections), bool), ImageErrors())
    told = merging.told_apart(cloud, points.id[order], solver)
    assert set(own) <= set(merging.image)
    assert told.variance(merging.image) == pytest.approx(merging.own_variance + left)
    assert told.uv(merging.image) == pytest.approx(detections.uv[merging.image] + merging.beside, abs=1e-3)
    plain = np.setdiff1d(np.arange(len(detections)), merging.image)
    assert (told.variance(plain) == solver.variance(plain)).all()
    assert (told.uv(plain) == detections.uv[plain]).all()


@pytest.mark.parametrize("r", [4.0, 7.0])
def test_the_distance_below_which_images_are_one_shows_in_all_of_them(r):
    assert resolution(crowded(r)) == pytest.approx(r, abs=0.5)
    assert resolution(crowded(0.0)) == 0


def crowded(r):
    """Images of two cameras, 80 places a frame at random in 500 px, without the later of any two nearer than r."""
    rng, rig = np.random.default_rng(5), ring(2)
    frames = [[np.empty((0, 2)) for _ in range(30)] for _ in rig]
    for camera in frames:
        for f, uv in enumerate(rng.uniform(0, 500, (30, 80, 2))):
            near = np.linalg.norm(uv[:, None] - uv, axis=-1) < r
            camera[f] = uv[~np.tril(near, -1).any(1)]
    counts = np.array([[len(uv) for uv in camera] for camera in frames])
    detections = Detections.build(rig.names, 100.0, counts, np.concatenate([uv for camera in frames for uv in camera]))
    return read_images(detections, rig)


def test_ghosts_of_merged_images_that_are_not_marked():
    made = make(scene(6))
    count = tally(made, track_detections(made.detections, made.rig))
    assert count.ghosts <= 0.05 * count.frames  # 0.10 where nothing is inferred
    assert count.more_found > 0.999 * count.more


@pytest.mark.parametrize(
    ("seed", "ghosts", "two_found"),
    [
        pytest.param(137060, 6, 1193, id="the other marker has no point"),  # 13 where it must have one in that frame
    ],
)
def test_ghosts_of_merged_images_are_fewer(seed, ghosts, two_found):
    made = make(scene(seed))
    count = tally(made, track_detections(made.detections, made.rig))
    assert count.ghosts <= ghosts
    assert count.more_found == count.more
    assert count.two_found >= two_found


def test_what_a_file_marks_is_believed():
    images, points, held, *_ = two_markers(merged=True)
    marks = images._replace(merged=np.arange(len(images.uv)) == 0)
    assert not len(inferred_merging(points, held, marks, T, METHOD).image)
