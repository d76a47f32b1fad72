"""The compiled kernel of the tracker against NumPy, and what it does with rows that are none."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from kinemark import native
from kinemark.native import PLAIN
from kinemark.synth import observe, ring, walking, with_markers
from kinemark.track.simultaneous import (
    track_detections,
)
from kinemark.track.simultaneous.detection_index import Images, read_images
from kinemark.track.simultaneous.following import associate as association
from kinemark.track.simultaneous.following import candidate_points as groups
from kinemark.track.simultaneous.following import kalman_states as motion
from support.examples import examples
from support.plain import plainly

needs_kernel = pytest.mark.skipif(native.library() is None, reason="the tracker was installed without a compiler")
some = settings(max_examples=examples(40), deadline=None)
RIG = ring(5, focal_px=1100.0)
WALK = with_markers(walking(duration_s=0.3, rate=100.0, seed=5, speed_mm_s=1000.0), 15, seed=5)
SEEN = observe(RIG, WALK, noise_px=0.2, false_per_frame=5.0, merge_px=8.0, seed=5)
IMAGES: Images = read_images(SEEN.detections, RIG)


def both(function, *args, relative=1e-7):
    """The results of the kernel, which must be those of NumPy to rounding."""
    found, wanted = function(*args), plainly(function, *args)
    for one, other in zip(found, wanted, strict=True):
        size = np.abs(other[np.isfinite(other)]).max(initial=0.0)
        np.testing.assert_allclose(one, other, rtol=relative, atol=1e-10 * size)
    return found


@st.composite
def points(draw):
    """n points in motion, of various uncertainty, n being no multiple of what the kernel does at once."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    n = draw(st.integers(0, 21))
    root = rng.normal(0, 1, (n, 9, 9)) * np.repeat([3.0, 50.0, 900.0], 3)[:, None]
    x = np.concatenate([rng.uniform(0, 1500, (3, n)), rng.normal(0, 800, (6, n))])
    return motion.KalmanStates(x, (root @ root.swapaxes(1, 2)).transpose(1, 2, 0)), rng


@needs_kernel
@some
@given(points(), st.floats(0.002, 0.3))
def test_points_predicted_and_updated(made, T):
    state, rng = made
    n = state.x.shape[-1]
    both(motion.predict, state, T, 5000.0)
    both(motion.predict, state, rng.uniform(0.001, 0.3, n), 5000.0)
    J = rng.normal(0, 1, (n, int(rng.integers(1, 5)), 3))  # of one row only: the information is singular
    N = np.einsum("nai,naj->ijn", J, J)
    both(motion.update, state, N, rng.normal(0, 1, (3, n)), relative=1e-6)


@needs_kernel
@some
@given(points(), st.booleans())
def test_places_candidates_and_information(made, all_free):
    state, rng = made
    n = state.x.shape[-1]
    if n:
        state.x[:3, 0] = 2 * RIG.centres[0] - state.x[:3, 0]  # behind a camera
    expected = both(association.predict_images, IMAGES.P, state)
    frame = rng.integers(0, IMAGES.n_frames, n)
    free = IMAGES.usable & (all_free | (rng.random(len(IMAGES.uv)) < 0.5))
    expected = association.PredictedImages(*expected)
    pairs = association.TrackImagePairs(*both(association.candidates, IMAGES, free, frame, expected, 4.0))
    assert (pairs.squared < 16).all() and free[pairs.detection].all()
    detection = np.full((len(RIG), n), -1)
    detection.reshape(-1)[pairs.own] = pairs.detection
    variance = np.where(detection >= 0, IMAGES.variance[detection], np.inf)
    both(
        association.information,
        IMAGES,
        expected,
        association.Association(detection, variance, np.zeros(detection.shape), detection > 1 << 40),
    )


@needs_kernel
def test_all_candidates_are_found_however_many():
    """More images lie about a place than the kernel has room for at first."""
    crowd = read_images(observe(RIG, WALK, false_per_frame=40.0, seed=6).detections, RIG)
    state = motion.KalmanStates(np.zeros((9, 1)), np.eye(9)[..., None] * 1e10)
    state.x[:3, 0] = np.nanmean(WALK.xyz, axis=(0, 1))
    expected = association.predict_images(crowd.P, state)
    pairs = association.TrackImagePairs(
        *both(association.candidates, crowd, crowd.usable, np.array([3]), expected, 4.0)
    )
    assert len(pairs.own) == (crowd.frame[crowd.by_cell.order] == 3).sum() > 4 * len(RIG) + 64


