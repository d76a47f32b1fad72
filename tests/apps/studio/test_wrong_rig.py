"""The studio shows a trial by the cameras that it was reconstructed with, and takes clicks by them."""

import json

import numpy as np
import pytest

pytest.importorskip("fastapi", reason="the studio's dependencies are absent: pip install 'kinemark[studio]'")

from kinemark.engine.session import Session
from support.studio import Studio
from support.wrong_rig import GAP, MARKER, TOUCHED, wrong_session


@pytest.fixture(scope="module")
def wrong(tmp_path_factory):
    """The file states a camera as it was before it was bumped."""
    made = wrong_session(tmp_path_factory.mktemp("studio"), "bumped")
    Session.open(made.folder).run(["walk"], to="track")
    return made


def seen(camera, xyz):
    """u, v px as the page projects, but for the lens of the laboratory, which has one term."""
    q = np.array(camera["R"]) @ xyz + camera["t"]
    x = q[:2] / q[2]
    K, k1 = np.array(camera["K"]), camera["distortion"][0]
    return K[:2, :2] @ (x * (1 + k1 * (x @ x))) + K[:2, 2]


def test_the_page_projects_with_the_trials_cameras_and_a_place_of_two_clicks_is_the_markers(wrong):
    studio = Studio(wrong.folder)
    f = (GAP.start + GAP.stop) // 2
    camera = studio.page.get(studio.trial).json()["cameras"][TOUCHED]
    assert np.linalg.norm(seen(camera, wrong.xyz[3, f]) - wrong.shown(TOUCHED, 3, f)) < 0.5  # 12 px by the file
    answer = studio.page.get(f"{studio.trial}/paths?view=edited")
    about = json.loads(answer.headers["x-kinemark-paths"])
    m, n = len(about["names"]), about["n_frames"]
    xyz = np.frombuffer(answer.body[: m * n * 12], "<f4").reshape(m, n, 3)
    track = about["names"][int(np.nanmedian(np.linalg.norm(xyz - wrong.xyz[MARKER], axis=2), axis=1).argmin())]
    assert studio.act(kind="claim", track=track, name="LKNE").status == 200
    clicks = [dict(zip("uv", map(float, wrong.shown(c, MARKER, f)), strict=True)) | {"camera": f"c{c}"}
              for c in (TOUCHED, 4)]  # fmt: skip
    done = studio.act(kind="put", marker="LKNE", frame=f + 1, clicks=clicks).json()
    assert [one["outcome"] for one in done["outcomes"]] == ["held"]
    answer = studio.page.get(f"{studio.trial}/paths?view=edited&marker=LKNE")
    placed = np.frombuffer(answer.body[: n * 12], "<f4").reshape(n, 3)[f]
    assert np.linalg.norm(placed - wrong.xyz[MARKER, f]) < 1.5  # 33 mm by the file
