"""Tracks that are images in a mirror: a wet floor and a wall show them, and nobody who moves both sides alike does."""

import numpy as np
import pytest

from kinemark.data import Cloud, Rig, Tracks
from kinemark.report.words import advice_of, text_of
from kinemark.track.simultaneous import diagnose, track_simultaneously
from kinemark.track.simultaneous.diagnosis.mirror_images import mirror_images
from kinemark.track.simultaneous.simultaneous_method import DEFAULT
from support.laboratory import camera, observe, ring

FRAMES = 150
TO_ONE_SIDE = Rig(tuple(camera(f"c{k}", (1500.0 * k - 2000, 3500.0, 1500 + 300 * k)) for k in range(4)))


def moving(rng, n=10, frames=FRAMES):
    """(n, F, 3) mm of markers that go about together, each with a motion of its own besides."""
    t = np.arange(frames)[:, None] / 100
    way = 300 * np.sin(2 * np.pi * 0.5 * t + rng.uniform(0, 6, 3)) * [1, 1, 0]
    own = 60 * np.sin(2 * np.pi * (0.5 + rng.uniform(0, 1, (n, 1, 1))) * t + rng.uniform(0, 6, (n, 1, 3)))
    return rng.uniform([-300, -300, 100], [300, 300, 1700], (n, 3))[:, None] + way + own


def mirrored(xyz, normal, d):
    n = np.asarray(normal, float)
    return xyz - 2 * (xyz @ n - d)[..., None] * n


def tracks_of(xyz, rng, sd=1.0, seen=0.7):
    """Tracks with noise, in a random share of the frames."""
    frame, number = np.nonzero(((rng.random(xyz.shape[:2]) < seen) & np.isfinite(xyz[..., 0])).T)
    n = len(frame)
    start = np.searchsorted(frame, np.arange(xyz.shape[1] + 1))
    noisy = xyz[number, frame] + rng.normal(0, sd, (n, 3))
    cloud = Cloud(100.0, start, noisy, np.tile(sd**2 * np.eye(3), (n, 1, 1)), np.full(n, 0.2), np.zeros((n, 4), int))
    return Tracks(cloud, number)


@pytest.mark.parametrize(("normal", "d"), [((0, 0, 1), 0.0), ((0.6, 0.8, 0), -1500.0), ((0, 0.28, 0.96), -400.0)])
def test_images_in_a_plane_are_told_and_nothing_else(normal, d):
    rng = np.random.default_rng(301)
    xyz = moving(rng)
    tracks = tracks_of(np.concatenate([xyz, mirrored(xyz, normal, d)[:6]]), rng)
    rig = Rig(tuple(camera(f"c{k}", (400.0 * k, 3000 - 200 * k, 1500)) for k in range(4)))
    assert mirror_images(tracks, rig).tolist() == list(range(10, 16))


def test_short_pieces_of_images_are_told_as_well():
    """Also of three frames, none of which is looked at for pairs."""
    rng = np.random.default_rng(313)
    xyz = moving(rng, frames=1200)
    images = mirrored(xyz, (0, 0, 1), 0.0)
    pieces = np.full((4, 1200, 3), np.nan)
    for k in range(4):
        pieces[k, 300 * k + 4 : 300 * k + 7] = images[6, 300 * k + 4 : 300 * k + 7]
    tracks = tracks_of(np.concatenate([xyz, images[:6], pieces]), rng, seen=1.0)
    assert mirror_images(tracks, TO_ONE_SIDE).tolist() == list(range(10, 20))


def test_a_wall_shows_what_is_hidden_from_the_cameras():
    """Most of what is behind it is no image of a marker that is seen itself."""
    rng = np.random.default_rng(314)
    xyz = moving(rng, 14)
    tracks = tracks_of(np.concatenate([xyz[:4], mirrored(xyz, (0, 1, 0), -1500.0)]), rng)
    assert mirror_images(tracks, TO_ONE_SIDE).tolist() == list(range(4, 18))


def test_images_in_two_mirrors_are_told():
    rng = np.random.default_rng(302)
    xyz = moving(rng)
    tracks = tracks_of(np.concatenate([xyz, mirrored(xyz, (0, 0, 1), 0)[:5], mirrored(xyz, (0, 1, 0), -1500)[:5]]), rng)
    assert mirror_images(tracks, TO_ONE_SIDE).tolist() == list(range(10, 20))


def both_sides(rng, apart):
    """Somebody who moves left and right wholly alike, whose markers are put on within `apart` mm."""
    left = moving(rng) + np.array([0, 900, 0])
    return np.concatenate([left, mirrored(left, (0, 1, 0), 0) + rng.normal(0, apart, (10, 1, 3))])


@pytest.mark.parametrize("seed", range(303, 308))
def test_left_and_right_are_no_images(seed):
    """With cameras all round none are, however alike; nor with cameras to one side, as markers are put on by hand."""
    rng = np.random.default_rng(seed)
    assert not len(mirror_images(tracks_of(both_sides(rng, 0.0), rng), ring(4)))
    assert not len(mirror_images(tracks_of(both_sides(rng, 10.0), rng), TO_ONE_SIDE))


def test_what_stands_still_is_no_image():
    rng = np.random.default_rng(308)
    still = np.repeat(rng.uniform([-300, -300, 100], [300, 300, 1700], (12, 1, 3)), FRAMES, 1)
    assert not len(mirror_images(tracks_of(still, rng), TO_ONE_SIDE))


def test_a_wet_floor_is_told():
    rng, rig = np.random.default_rng(309), ring(5, target=(0.0, 0.0, 500.0))
    xyz = moving(rng, 6) * [1, 1, 0.5]
    detections = observe(rig, np.concatenate([xyz, mirrored(xyz, (0, 0, 1), 0)]), noise=0.1, seed=309)[0]
    result = track_simultaneously(detections, rig, DEFAULT)
    (found,) = (one for one in diagnose(detections, rig, result) if one.kind == "tracks_mirrored")
    below = {
        f"*{k + 1}" for k in range(len(result.tracks)) if result.tracks.cloud.xyz[result.tracks.id == k, 2].max() < 0
    }
    assert set(found.markers) == below and len(below) >= 6
    assert "mirror images" in text_of(found) and "wet floor" in text_of(found) and advice_of(found)
