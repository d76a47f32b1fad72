"""Tracks are initiated of what moves far faster than all else, and of what moves far at few frames a second."""

import numpy as np
import pytest

from kinemark.synth import ring as near_ring
from kinemark.synth.score import score
from kinemark.track.simultaneous import Simultaneous, track_detections
from kinemark.track.simultaneous.following.candidate_points import CandidatePoints
from kinemark.track.simultaneous.following.initiate import _triples
from support.laboratory import observe, ring
from support.motions import dance
from support.scenes import make, scene, tally

RATE, HIT, FRAMES = 250.0, 60, 100


@pytest.mark.parametrize("speed", [10_000.0, 35_000.0])
def test_a_ball_that_is_struck_is_found(speed):
    """It is a few of the markers for a short time, so no window tells how fast it is."""
    after = np.maximum(np.arange(FRAMES) - HIT, 0)[:, None] / RATE
    ball = np.array([-1200.0, 300, 900]) + speed * after * np.array([0.9, -0.3, 0.3])
    xyz = np.concatenate([dance(n=15, frames=FRAMES), ball[None]])
    rig = ring(8)
    detections, marker = observe(rig, xyz, noise=0.2, seed=1, rate=RATE)
    tracks = track_detections(detections, rig)
    seen = np.bincount(detections.frame[marker == 15], minlength=FRAMES) >= 3
    off = np.linalg.norm(tracks.cloud.xyz - ball[tracks.cloud.frame], axis=1)
    found = np.isin(np.arange(FRAMES), tracks.cloud.frame[off < 10.0])
    wanted = seen & (np.arange(FRAMES) > HIT)
    assert (found & wanted).sum() >= 0.9 * wanted.sum()


def test_at_25_hz_tracks_do_not_go_over_to_another_marker_and_back():
    """Two feet 90 mm apart had 90 swaps: tracks that met both in turn left their images to none that was right."""
    made = make(scene(3168))
    found = tally(made, track_detections(made.detections, made.rig))
    assert found.swaps <= 2
    assert found.more_found >= 0.999 * found.more
    assert found.pieces <= 1.1 * found.markers


def test_what_is_seen_for_five_frames_is_found():
    """The sixth frame does not show it, so it is set aside; but its images are nobody else's."""
    xyz = dance(n=9, frames=60)
    rig = ring(6)
    detections, marker = observe(rig, xyz, noise=0.2, seed=1, rate=25.0)
    shown = detections.keep((marker != 8) | ((detections.frame >= 20) & (detections.frame < 25)))
    cloud = track_detections(shown, rig).cloud
    off = np.linalg.norm(cloud.xyz - xyz[8, cloud.frame], axis=1)
    assert set(cloud.frame[off < 10.0].tolist()) == set(range(20, 25))


def test_at_100_hz_new_tracks_are_not_on_trial():
    """Images that a trial freed went to chance meetings: it had 99.2 % of what two cameras see."""
    made = make(scene(2109))
    found = tally(made, track_detections(made.detections, made.rig))
    assert found.two_found >= 0.993 * found.two
    assert found.ghosts <= 22


@pytest.mark.parametrize("rate", [25.0, 50.0, 250.0])
def test_a_marker_that_flickers_is_not_set_aside(rate):
    """Every track of it began in the frame before one that does not show it."""
    xyz = dance(n=9, frames=120)
    detections, marker = observe(ring(6), xyz, noise=0.2, seed=1, rate=rate)
    shown = (marker != 8) | (detections.frame % 4 != 3)
    cloud = track_detections(detections.keep(shown), ring(6)).cloud
    off = np.linalg.norm(cloud.xyz - xyz[8, cloud.frame], axis=1)
    assert len(set(cloud.frame[off < 10.0].tolist())) == 90


@pytest.mark.parametrize("rate", [25.0, 50.0])
def test_frames_that_all_cameras_lost_set_no_track_aside(rate):
    detections, _ = observe(ring(6), dance(n=9, frames=120), noise=0.2, seed=1, rate=rate)
    cloud = track_detections(detections.keep(detections.frame % 4 != 3), ring(6)).cloud
    assert len(cloud) == 810


def points(xyz, rng, sd=0.3):
    """`CandidatePoints` at xyz (G, 3) mm, known to `sd` mm in each axis, of more images or fewer."""
    n, none = len(xyz), np.zeros(len(xyz))
    cov = np.eye(3)[..., None] * np.full(n, sd**2)
    return CandidatePoints(
        none, xyz.T + sd * rng.normal(size=(3, n)), cov, none[None] - 1, none, 2 * rng.normal(size=n)
    )


@pytest.mark.parametrize("T", [0.01, 0.02])
@pytest.mark.parametrize("step", [0.0, 0.5, 1.0])
def test_no_track_goes_along_the_markers_of_a_finger(step, T):
    """They are 17 mm apart, and go aside by `step` mm a frame: at 100 Hz 1.7 m/s is no unusual speed of a person."""
    rng, finger = np.random.default_rng(0), 17.0 * np.arange(6)[:, None] * np.array([1.0, 0, 0])
    xyz = np.concatenate([finger + np.array([0, 60.0 * n, 0]) for n in range(5)])
    for _ in range(20):
        first, middle, last = (points(xyz + np.array([0, 0, step * k]), rng) for k in range(3))
        i, j, k = _triples(first, middle, last, T, Simultaneous())
        assert len(i) == len(xyz)
        assert (i == j).all()
        assert (j == k).all()


@pytest.mark.parametrize("seed", [0, 1])
def test_no_track_goes_to_and_fro_between_two_fingers(seed):
    """At 50 Hz accelerations as expected bend it by 18 mm. 3 and 24 swaps were made, as such tracks left those after
    them no image of their own marker in three frames in succession."""
    x, y = np.meshgrid(14.0 * np.arange(6), 18.0 * np.arange(5))
    rest = np.stack([x.ravel(), y.ravel(), np.full(30, 1000.0)], -1)
    xyz = rest[:, None] + 40.0 * np.sin(1.6 * np.pi * np.arange(40) / 50)[:, None] * np.array([0.6, 0.6, 0.5])
    rig = near_ring(4, radius=700.0, height=(1300.0, 1500.0), target=(35.0, 36.0, 1000.0))
    detections, _ = observe(rig, xyz, noise=0.1, rate=50.0, seed=seed)
    shown = np.random.default_rng(seed).random(len(detections.uv)) > 0.1
    assert not score(track_detections(detections.keep(shown), rig), xyz).swaps
