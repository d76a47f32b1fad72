"""Recordings shorter than a track usually is, and images that lie on nothing."""

from dataclasses import replace

import numpy as np
import pytest

from kinemark.synth.score import score
from kinemark.track.simultaneous import Simultaneous, diagnose, track_simultaneously
from support.laboratory import observe, ring
from support.motions import dance

RIG, PATHS, METHOD = ring(6), dance(n=12, frames=60, seed=31), Simultaneous()


def seen(frames):
    return observe(RIG, PATHS[:, 20 : 20 + frames], noise=0.1, cov=False)[0]


@pytest.mark.parametrize("frames", [3, 4, 5])
def test_all_markers_of_a_recording_of_a_few_frames_are_there(frames):
    """At 100 Hz a track lasts six frames at least."""
    detections = seen(frames)
    result = track_simultaneously(detections, RIG, METHOD)
    found = score(result.tracks, PATHS[:, 20 : 20 + frames])
    assert found.recall == 1 and found.extra_per_frame == 0
    assert not diagnose(detections, RIG, result)


@pytest.mark.parametrize("frames", [1, 2])
def test_fewer_frames_than_tracks_need_are_not_taken_for_a_wrong_rate(frames):
    detections = seen(frames)
    (said,) = diagnose(detections, RIG, track_simultaneously(detections, RIG, METHOD))
    assert (said.kind, said.values) == ("too_few_frames", {"frame_count": frames, "least": 3})


@pytest.mark.parametrize("change", [lambda uv: uv + 3000.0, lambda uv: uv / 1280])
def test_images_of_which_no_two_meet_give_no_tracks(change):
    """Pixels of another corner, or shares of the image."""
    detections = seen(30)
    astray = replace(detections, uv=change(np.asarray(detections.uv)))
    assert not len(track_simultaneously(astray, RIG, METHOD).tracks.cloud)
