"""Figures are plain data; Plotly's own graph objects know every key and value of every page.

The pages of gait are looked at in `tests/gait/test_comparison.py` and `tests/engine/gait/test_gait_files.py`.
"""

import json
import subprocess
import sys

import numpy as np
import plotly.graph_objects as go
import pytest

from kinemark.report.drawing import Figure
from kinemark.report.theme import figure
from support.drawings import check_page, checked
from support.pages import PAGES


@pytest.mark.parametrize("page", PAGES)
def test_plotly_knows_all_that_a_page_draws(page):
    drawn = check_page(PAGES[page]("plain"))
    assert bool(drawn) == (page != "gaps"), "gaps are drawn without Plotly"


def test_pages_are_written_without_plotlys_objects():
    """They take a tenth of a second to load, and check every value."""
    modules = ("page", "calibration_page", "sensitivity_page", "angles_page", "gait_page", "gait_comparison_page")
    code = "; ".join(f"import kinemark.report.{name}" for name in modules)
    code += (
        "; import sys; print([m for m in ('plotly.basedatatypes', 'plotly.subplots', 'narwhals') if m in sys.modules])"
    )
    said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert said.stdout.strip() == "[]"


def test_a_wrong_key_a_wrong_value_and_another_spelling_are_seen():
    good = {"x": [1.0], "y": [2.0], "mode": "lines"}
    checked(figure(100).add("scatter", **good))
    for wrong in ({"colour": "#000000"}, {"mode": "line"}):
        with pytest.raises(ValueError, match="Invalid"):
            checked(figure(100).add("scatter", **good | wrong))
    with pytest.raises(AssertionError):
        checked(figure(100, xaxis={"title": "time (s)"}))  # which the script no longer reads


@pytest.mark.parametrize(
    "values",
    [
        np.array([1.5, np.nan, np.inf], np.float32),
        np.array([[1.0, 2.0, np.nan]]),
        np.array([1, -128, 127]),
        np.array([0, 40_000]),
        np.array([0, 70_000, 2**31]),
        np.array([0, 2**40]),
        np.array([200, 3], np.uint64),
        np.array([True, False]),
        np.array(["a", "b"]),
        np.zeros(0),
        np.arange(6.0)[::2],
    ],
)
def test_arrays_are_written_as_plotly_writes_them(values):
    ours = json.loads(Figure().add("scatter", x=values).to_json())
    theirs = json.loads(go.Figure([go.Scatter(x=values)]).to_json())
    assert ours["data"] == theirs["data"]


def test_what_is_no_number_is_null_and_what_is_none_is_left_out():
    drawn = Figure().add("scatter", y=[1.0, float("nan"), np.float32(np.inf), None, np.int64(3)], name=None)
    assert json.loads(drawn.to_json())["data"] == [{"type": "scatter", "y": [1.0, None, None, None, 3]}]


def test_parts_are_put_together_with_what_is_there():
    drawn = (
        figure(100, yaxis2={"side": "right"}).y_axes(title={"text": "mm"}).shape(x0=1).shape(x0=2).annotate(text="a")
    )
    assert drawn.layout["yaxis"]["title"] == {"standoff": 10, "text": "mm"}
    assert drawn.layout["yaxis2"] == {"side": "right", "title": {"text": "mm"}}
    assert "text" not in drawn.layout["xaxis"]["title"]
    assert [one["x0"] for one in drawn.layout["shapes"]] == [1, 2] and len(drawn.layout["annotations"]) == 1