@needs_kernel
def test_what_is_known_along_a_line_alone_keeps_the_area_that_its_images_give_it():
    """So long a covariance loses in rounding what it is across: |S| came out zero or negative."""
    along = np.random.default_rng(8).normal(size=(15, 3))
    state = motion.KalmanStates(np.concatenate([WALK.xyz[:, 4].T, np.zeros((6, 15))]), np.zeros((9, 9, 15)))
    state.cov[:3, :3] = 1e20 * np.einsum("ti,tj->ijt", along, along)
    expected = association.predict_images(IMAGES.P, state)
    pairs = association.TrackImagePairs(
        *both(association.candidates, IMAGES, IMAGES.usable, np.full(15, 4), expected, 4.0, relative=1e-3)
    )
    assert len(pairs.own) and np.isfinite(pairs.log_det).all() and (pairs.squared >= 0).all()


@needs_kernel
def test_images_without_a_camera_are_no_candidates():
    less = IMAGES.without(np.array([1, 3]))
    state = motion.KalmanStates(
        np.concatenate([WALK.xyz[:, 4].T, np.zeros((6, 15))]), np.tile(np.eye(9)[..., None], 15)
    )
    args = IMAGES.usable, np.full(15, 4), association.predict_images(IMAGES.P, state), 4.0
    pairs = association.TrackImagePairs(*both(association.candidates, less, *args))
    assert set(IMAGES.camera[pairs.detection]) == {0, 2, 4} and len(
        association.candidates(IMAGES, *args).detection
    ) > len(pairs.detection)


@needs_kernel
@some
@given(st.integers(0, 2**32 - 1))
def test_where_views_meet(seed):
    rng = np.random.default_rng(seed)
    frame = int(rng.integers(0, IMAGES.n_frames))
    own = [np.flatnonzero((IMAGES.frame == frame) & (IMAGES.camera == c)) for c in range(len(RIG))]
    detection = np.array([rng.choice(rows, 12) for rows in own])
    detection[rng.random(detection.shape) < 0.3] = -1
    detection = detection[:, (detection >= 0).sum(0) >= 2]
    close = groups.intersect(IMAGES, detection).squared.max(0, initial=0) < 1e6  # others are far from being any point
    both(groups.intersect, IMAGES, detection[:, close], relative=1e-4)
    pair = np.array([rng.choice(own[1], 12), rng.choice(own[3], 12)])
    both(groups.intersect, IMAGES, pair, np.array([[1], [3]]), relative=1e-4)


@pytest.mark.parametrize("plain", ["", "1"])
def test_rows_that_are_none_and_rays_that_are_parallel(monkeypatch, plain):
    """One image alone has no place; −1 counts as no image, and other numbers that are none are refused."""
    monkeypatch.setenv(PLAIN, plain)
    detection, camera = np.array([[-1, 5], [-1, -1]]), np.array([[0, 0], [1, 1]])
    xyz, _, squared = native.intersect(IMAGES.P, IMAGES.uv, IMAGES.variance, detection, camera)
    assert np.isnan(xyz).all() and (squared[:, 0] == -1).all() and squared[0, 1] == np.inf
    N, g = native.information(np.zeros((2, 2, 2)), np.ones((2, 2, 3, 2)), detection, np.ones((2, 2)), IMAGES.uv)
    assert (N[..., 0] == 0).all() and (g[:, 0] == 0).all() and np.allclose(N[..., 1], 2)
    for wrong in (np.where(detection > 0, 10**9, detection), np.where(detection > 0, -7, detection)):
        with pytest.raises(ValueError, match=r"detection has the index (10{9}|-7), wanted -1 … "):
            native.intersect(IMAGES.P, IMAGES.uv, IMAGES.variance, wrong, camera)
        with pytest.raises(ValueError, match=r"detection has the index"):
            native.information(np.zeros((2, 2, 2)), np.ones((2, 2, 3, 2)), wrong, np.ones((2, 2)), IMAGES.uv)
    with pytest.raises(ValueError, match="camera has the index 1000000, wanted 0 … 4"):
        native.intersect(IMAGES.P, IMAGES.uv, IMAGES.variance, detection, camera * 10**6)
    with pytest.raises(ValueError, match="cell has the index -3, wanted 0 … "):
        places = np.array([-3, 10**9]), np.zeros((2, 2)), np.ones((3, 2)), np.full(2, 1e4)
        native.candidates(IMAGES.by_cell, IMAGES.variance, IMAGES.usable, *places, gate=1e9)


@needs_kernel
def test_tracks_are_the_same():
    one, other = track_detections(SEEN.detections, RIG), plainly(track_detections, SEEN.detections, RIG)
    assert (one.id == other.id).all() and (one.cloud.detection == other.cloud.detection).all()
    np.testing.assert_allclose(one.cloud.xyz, other.cloud.xyz, atol=1e-6)
    assert len(one) >= 15


def test_without_a_kernel_numpy_tracks():
    assert len(plainly(track_detections, SEEN.detections, RIG)) >= 15
