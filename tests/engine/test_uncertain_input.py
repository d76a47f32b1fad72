"""Input that is not what it says, from the files to report and quality.json: every way of tracking survives it.

It also says what it noticed, and the verdict is not green; of the same recording with nothing wrong it is.
"""

import json
from dataclasses import replace

import numpy as np
import pytest
from markupsafe import escape

from kinemark.data import Rig
from kinemark.engine.session import Session
from kinemark.io.records import save
from kinemark.io.rig_toml import read_rig_toml, write_rig_toml
from kinemark.synth.score import score
from support.findings import found
from support.laboratory import observe, ring
from support.motions import dance
from support.schema import check_quality

RIG, PATHS = ring(6), dance(n=10, frames=60)
SEEN, _ = observe(RIG, PATHS, noise=0.1)
HALF = 30

METHODS = {
    "simultaneous": ("good", "out of order", "shifted", "rate", "stops", "moved"),
    "extrapolation_ladder": ("good", "out of order", "shifted", "rate", "stops", "moved"),
    "kiss_tracking": ("good", "rate", "moved"),
    "swamidas": ("good", "stops"),
    "distance_only": ("shifted",),
}


def moved(camera, by, since=0):
    """The detections with the images of one camera elsewhere from a frame on."""
    those = (SEEN.camera == camera) & (SEEN.frame >= since)
    return replace(SEEN, uv=SEEN.uv + those[:, None] * np.array(by))


def in_order(order):
    """The rig with its cameras in another order under the same names."""
    return Rig(tuple(replace(RIG[k], name=name) for k, name in zip(order, RIG.names, strict=True)))


CASES = {
    "good": (SEEN, RIG),
    "out of order": (SEEN, in_order([0, 4, 2, 3, 1, 5])),
    "shifted": (moved(3, [2.0, 0.0]), RIG),
    "rate": (replace(SEEN, rate=5000.0), RIG),
    "stops": (SEEN.keep((SEEN.camera != 1) | (SEEN.frame < HALF)), RIG),
    "moved": (moved(5, [15.0, 6.0], HALF), RIG),
}


def since(one, first):
    """Whether a finding is about the frames from `first`, counted from 0, to the last of the recording."""
    return one.frames == ((first + 1, PATHS.shape[1]),)


WANTED = {
    "out of order": ("cameras_swapped", lambda one: one.cameras[:2] == ("c1", "c4")),
    "put in order": ("cameras_put_in_order", lambda one: one.values["images_of_list"] == ("c4", "c1")),
    "shifted": (
        "camera_shifted camera_put_right",
        lambda one: one.cameras == ("c3",) and abs(one.values["offset_u_px"] - 2) < 0.05 and not one.frames,
    ),
    "rate": ("speeds_impossible nothing_goes_on", lambda one: one.values["rate_hz"] == 5000),
    "stops": ("camera_stopped", lambda one: one.cameras == ("c1",) and since(one, HALF)),
    "moved": ("camera_moved", lambda one: one.cameras == ("c5",) and since(one, HALF)),
}
"""What is found in each case."""


def session(folder, case, method):
    """A session of one trial on disk."""
    detections, rig = CASES[case]
    save(folder / "one.h5", detections)
    write_rig_toml(folder / "rig.toml", rig)
    (folder / "session.toml").write_text(
        'name = "uncertain"\n[calibration]\nfile = "rig.toml"\n[[trials]]\nname = "one"\ndetections = "one.h5"\n'
        f'[track]\nmethod = "{method}"\n'
    )
    return Session.open(folder)


@pytest.mark.parametrize(("method", "case"), [(method, case) for method, cases in METHODS.items() for case in cases])
def test_the_run_survives_and_says_what_is_wrong(tmp_path, method, case):
    result = session(tmp_path, case, method).run()["one"]
    quality = json.loads((result.folder / "quality.json").read_text("utf-8"))
    check_quality(quality)
    page = (result.folder / "report.html").read_text("utf-8")
    noted = [one for one in quality["findings"] if one["severity"] != "info"]
    if case == "good":
        assert [one["kind"] for one in noted] == ["calibration_verdict"]  # the rig states no error
        assert (quality["verdict"]["grade"], noted[0]["values"]["grade"]) == ("amber", "unknown")
        assert quality["verdict"]["statements"][0]["kind"] == "trial_unknown"
        assert "usable" not in quality["verdict"]["headline"] and "by the images alone" in page
        return
    wanted, right = WANTED["put in order" if (method, case) == ("simultaneous", "out of order") else case]
    assert quality["verdict"]["grade"] in (("red",) if wanted == "cameras_swapped" else ("amber", "red"))
    assert any(right(one) for kind in wanted.split() for one in found(quality, kind))
    assert all(str(escape(one["text"])) in page for one in noted)
    if case in ("shifted", "stops", "moved") or wanted == "cameras_put_in_order":  # the other cameras are enough
        scored = score(result.tracks, PATHS)
        assert scored.recall > 0.99 and scored.swaps == 0


def test_cameras_put_in_order_are_all_used_and_their_rig_is_left(tmp_path):
    result = session(tmp_path, "out of order", "simultaneous").run(to="quality")["one"]
    scored = score(result.tracks, PATHS)
    assert scored.recall > 0.99 and scored.swaps == 0 and scored.extra_per_frame == 0
    assert min(camera["used_share"] for camera in result.quality["cameras"]) > 0.95
    assert not found(result.quality, "cameras_swapped")
    for was, now in zip(RIG, read_rig_toml(result.folder / "rig.toml"), strict=True):
        assert was.name == now.name and np.allclose(was.centre, now.centre)


@pytest.mark.parametrize("case", ["stops", "moved"])
def test_two_cameras_have_their_troubles_too(tmp_path, case):
    """The former method: what two cameras cannot tell is not told, but the run survives."""
    detections, rig = CASES[case]
    save(tmp_path / "one.h5", detections)
    write_rig_toml(tmp_path / "rig.toml", rig)
    names = '["c0", "c1"]' if case == "stops" else '["c0", "c5"]'
    (tmp_path / "session.toml").write_text(
        f'name = "uncertain"\n[cameras]\nnames = {names}\n[calibration]\nfile = "rig.toml"\n'
        '[[trials]]\nname = "one"\ndetections = "one.h5"\n[track]\nmethod = "former_two_cameras"\n'
    )
    quality = Session.open(tmp_path).run()["one"].quality
    assert quality["verdict"]["grade"] != "green"
    if case == "stops":
        assert found(quality, "camera_stopped")[0].frames == ((HALF + 1, PATHS.shape[1]),)
