"""A camera that was moved shows no place in the frames in which it fits the others no more, and in others it does."""

import numpy as np
import pytest

from kinemark.data import KinemarkError, MarkerTrajectory, Trajectories
from kinemark.data.edits import ImagePoint
from kinemark.edit.values import Footage, solve, with_image
from kinemark.engine.editing.editing import Editing
from kinemark.engine.editing.journal import Journal
from kinemark.geometry import project
from support.laboratory import ring

RIG = ring(4)
PLACE = np.array([100.0, -200.0, 900.0])
OF = Footage(1, 100.0, None, RIG, left_out=(("c1", 11, 20),))
IMAGES = {camera.name: tuple(project(camera, PLACE[None])[0].tolist()) for camera in RIG}
MOVED = {**IMAGES, "c1": (IMAGES["c1"][0] + 40.0, IMAGES["c1"][1])}


def test_its_images_count_where_it_fits_alone():
    two = {name: IMAGES[name] for name in ("c0", "c1")}
    for frame in (10, 21):
        np.testing.assert_allclose(solve(OF, frame, two).xyz, PLACE, atol=1e-6)
    assert solve(OF, 11, two) is None and solve(OF, 20, two) is None
    np.testing.assert_allclose(solve(OF, 15, MOVED).xyz, PLACE, atol=1e-6)
    assert np.linalg.norm(solve(OF, 10, MOVED).xyz - PLACE) > 5
    assert [name for name, *_ in OF.images_of(15, PLACE)] == ["c0", "c2", "c3"]
    assert [name for name, *_ in OF.images_of(21, PLACE)] == ["c0", "c1", "c2", "c3"]


def test_whoever_says_where_a_marker_is_in_them_is_told(tmp_path):
    path = MarkerTrajectory.measured("LKNE", np.tile(PLACE, (30, 1)))
    editing = Editing("walk", Journal.of(tmp_path, "walk"), Trajectories((path,), 100.0), rig=RIG, left_out=OF.left_out)
    with pytest.raises(KinemarkError, match="c1 was moved, and fits the other cameras no more in frame 15"):
        editing.put_in_images("LKNE", 15, {name: MOVED[name] for name in ("c0", "c1")})
    with pytest.raises(KinemarkError, match="Click the marker in other cameras"):
        editing.image("c1", 15, *MOVED["c1"], "LKNE")
    editing.put_in_images("LKNE", 15, {name: MOVED[name] for name in ("c0", "c2")})
    after, result = with_image(path, ImagePoint("c1", 15, *MOVED["c1"], "LKNE"), OF)
    assert after is path and result.outcome == "orphan" and "was moved" in result.reason
