"""Tracks that go on by one image alone, into which another ran, or out of which one came."""

import numpy as np
import pytest

from kinemark.data import Cloud, Detections, Tracks
from kinemark.track.simultaneous.detection_index import read_images
from kinemark.track.simultaneous.lone_images import LONGEST, by_lone_images
from support.laboratory import ring

FRAMES, CHANGE, R, RIG = 20, 10, 10.0, ring(3)
BESIDE = 12.0


def crowd(rng, n=25):
    """(n, 2) px, none nearer than R to another."""
    uv = np.empty((0, 2))
    while len(uv) < n:
        new = rng.uniform(300, 420, 2)
        if not len(uv) or np.linalg.norm(uv - new, axis=1).min() > R:
            uv = np.vstack([uv, new])
    return uv


def listed(beside, *, third=False, missing=()):
    """First and last frames of what is listed of a track of camera 0, of camera 1 up to CHANGE or throughout, and of
    camera 2 after it. In camera 0 another image is `beside` (F) px, NaN for none, and a crowd."""
    rng, there = np.random.default_rng(4), ~np.isin(np.arange(FRAMES), missing)
    own = np.stack([there, there & ((np.arange(FRAMES) < CHANGE) | third), there & (np.arange(FRAMES) >= CHANGE)])
    rows, counts, image = [], np.zeros((3, FRAMES), int), np.full((FRAMES, 3), -1)
    for camera, frame in np.ndindex(3, FRAMES):
        mine = np.array([[100.0 + frame, 100.0]])[: int(own[camera, frame])]
        others = [crowd(rng), [[100.0 + frame + beside[frame], 100.0]] * int(np.isfinite(beside[frame]))]
        uv = np.vstack([mine, *(np.reshape(one, (-1, 2)) for one in others)]) if camera == 0 else mine
        image[frame, camera] = sum(map(len, rows)) if len(mine) else -1
        rows.append(uv)
        counts[camera, frame] = len(uv)
    images = read_images(Detections.build(RIG.names, 100.0, counts, np.vstack(rows)), RIG)
    n, start = int(there.sum()), np.concatenate([[0], np.cumsum(there)])
    cloud = Cloud(100.0, start, np.zeros((n, 3)), np.tile(np.eye(3), (n, 1, 1)), np.zeros(n), image[there])
    track, first, last = by_lone_images(Tracks(cloud, np.zeros(n, np.int64)), image[there] >= 0, images)
    assert not track.any()
    return list(zip(first.tolist(), last.tolist(), strict=True))


def until(px):
    return np.where(np.arange(FRAMES) < CHANGE, px, np.nan)


def test_a_track_goes_on_by_the_image_into_which_another_ran_or_out_of_which_one_came():
    assert listed(until(BESIDE)) == [(CHANGE - 1, CHANGE)]
    assert listed(np.where(np.isnan(until(BESIDE)), BESIDE, np.nan)) == [(CHANGE - 1, CHANGE)]


def test_another_camera_tells_that_it_goes_on():
    assert listed(until(BESIDE), third=True) == []


@pytest.mark.parametrize("beside", [np.full(FRAMES, BESIDE), np.full(FRAMES, np.nan), until(2 * R)])
def test_an_image_that_stays_alone_or_in_company_is_the_same_markers(beside):
    assert listed(beside) == []


@pytest.mark.parametrize("gap", [LONGEST, LONGEST + 1])
def test_over_long_gaps_motion_tells(gap):
    missing = range(CHANGE, CHANGE + gap - 1)
    assert listed(until(BESIDE), missing=missing) == [(CHANGE - 1, CHANGE - 1 + gap)] * (gap == LONGEST)
