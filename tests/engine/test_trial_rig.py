"""All that comes after tracking takes the cameras that the trial was reconstructed with: fills, edits, figures.

Three sessions whose calibration file lost its lens terms, has a camera that was bumped by 12 px since, or has one that
is late by 4 ms: none of them is known from the file.
"""

import json
import shutil

import numpy as np
import pytest

from kinemark.data import Detections, Origin
from kinemark.edit.values import Footage
from kinemark.engine.editing.editing import Editing
from kinemark.engine.editing.makers import footage_of
from kinemark.engine.session import Session
from kinemark.engine.trial_rig import TrialRig
from kinemark.geometry import project
from kinemark.io.rig_toml import read_rig_toml
from kinemark.track.simultaneous.rig.moved_cameras import MovedCamera
from support.laboratory import ring
from support.wrong_rig import ALONE, GAP, MARKER, TOUCHED, wrong_session

KINDS = ("lens", "bumped", "late")
NOISE = 0.2  # px of the images


@pytest.fixture(scope="module", params=KINDS)
def wrong(request, tmp_path_factory):
    made = wrong_session(tmp_path_factory.mktemp("wrong"), request.param)
    Session.open(made.folder).run(["walk"])
    return made


@pytest.fixture
def trial(wrong):
    return Session.open(wrong.folder).trial("walk")


def of_marker(trajectories, xyz):
    """The trajectory of a marker that is at places (F, 3) mm."""
    return min(trajectories, key=lambda path: np.nanmedian(np.linalg.norm(path.xyz - xyz, axis=1)))


def test_residuals_are_those_of_the_images(wrong, trial):
    for camera in trial.quality["cameras"]:
        assert camera["used_share"] > 0.9
        assert camera["residual_median_px"] < 2 * NOISE, (
            "1.7 px by a file without lens terms, 1.6 of a camera that is late"
        )
        assert camera["residual_median_px"] > NOISE / 2
        as_calibrated, others = camera["residual_as_calibrated_px"], wrong.folder.name != "lens"
        if others and camera["name"] != f"c{TOUCHED}":
            assert as_calibrated is None, "this camera was as it was calibrated"
        else:
            assert as_calibrated > 2 * camera["residual_median_px"]
    assert not {"camera_disagrees", "cameras_agree_poorly"} & {one["kind"] for one in trial.quality["findings"]}


def test_a_fill_takes_the_image_of_the_one_camera_that_saw_it(wrong, trial):
    path = of_marker(trial.trajectories, wrong.xyz[MARKER])
    assert (path.origin[GAP] == Origin.FILLED).all()
    assert (path.detection[GAP, ALONE] >= 0).mean() > 0.9, "none, as these images refuted what was filled"
    camera, inner = wrong.true[ALONE], slice(GAP.start + 5, GAP.stop - 5)
    beside = project(camera, path.xyz[inner]) - project(camera, wrong.xyz[MARKER, inner])
    assert np.linalg.norm(beside, axis=1).max() < 1.0


def test_a_place_clicked_in_two_images_is_where_the_marker_is(wrong, tmp_path):
    shutil.copytree(wrong.folder, folder := tmp_path / "own")
    editing = Editing.of_trial(Session.open(folder).trial("walk"))
    track = of_marker(editing.trajectories, wrong.xyz[MARKER]).name
    editing.claim(track, "LKNE")
    f = (GAP.start + GAP.stop) // 2
    clicks = {f"c{c}": tuple(wrong.shown(c, MARKER, f)) for c in (TOUCHED, 4)}
    said = editing.put_in_images("LKNE", f + 1, clicks)
    assert [one.outcome for one in said.applied] == ["held"]
    placed = editing.edited().trajectories["LKNE"]
    assert np.linalg.norm(placed.xyz[f] - wrong.xyz[MARKER, f]) < 1.5  # 4, 33 and 6 mm by the file
    again = Editing.of_trial(Session.open(folder).trial("walk")).edited()
    assert np.array_equal(again.trajectories["LKNE"].xyz[f], placed.xyz[f])


def test_a_place_says_where_its_pictures_show_it(wrong):
    editing = Editing.of_trial(Session.open(wrong.folder).trial("walk"))
    f = 20
    for name, *uv in footage_of(editing).images_of(f + 1, wrong.xyz[3, f]):
        assert np.linalg.norm(uv - wrong.shown(int(name[1]), 3, f)) < 0.5


