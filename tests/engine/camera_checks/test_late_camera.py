"""A camera that was started apart by whole images: after tracking its images stay where that put them."""

import shutil
from itertools import cycle

import numpy as np
import pytest

from kinemark.engine import tracking_in_time
from kinemark.engine.editing.editing import Editing
from kinemark.engine.session import Session
from kinemark.io.detections_csv import write_detections_csv
from kinemark.io.rig_toml import write_rig_toml
from support.laboratory import observe, ring
from support.motions import dance
from support.sessions import OF_FILE

FRAMES, LATE = 100, 5


def later(seen):
    """Camera c1 shows in every frame what the others show LATE frames later."""
    frame = np.where(seen.camera == 1, seen.frame - LATE, seen.frame)
    kept = seen.keep(frame >= 0)
    counts = np.zeros((len(seen.cameras), FRAMES), np.int64)
    np.add.at(counts, (kept.camera, frame[frame >= 0]), 1)
    return type(kept).build(kept.cameras, kept.rate, counts, uv=kept.uv, cov=kept.cov)


@pytest.fixture(scope="module")
def trial(tmp_path_factory):
    folder, rig = tmp_path_factory.mktemp("late"), ring(6)
    write_rig_toml(folder / "rig.toml", rig)
    write_detections_csv(folder / "one.csv", later(observe(rig, dance(n=12, frames=FRAMES), noise=0.1)[0]))
    (folder / "session.toml").write_text(OF_FILE)
    return Session.open(folder).trial("one")


def test_what_is_edited_has_the_images_of_a_late_camera_in_the_frames_of_its_points(trial):
    editing = Editing.of_trial(trial)
    for path in editing.trajectories:
        own = path.detection[:, 1]
        frame = np.flatnonzero(own >= 0)
        assert len(frame) > 80
        np.testing.assert_array_equal(editing.detections.frame[own[frame]], frame)


def test_a_late_camera_is_told_once(trial):
    found = trial.run("quality").quality["findings"]
    about = [(one["kind"], one["cameras"]) for one in found if one["kind"].startswith("camera")]
    assert about == [("camera_started_apart", ["c1"])]


def test_a_camera_whose_images_fit_no_better_in_other_frames_was_not_started_apart(trial, tmp_path, monkeypatch):
    """Images of a camera that was turned may look late; that fewer of them then fit is known from tracking."""
    images = cycle((1, 2))
    monkeypatch.setattr(tracking_in_time, "_confirmed", lambda _: next(images))
    monkeypatch.setattr(tracking_in_time, "_nearer", lambda *_: False)
    shutil.copytree(trial.workspace.root, tmp_path / "again", ignore=shutil.ignore_patterns("results"))
    found = Session.open(tmp_path / "again").trial("one").run("quality").quality["findings"]
    kinds = {one["kind"] for one in found if "c1" in one["cameras"]}
    assert kinds and not kinds & {"camera_started_apart", "camera_dropped_images"}
