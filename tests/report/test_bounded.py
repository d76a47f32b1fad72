"""Pages stay small and short whatever a trial holds: what is drawn is bounded, and what is left out is said."""

import re

import numpy as np
import pytest

from kinemark.data import Origin
from kinemark.fill import Filled
from kinemark.findings.gaps import filling_figures
from kinemark.report.drawing_library import drawing_library
from kinemark.report.filling_page import filling_page
from kinemark.report.page import page
from kinemark.report.scene3d import scene
from kinemark.report.tables import MOST_ROWS, Table
from kinemark.report.templating import environment
from kinemark.report.thin import MOST_MARKERS, fullest, thinned
from support.drawings import checked
from support.many_tracks import fragments, long_trial

MOST_BYTES = 1_000_000


@pytest.fixture(scope="module")
def many(tmp_path_factory):
    """The page of a trial of 1 000 tracks with long names."""
    folder = tmp_path_factory.mktemp("many")
    trial = long_trial(1000, 2000, name="Subject_with_a_name:a_marker_with_a_longer_name_{}")
    return page(**trial, library=drawing_library(folder / "report.html", folder / "assets"))


def test_a_page_of_a_thousand_tracks_stays_below_a_megabyte(many):
    assert len(many.encode()) < MOST_BYTES


def test_what_is_left_out_is_said(many):
    assert f"And {1000 - MOST_ROWS} more, in quality.json" in many
    assert f"{1000 - MOST_MARKERS} others" in many
    rows = many.split("<h3>Every marker</h3>")[1].split("</table>")[0]
    assert rows.count("<tr") == 1 + MOST_ROWS


@pytest.mark.parametrize("n_cameras", [4, 40])
def test_more_cameras_do_not_make_more_pictures(n_cameras, tmp_path):
    trial = long_trial(5, 300, cameras=n_cameras)
    html = page(**trial, library=drawing_library(tmp_path / "report.html", tmp_path / "assets"))
    assert len(html.encode()) < MOST_BYTES


def test_a_page_of_a_thousand_gaps_stays_below_a_megabyte():
    before = fragments(200, 2000)
    donors = before.names[:4]
    listed = [
        {
            "marker": path.name, "first_frame": 100 + k, "last_frame": 110 + k, "frames": 11, "first_s": k / 50,
            "length_s": 0.22, "method": "body", "expected_mm": 1.0, "sd_max_mm": 1.0, "tests": 5,
            "trimmed": [], "suspicious": [],
            "reference_markers": list(donors), "state": "filled", "candidates_mm": {"body": 1.0, "spline": 2.0},
        }
        for path in before for k in range(0, 1000, 200)
    ]  # fmt: skip
    figures = filling_figures(Filled(before, ()), before, source="s", method="auto", limit_mm=20.0)
    html = filling_page(figures=figures | {"list": listed, "gaps": len(listed)}, trajectories=before)
    assert len(html.encode()) < MOST_BYTES and f"of {len(listed)} gaps" in html


def test_the_fullest_markers_are_drawn_in_the_order_of_the_trial():
    trajectories = fragments(30, 300, length=200)
    some, others = fullest(trajectories, 10)
    samples = {path.name: int((path.origin != Origin.MISSING).sum()) for path in trajectories}
    assert min(samples[name] for name in some.names) >= max(samples[name] for name in others.names)
    assert sorted(some.names, key=trajectories.names.index) == list(some.names)
    assert set(some.names) | set(others.names) == set(trajectories.names)
    assert fullest(trajectories, 99)[1].names == ()


def test_every_other_track_is_drawn_too():
    trial = long_trial(200, 500)
    fig = checked(scene(trial["rig"], trial["tracks"], trial["trajectories"]))
    (rest,) = [trace for trace in fig.data if trace.name == f"{200 - MOST_MARKERS} others"]
    breaks = np.isnan(np.asarray(rest.x, float)).sum()
    assert breaks == 200 - MOST_MARKERS


@pytest.mark.parametrize("n", [1, 7, 400, 401, 5000])
def test_curves_at_equal_steps_keep_extremes_and_their_time(n):
    values = np.random.default_rng(n).normal(size=n)
    values[n // 2] = 50.0
    curve = thinned(values, 400)
    assert len(curve.values) <= 400 and curve.values.max() == 50.0 and curve.values.min() == values.min()
    place = curve.start + curve.step * int(curve.values.argmax())
    assert abs(place - n // 2) <= max(curve.step, 0.5)
    axis = curve.at(50.0, first=2.0)
    assert axis["x0"] == pytest.approx(2 + curve.start / 50) and axis["dx"] == pytest.approx(curve.step / 50)


def test_tables_fold_and_count_what_they_leave_out():
    def rows(n):
        module = environment().get_template("macros.html").module
        return str(module.table(Table(["name", "value"], [[f"row {k}", str(k)] for k in range(n)])))

    assert "unfold" not in rows(25) and 'class="more"' not in rows(25)
    assert "Show all 26 rows" in rows(26) and rows(26).count("<tr>") == 27
    assert re.search(r"And 7 more, in quality\.json", rows(MOST_ROWS + 7))
