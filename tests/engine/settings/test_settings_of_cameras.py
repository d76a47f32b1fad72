"""`[detect.cameras.NAME]`: what is said of one camera goes before what is said of all, and into keys and steps."""

from types import SimpleNamespace

import numpy as np
import pytest

from kinemark.data import KinemarkError
from kinemark.detect import Centroids, detect
from kinemark.engine.graph import Graph, Stage
from kinemark.engine.progress import Watch
from kinemark.engine.recordings import methods_of
from kinemark.engine.settings import read_settings, session_schema
from kinemark.engine.store import Store

SESSION = """
name = "s"
{cameras}
[calibration]
file = "rig.toml"
[[trials]]
name = "walk"
images = "{{camera}}.mkv"
"""


def settings(tmp_path, more="", *, named=True, overrides=()):
    path = tmp_path / "session.toml"
    path.write_text(SESSION.format(cameras='[cameras]\nnames = ["left", "right"]' if named else "") + more, "utf-8")
    return read_settings(path, overrides=overrides)


def test_a_camera_has_its_own_parameters_and_those_of_all(tmp_path):
    said = settings(tmp_path, "[detect]\nmin_area = 3\nthreshold = 70\n[detect.cameras.left]\nthreshold = 40\n")
    assert said.detect == Centroids(min_area=3, threshold=70)
    assert said.detect_cameras == {"left": Centroids(min_area=3, threshold=40)}


def test_overrides_join_what_the_file_says(tmp_path):
    file = "[detect.cameras.left]\nthreshold = 40\n"
    given = ["detect.cameras.left.min_area=2", "detect.cameras.right.threshold=50"]
    said = settings(tmp_path, file, overrides=given)
    own = {"left": Centroids(threshold=40, min_area=2), "right": Centroids(threshold=50)}
    assert said.detect_cameras == own
    with pytest.raises(KinemarkError, match=r"wanted cameras\.NAME\.parameter"):
        settings(tmp_path, overrides=["detect.cameras.left=3"])


@pytest.mark.parametrize(
    ("more", "said"),
    [
        ("[detect.cameras.lefd]\nthreshold = 40", r"detect\.cameras\.lefd: no camera .*mean 'left'.*left, right"),
        ("[detect.cameras.left]\nthreshol = 40", r"detect\.cameras\.left: 'threshol' .*mean 'threshold'"),
        ("[detect.cameras.left]\nthreshold = 400", r"detect\.cameras\.left: threshold is 400"),
        ('[detect.cameras.left]\nmethod = "kiss_nearest"', "one for all cameras"),
        ("[detect]\ncameras = 3", "a table for each camera"),
        ("[detect_cameras]\nleft = 3", r"\[detect\.cameras\.NAME\]"),
    ],
)
def test_what_is_not_understood_is_named(tmp_path, more, said):
    with pytest.raises(KinemarkError, match=said):
        settings(tmp_path, more)


def test_names_are_those_of_the_calibration_where_the_session_names_none(tmp_path):
    said = settings(tmp_path, "[detect.cameras.left]\nthreshold = 40\n", named=False)
    assert list(methods_of(said, ["left", "right"])) == ["left"]
    with pytest.raises(KinemarkError, match=r"no camera has this name.*Correct"):
        methods_of(said, ["a", "b"])


def test_the_schema_knows_them():
    table = session_schema()["$defs"]["detect.centroids"]["properties"]["cameras"]
    assert table["additionalProperties"]["properties"]["threshold"]["exclusiveMaximum"] == 255
    assert "detect_cameras" not in session_schema()["properties"]


def test_detection_obeys_them():
    image = np.zeros((3, 40, 40), np.uint8)
    image[:, 10:15, 10:15] = 50
    film = SimpleNamespace(n_frames=3, batches=lambda n: iter([image]), v_offset=lambda f: 0.0)
    own = {"left": Centroids(threshold=40)}
    found = detect([film, film], cameras=["left", "right"], rate=1.0, method=Centroids(threshold=60), of_cameras=own)
    assert found.counts.tolist() == [[1, 1, 1], [0, 0, 0]]
    with pytest.raises(ValueError, match="of_cameras names middle"):
        detect([film], cameras=["left"], rate=1.0, of_cameras={"middle": Centroids()})


def test_keys_and_steps_follow(tmp_path):
    def graph(own):
        usual = Centroids(threshold=60)
        return Graph((Stage("detect", (), ("d",), lambda i, r: "x", write, read, usual, cameras=own),))

    def write(path, text):
        path.write_text(text, "utf-8")

    def read(path):
        return path.read_text("utf-8")

    own = {"left": Centroids(threshold=40)}
    assert graph({}).keys("detect") != graph(own).keys("detect")
    with Store.open(tmp_path, tmp_path / "lock", lambda done, total: None) as store:
        graph(own).run("detect", None, store, Watch())
    assert store.steps[0].parameters["cameras"] == {"left": {"threshold": 40}}
