"""What decides between candidates: how many there are, which is nearest, how many cameras agree, and what is taken."""

from dataclasses import replace

import numpy as np
import pytest

from kinemark.data import KinemarkError
from kinemark.geometry import epipolar_lines, fundamental, project
from kinemark.geometry.ideal_pixels import ideal_pixels
from kinemark.match import EpipolarTriplets, KissTriplets, NearestEpipolar, check_cameras, match
from kinemark.match.epipolar_triplets import _project, _score_groups
from kinemark.match.kiss_triplets import _frame, _ranked, crossings
from support.laboratory import IDEAL, observe, ring, seen_by
from support.motions import swarm

POINT = np.array([100.0, 50.0, 800.0])


@pytest.mark.parametrize("most", [1, 2])
def test_an_image_has_no_more_candidates_than_asked_for_both_ways(most):
    rig = ring(2)
    detections, _ = observe(rig, swarm(n=40, frames=4), noise=0.5)
    pairs = match(detections, rig, method=EpipolarTriplets(candidates=most, pair_band=2.0))
    uses = np.bincount(pairs.detection[pairs.detection >= 0])
    assert uses.max() == most


def lines_and_images(rig, offsets):
    """An image in the first of two cameras, and images in the second `offsets` px from its line there, apart on it."""
    first = project(rig[0], POINT)
    line = epipolar_lines(fundamental(rig.P[0], rig.P[1]), first)
    along = np.array([-line[1], line[0]])
    foot = project(rig[1], POINT)
    foot = foot - (line[:2] @ foot + line[2]) * line[:2]
    return seen_by(rig, [first[None], [foot + 15 * k * along + off * line[:2] for k, off in enumerate(offsets)]])


@pytest.mark.parametrize("offsets", [(0.1, 0.6), (0.6, 0.1), (-0.2, 0.7), (0.7, -0.6)])
def test_the_best_pair_is_the_nearest_to_its_line(offsets):
    rig = ring(2, lens=IDEAL)
    detections = lines_and_images(rig, offsets)
    best = match(detections, rig, method=EpipolarTriplets(pairs="best"))
    assert best.detection.tolist() == [[0, 1 + int(np.argmin(np.abs(offsets)))]]
    assert len(match(detections, rig, method=EpipolarTriplets(pairs="all"))) == 2


def images_of(rig, moved):
    """(C, 2) ideal px of one point, each moved by so much, and the view of all of them."""
    return np.array([project(camera, POINT) for camera in rig]) + moved, np.arange(len(rig))[None]


def test_more_cameras_are_better_even_if_one_fits_badly():
    rig = ring(5, lens=IDEAL)
    uv, detection = images_of(rig, [[0, 0], [0, 0], [0, 0], [0, 0], [0.8, -0.8]])
    without = detection.copy()
    without[0, 4] = -1
    assert _score_groups(detection, uv, rig.P, 2.0)[1] > _score_groups(without, uv, rig.P, 2.0)[1] > 0


def test_an_image_outside_the_circle_leaves_its_group():
    rig = ring(5, lens=IDEAL)
    uv, detection = images_of(rig, [[0, 0], [0, 0], [0, 0], [0, 0], [4.0, 3.0]])
    left, score = _score_groups(detection, uv, rig.P, 2.0)
    assert left.tolist() == [[0, 1, 2, 3, -1]]
    assert score[0] == pytest.approx(4 * 2.0**2, abs=1e-6)
    assert len(_score_groups(detection[:, [0, 4]], uv, rig.P[[0, 4]], 0.01)[0]) == 0


def test_a_point_behind_a_camera_has_no_image_there():
    camera = ring(4)[0]
    behind = camera.centre - 1000.0 * camera.R[2]
    assert np.isnan(_project(behind[None], camera.P)).all()
    assert np.isfinite(_project(POINT[None], camera.P)).all()


