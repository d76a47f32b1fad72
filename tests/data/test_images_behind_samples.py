"""Every sample keeps the detections that it was made of: to be shown in its images, and to be solved again."""

from dataclasses import replace

import numpy as np
import pytest

from kinemark.data import MarkerTrajectory, Matches, Origin, same
from kinemark.io.records import load, save
from kinemark.match import match
from kinemark.reconstruct import reconstruct
from kinemark.track import to_trajectories, track
from kinemark.track.simultaneous import track_detections
from support.laboratory import observe, ring
from support.motions import swarm

RIG = ring(5)


def followed():
    seen, _ = observe(RIG, swarm(n=5, frames=40), noise=0.1)
    return seen, track_detections(seen, RIG)


def matched():
    seen, _ = observe(RIG, swarm(n=5, frames=40), noise=0.1)
    return seen, track(reconstruct(match(seen, RIG), seen, RIG))


@pytest.fixture(scope="module", params=[followed, matched], ids=["simultaneous", "matched first"])
def made(request):
    seen, tracks = request.param()
    return seen, tracks, to_trajectories(tracks, RIG)


def matches_of(path, seen):
    """Samples that two or more cameras see, as matched images."""
    detection = path.detection[(path.detection >= 0).sum(1) >= 2]
    frame = seen.frame[detection.max(1)]
    return Matches(frame, detection, np.full(len(detection), np.nan), seen.n_frames)


def test_a_sample_solved_again_from_its_images_is_where_it_was(made):
    seen, _, trajectories = made
    for path in trajectories:
        matches = matches_of(path, seen)
        cloud = reconstruct(matches, seen, RIG)
        measured = np.flatnonzero(path.origin == Origin.MEASURED)
        several = (path.detection[measured] >= 0).sum(1) >= 2
        assert several.mean() > 0.9 and np.array_equal(np.unique(cloud.frame), measured[several])
        off = np.abs(cloud.xyz - path.xyz[cloud.frame]).max(1)
        assert np.quantile(off, 0.9) < 1e-3  # mm
        assert off.max() < 0.15  # mm; robust weights rest on σ, which in tracks holds what the calibration may leave


def test_a_sample_is_shown_at_its_place_in_every_image(made):
    seen, tracks, trajectories = made
    for name in trajectories.names[:3]:
        path = trajectories[name]
        for f in range(0, trajectories.n_frames, 7):
            cameras = np.flatnonzero(path.detection[f] >= 0)
            rows = path.detection[f, cameras]
            assert np.array_equal(seen.camera[rows], cameras) and (seen.frame[rows] == f).all()
            assert path.cameras[f] == sum(1 << c for c in cameras)
    rows = np.sort(np.concatenate([p.detection[p.detection >= 0] for p in trajectories]))
    own = tracks.cloud.detection[tracks.id >= 0]
    assert np.array_equal(rows, np.sort(own[own >= 0]))


def test_stretches_and_choices_of_markers_keep_their_images(made):
    _, _, trajectories = made
    part = trajectories.frames(10, 30).select(trajectories.names[::-1][:2])
    assert part.first_frame == 11 and part.names == trajectories.names[::-1][:2]
    for path in part:
        assert np.array_equal(path.detection, trajectories[path.name].detection[10:30])


def test_records_on_disk_keep_them(made, tmp_path):
    _, _, trajectories = made
    save(tmp_path / "t.h5", trajectories)
    assert same(load(tmp_path / "t.h5"), trajectories)


def test_an_edit_copies_one_marker_and_shares_the_others(made):
    _, _, trajectories = made
    first = trajectories.paths[0]
    edited = replace(trajectories, paths=(replace(first, xyz=first.xyz + 1), *trajectories.paths[1:]))
    assert all(a is b for a, b in zip(edited.paths[1:], trajectories.paths[1:], strict=True))
    assert np.shares_memory(edited.paths[0].detection, first.detection) and np.array_equal(
        edited.paths[0].cameras, first.cameras
    )


def test_cameras_follow_from_the_images_where_these_are_known():
    detection = np.array([[3, -1, 9], [-1, -1, -1], [0, 1, 2]])
    path = MarkerTrajectory.measured("a", np.ones((3, 3)), detection=detection, cameras=[7, 7, 7])
    assert path.cameras.tolist() == [5, 0, 7]
    assert MarkerTrajectory.measured("b", np.ones((3, 3)), cameras=[7, 0, 1]).cameras.tolist() == [7, 0, 1]
    assert MarkerTrajectory.measured("b", np.ones((3, 3))).detection.shape == (3, 0)
    with pytest.raises(ValueError, match="detection has shape"):
        MarkerTrajectory.measured("c", np.ones((3, 3)), detection=np.zeros((2, 4)))
