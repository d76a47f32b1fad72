"""Points outside the control volume are left out, whatever tracks them, and never without a word."""

import numpy as np
import pytest

from kinemark.engine.session import Session
from support.findings import found
from support.named_sessions import session_of
from support.sessions import POINTS, folder_of


@pytest.mark.parametrize("method", ["simultaneous", "extrapolation_ladder", "kiss_tracking", "distance_only"])
def test_no_tracker_drops_points_without_a_word(tmp_path, method):
    low, high = POINTS.min((0, 1)) - 1, POINTS.max((0, 1)) + 1
    high[0] = np.median(POINTS[..., 0])
    folder = folder_of(tmp_path, more=f"[reconstruct]\nvolume_margin = 0.0\n[track]\nmethod = {method!r}\n")[0]
    text = (folder / "session.toml").read_text()
    (folder / "session.toml").write_text(f"volume_mm = [{low.tolist()}, {high.tolist()}]\n{text}")
    figures = Session.open(folder).run(to="quality")["one"].quality
    (said,) = found(figures, "points_dropped_outside")
    assert abs(said.values["points"] - (POINTS[..., 0] > high[0]).sum()) <= 3


@pytest.mark.parametrize(
    ("volume", "unit"),
    [
        ([[-3.0, -3.0, 0.0], [3.0, 3.0, 3.0]], "m"),  # nothing is left to name: this ended in a TypeError
        ([[-3000.0, -3000.0, 950.0], [3000.0, 3000.0, 3000.0]], None),  # pelvis alone: a camera was blamed
    ],
    ids=["metres", "too high"],
)
def test_a_wrong_volume_is_the_only_cause_that_is_named(tmp_path, volume, unit):
    folder = session_of(tmp_path, "walk01")
    text = (folder / "session.toml").read_text()
    (folder / "session.toml").write_text(f"volume_mm = {volume}\n{text}")
    figures = Session.open(folder).run(to="quality")["walk01"].quality
    (said,) = found(figures, "points_dropped_outside")
    assert (said.severity, said.values["unit"], figures["verdict"]["grade"]) == ("red", unit, "red")
    kinds = {one["kind"] for one in figures["findings"]}
    assert not {"camera_fits_nothing", "markers_not_found", "markers_never_seen"} & kinds