def test_images_that_are_taken_make_room_for_other_candidates():
    """KISS: matched images are excluded from further search, so they do not count among the candidates."""
    rig = ring(6, lens=IDEAL).select(["c0", "c1", "c2"])
    F = fundamental(rig.P[0], rig.P[1])
    line = epipolar_lines(F, project(rig[0], POINT))
    rng = np.random.default_rng(0)
    for _ in range(2000):  # another marker whose image in c1 lies on the line of the first one, by chance
        other = rng.uniform([-500, -500, 300], [500, 500, 1500])
        off = line[:2] @ project(rig[1], other) + line[2]
        if abs(off) < 0.3 and np.linalg.norm(other - POINT) > 200:
            break
    uv = np.array([[project(camera, x) for x in (other, POINT)] for camera in rig])
    uv[1, 1] += 0.6 * line[:2]  # so the other's image is the nearer one
    matches = match(seen_by(rig, uv), rig, method=KissTriplets(candidates=1))
    assert sorted(map(tuple, matches.detection.tolist())) == [(0, 2, 4), (1, 3, 5)]


@pytest.mark.parametrize("taken", [False, True])
def test_candidate_cameras_are_ranked_by_their_nearest_image_or_their_angle(taken):
    """Also where the image that was the nearest of all has been taken by another marker."""
    rig = ring(7, lens=IDEAL)
    rng = np.random.default_rng(2)
    points = np.concatenate([POINT[None], POINT + rng.normal(scale=25.0, size=(20, 3))])
    uv = np.array([project(camera, points) for camera in rig]) + rng.normal(scale=0.5, size=(7, 21, 2))
    detections = seen_by(rig, uv)
    F = np.array([[fundamental(a, b) if a is not b else np.zeros((3, 3)) for b in rig.P] for a in rig.P])
    frame = _frame(np.arange(len(detections)), detections.uv, detections, F, 2.0)
    free, steep = [True] * len(frame.detection), crossings(rig)
    if taken:
        (_, images), *_ = _ranked(frame, 0, free, steep.tolist(), KissTriplets())
        free[images[0]] = False
    ranked = {p: _ranked(frame, 0, free, steep.tolist(), KissTriplets(priority=p)) for p in ("distance", "angle")}
    far = {s: [abs(np.dot(frame.lines[s][0], [*frame.uv[j], 1.0])) for j in images] for s, images in ranked["angle"]}
    assert len(far) == 6 and all(own == sorted(own) for own in far.values())
    assert [s for s, _ in ranked["distance"]] == sorted(far, key=lambda s: far[s][0])
    assert [s for s, _ in ranked["angle"]] == sorted(far, key=lambda s: -steep[0, s])


def test_all_methods_begin_alike():
    rig = ring(3)
    detections, _ = observe(rig, swarm(n=3, frames=3))
    check_cameras(detections, rig)
    with pytest.raises(KinemarkError, match="1 camera is calibrated"):
        check_cameras(detections.select(["c0"]), rig.select(["c0"]))
    odd = replace(detections, validity=np.where(detections.camera == 1, 1, 0).astype(np.uint8))
    uv = ideal_pixels(odd, rig, cameras=[0, 1])
    assert np.isfinite(uv[odd.camera == 0]).all() and np.isnan(uv[odd.camera > 0]).all()


def test_noise_in_a_camera_that_is_not_asked_for_is_no_trouble():
    rig = ring(3, lens=IDEAL)
    uv = [project(rig[0], POINT)[None], project(rig[1], POINT)[None], np.zeros((1001, 2))]
    detections = seen_by(rig, uv)
    assert match(detections, rig, method=NearestEpipolar(cameras=("c0", "c1"))).detection.tolist() == [[0, 1, -1]]
    for method in (EpipolarTriplets(), KissTriplets(), NearestEpipolar(cameras=("c0", "c2"))):
        with pytest.raises(KinemarkError, match="1001 points in frame 0, wanted at most 1000"):
            match(detections, rig, method=method)
