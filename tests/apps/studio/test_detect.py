"""Detection in the studio: tried in a frame, explained, written into the session, whose trials are stale then."""

import pytest

pytest.importorskip("fastapi", reason="the studio's dependencies are absent: pip install 'kinemark[studio]'")

from support.studio import Studio, file_in
from support.tried import SIZE, session_in

DIM = {"threshold": 40}


@pytest.fixture
def studio(tmp_path):
    return Studio(session_in(tmp_path, "[detect]\nthreshold = 90 # too high?\nmin_area = 6\nmax_area = 400"))


def found(studio, **draft):
    answer = studio.page.post(f"{studio.trial}/detect/frame", {"frame": 6, "draft": draft})
    assert answer.status == 200, answer.json()
    return answer.json()["cameras"]


def markers(camera):
    return [mark for mark in camera["marks"] if mark["state"] == "marker"]


def test_a_frame_is_tried_explained_and_applied(studio, tmp_path):
    trial = studio.trial
    said = studio.page.get(f"{trial}/detect").json()
    stated = {one["name"]: one["stated"] for one in said["parameters"]}
    assert stated["threshold"] == 90 and stated["max_aspect"] is None and stated["inverted"] is False
    assert (said["first"], said["last"], said["method"]) == (1, 20, "centroids")
    before = found(studio)
    assert sum(before[0]["histogram"]) == SIZE[0] * SIZE[1] and before[0]["threshold"] == 90
    assert {mark["state"] for mark in before[0]["marks"]} == {"marker", "not round", "too large", "at edge"}
    body = {"frame": 6, "camera": "c0", "u": 176, "v": 120}
    why = studio.page.post(f"{trial}/detect/why", body).json()
    assert why["parameter"] == "threshold" and 12 < why["value"] < 90 and "Lower it" in why["words"]
    tried = found(studio, every=DIM)
    assert [len(markers(camera)) for camera in tried] == [len(markers(camera)) + 1 for camera in before]
    one = found(studio, cameras={"c1": DIM})
    assert one[0] == before[0] and one[1] == tried[1]
    masks = {"c1": [[[0, 0], [239, 0], [239, 179], [0, 179]]]}
    assert {mark["state"] for mark in found(studio, masks=masks)[1]["marks"]} == {"masked"}
    assert "threshold = 90" in (tmp_path / "session.toml").read_text("utf-8"), "nothing was written so far"
    after = studio.page.post(f"{trial}/detect/apply", {"every": DIM, "masks": masks}).json()
    assert after["cameras"][1]["masks"] == masks["c1"]
    text = (tmp_path / "session.toml").read_text("utf-8")
    assert "threshold = 40 # too high?" in text and "# of the knee study" in text
    assert found(studio)[0] == tried[0]


def test_what_cannot_be_is_refused_in_words(studio):
    trial, before = studio.trial, found(studio)
    for path, body, words in (
        ("detect/frame", {"frame": 99}, "frames 1 to 20"),
        ("detect/frame", {"frame": 6, "draft": {"every": {"threshold": 300}}}, "threshold is 300"),
        ("detect/frame", {"frame": 6, "draft": {"every": {"min_area": 50, "max_area": 9}}}, "min_area"),
        ("detect/frame", {"frame": 6, "draft": {"masks": {"c0": [[[0, 0], [1, 1]]]}}}, "at least 3"),
        ("detect/frame", {"frame": 6, "cameras": ["c0", "c9"]}, "no camera c9"),
        ("detect/why", {"frame": 6, "camera": "c9", "u": 1, "v": 1}, "no camera c9"),
        ("detect/why", {"frame": 6, "camera": "c0", "u": 999, "v": 1}, "outside the image"),
        ("detect/apply", {"every": {"path": 1}}, "is not a parameter"),
        ("detect/apply", {"cameras": {"c9": {"threshold": 3}}}, "no camera c9"),
    ):
        answer = studio.page.post(f"{trial}/{path}", body)
        assert answer.status == 422 and words in answer.json()["words"], answer.json()
    assert found(studio) == before


def test_a_camera_alone_is_looked_at_as_in_all(studio):
    """So that a page shows one after the other, while what is left open is learned."""
    alone = studio.page.post(f"{studio.trial}/detect/frame", {"frame": 6, "cameras": ["c1"]}).json()["cameras"]
    assert alone == found(studio)[1:]


def test_a_threshold_in_the_noise_says_so_and_the_image_is_shown(studio):
    first = found(studio, every={"threshold": 11, "min_width": 1})[0]
    assert first["refused"] == "" or "noise" in first["refused"]
    assert sum(first["histogram"]) == SIZE[0] * SIZE[1]


def test_a_file_of_trajectories_has_no_images(tmp_path):
    file_in(tmp_path)
    studio = Studio(tmp_path)
    answer = studio.page.get(f"{studio.trial}/detect")
    assert answer.status == 422 and "it has no images" in answer.json()["words"]