def test_an_image_put_right_by_hand_makes_the_place_no_worse(wrong, tmp_path):
    shutil.copytree(wrong.folder, folder := tmp_path / "own")
    editing = Editing.of_trial(Session.open(folder).trial("walk"))
    path, f = of_marker(editing.trajectories, wrong.xyz[3]), 20
    editing.claim(path.name, "RKNE")
    u, v = wrong.shown(TOUCHED, 3, f)
    said = editing.image(f"c{TOUCHED}", f + 1, float(u), float(v), "RKNE")
    assert [one.outcome for one in said.applied] == ["held"]
    placed = editing.edited().trajectories["RKNE"]
    assert np.linalg.norm(placed.xyz[f] - wrong.xyz[3, f]) < 1.5


def test_the_trials_cameras_are_among_its_results(wrong, trial):
    kept = read_rig_toml(trial.folder / "rig.toml")
    given = Session.open(wrong.folder).calibrate().rig
    assert [np.array_equal(a.P, b.P) for a, b in zip(kept, trial.rig, strict=True)] == [True] * 6
    off = {"true": [], "stated": []}
    for c, camera in enumerate(kept):
        inside = wrong.xyz[:, ::10].reshape(-1, 3)
        for name, rig in (("true", wrong.true), ("stated", wrong.stated)):
            off[name].append(np.median(np.linalg.norm(project(camera, inside) - project(rig[c], inside), axis=1)))
    assert max(off["true"]) < 0.5, "where it looks"
    if wrong.folder.name == "late":
        assert max(off["stated"]) == 0
        said = json.loads((trial.folder / "ambiguous_decisions.json").read_text())["cameras"]
        assert said["delay_s"][TOUCHED] == pytest.approx(0.004, abs=2e-4) and sum(map(bool, said["delay_s"])) == 1
    else:
        assert max(off["stated"]) > 1.0
    assert given.names == kept.names


def test_tracks_cameras_and_images_of_a_trial_agree(trial):
    cloud, uv = trial.tracks.cloud, trial.detections_in_time.uv
    for c, camera in enumerate(trial.rig):
        own = cloud.detection[:, c] >= 0
        off = uv[cloud.detection[own, c]] - project(camera, cloud.xyz[own])
        assert np.median(np.linalg.norm(off, axis=1)) < 2 * NOISE


def test_where_a_camera_was_knocked_is_kept_with_the_results(tmp_path):
    rig = ring(3)
    moved = MovedCamera(1, 4, 8, np.array([[1, 0, 2.0], [0, 1, -1.0], [0, 0, 1.0]]))
    cameras = TrialRig.given(rig)._replace(moved=(moved,))
    cameras.save(tmp_path)
    again = TrialRig.load(tmp_path, json.loads(json.dumps(cameras.as_dict())))
    seen = Detections.build(rig.names, 100.0, np.ones((3, 8), int), np.full((24, 2), 300.0))
    for each in (cameras, again):
        there, knocked = each.seen(seen).uv, (seen.camera == 1) & (seen.frame >= 4)
        np.testing.assert_allclose(there[knocked] - 300.0, np.tile([2.0, -1.0], (4, 1)), atol=0.1)  # by an ideal lens
        np.testing.assert_array_equal(there[~knocked], 300.0)


def test_a_click_in_a_picture_of_a_knocked_camera_is_moved_as_its_images_are():
    rig = ring(3)
    cameras = TrialRig.given(rig)._replace(
        moved=(MovedCamera(1, 4, 8, np.array([[1, 0, 2.0], [0, 1, -1], [0, 0, 1]])),)
    )
    seen = Detections.build(rig.names, 100.0, np.ones((3, 8), int), np.full((24, 2), 300.0))
    of = Footage(1, 100.0, seen, rig, timed=cameras.timed(seen))
    np.testing.assert_allclose(of.late(rig.names[1], 4, np.array([310.0, 300.0])), [2.0, -1.0], atol=0.1)
    np.testing.assert_array_equal(of.late(rig.names[1], 3, np.array([310.0, 300.0])), 0.0)
