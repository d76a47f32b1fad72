"""Every sample keeps the detections that it was made of: to be shown in its images, and to be solved again."""

from dataclasses import replace

import numpy as np
import pytest

from kinemark.data import Fills, MarkerTrajectory, Origin, Trajectories, images_of, matches_of, same
from kinemark.fill import Linear, Rays, fill, fill_recording
from kinemark.fill.fill_recording import Filling
from kinemark.io.records import load, save
from kinemark.match import match
from kinemark.reconstruct import reconstruct
from kinemark.track import to_trajectories, track
from kinemark.track.simultaneous import track_detections
from support.laboratory import observe, ring
from support.motions import body, swarm

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


def test_a_sample_solved_again_from_its_images_is_where_it_was(made):
    seen, _, trajectories = made
    for path in trajectories:
        matches = matches_of(trajectories, path.name, seen)
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
            images = images_of(trajectories, name, f, seen)
            for c in range(len(seen.cameras)):
                if images.detection[c] < 0:
                    assert np.isnan(images.uv[c]).all()
                else:
                    assert seen.camera[images.detection[c]] == c and seen.frame[images.detection[c]] == f
                    assert np.array_equal(images.uv[c], seen.uv[images.detection[c]])
            assert path.cameras[f] == sum(1 << c for c in np.flatnonzero(images.detection >= 0))
    rows = np.sort(np.concatenate([p.detection[p.detection >= 0] for p in trajectories]))
    own = tracks.cloud.detection[tracks.id >= 0]
    assert np.array_equal(rows, np.sort(own[own >= 0]))


def test_stretches_and_choices_of_markers_keep_their_images(made):
    seen, _, trajectories = made
    part = trajectories.frames(10, 30).select(trajectories.names[::-1][:2])
    assert part.first_frame == 11 and part.names == trajectories.names[::-1][:2]
    for f in (0, 7, 19):
        assert same(images_of(part, part.names[0], f, seen), images_of(trajectories, part.names[0], f + 10, seen))


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


def test_other_detections_are_refused(made):
    seen, _, trajectories = made
    with pytest.raises(ValueError, match="Give those that the trajectories were made of"):
        images_of(trajectories, "*1", 0, seen.select(seen.cameras[:3]))
    with pytest.raises(ValueError, match="Give those"):
        matches_of(trajectories, "*1", seen.keep(np.arange(len(seen)) < 5))
    unknown = Trajectories((MarkerTrajectory.measured("a", np.ones((3, 3))),), 100.0)
    assert (images_of(unknown, "a", 0, seen).detection == -1).all() and not len(matches_of(unknown, "a", seen))


def test_filled_samples_have_the_images_that_told_of_them_and_no_others():
    """A marker is seen by one camera alone for 45 frames: its images there are that camera's."""
    seen, shown = observe(RIG, body(130), noise=0.1)
    hidden = (shown == 0) & (seen.frame >= 40) & (seen.frame < 85)
    seen = seen.keep(~hidden | (seen.camera == 1))
    tracks = track_detections(seen, RIG)
    measured = to_trajectories(tracks, RIG)
    plain = fill(measured, method=Linear(), limit_mm=np.inf).trajectories
    filled = fill_recording(measured, Rays.left_by(tracks, seen, RIG), method=Filling(limit_mm=1e6)).trajectories
    told = 0
    for path, other, before in zip(filled, plain, measured, strict=True):
        new = path.origin == Origin.FILLED
        assert np.array_equal(path.detection[~new], before.detection[~new])
        assert (other.detection[other.origin == Origin.FILLED] == -1).all()
        known = path.detection[new] >= 0
        assert not known[:, [0, 2, 3, 4]].any()
        told += known.sum()
    assert told > 20
    fills = Fills.between(measured, filled)
    assert same(fills.on(measured).xyz, filled.xyz)
    assert all(same(a.detection, b.detection) for a, b in zip(fills.on(measured), filled, strict=True))
