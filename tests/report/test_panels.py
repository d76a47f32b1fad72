"""Panels of a figure stand where Plotly's own `make_subplots` puts them, and share their axes."""

import numpy as np
import pytest
from plotly.subplots import make_subplots

from kinemark.report.panels import axis_title, panel, panels
from kinemark.report.stride_panels import band, directions, line, stride_figure, upright
from support.drawings import checked

SHAPES = [(1, 1, None), (1, 3, None), (3, 1, None), (2, 4, None), (1, 3, "y"), (3, 1, "x")]


@pytest.mark.parametrize(("rows", "columns", "shared"), SHAPES)
def test_places_titles_and_shared_axes_are_plotlys(rows, columns, shared):
    n, gaps = rows * columns, (0.06 if columns > 1 else 0.0, 0.2 / rows if rows > 1 else 0.0)
    titles = [f"panel {k}" for k in range(n)]
    ours = panels(300, (rows, columns), [({}, {})] * n, titles=titles, gaps=gaps, shared=shared)
    theirs = make_subplots(
        rows=rows, cols=columns, subplot_titles=titles, horizontal_spacing=gaps[0], vertical_spacing=gaps[1],
        shared_xaxes=shared == "x", shared_yaxes=shared == "y",
    ).layout  # fmt: skip
    ours = checked(ours).layout
    for k in range(n):
        for axis in "xy":
            name = f"{axis}axis{k + 1 if k else ''}"
            assert ours[name].domain == pytest.approx(theirs[name].domain)
            assert [ours[name][key] for key in ("anchor", "matches", "showticklabels")] == [
                theirs[name][key] for key in ("anchor", "matches", "showticklabels")
            ]
    for mine, other in zip(ours.annotations, theirs.annotations, strict=True):
        assert (mine.text, mine.font.size) == (other.text, other.font.size)
        assert (mine.x, mine.y) == pytest.approx((other.x, other.y))


def test_what_an_axis_has_besides_goes_beside_the_house_style():
    fig = checked(panels(300, (1, 2), [(axis_title("time (s)"), {"range": [0, 1]}), (axis_title(None), {})]))
    assert (fig.layout.xaxis.title.text, fig.layout.xaxis2.title.text) == ("time (s)", None)
    assert fig.layout.xaxis.title.standoff == fig.layout.xaxis2.title.standoff == 10
    assert fig.layout.yaxis.range == (0, 1) and fig.layout.yaxis.gridcolor == fig.layout.yaxis2.gridcolor
    assert panel(0) == {"xaxis": "x", "yaxis": "y"} and panel(1) == {"xaxis": "x2", "yaxis": "y2"}


def test_parts_of_a_stride_stand_in_their_panels():
    y = np.linspace(0, 50, 101)
    y[40:50] = np.nan
    traces = [*band(y - 1, y + 1, "#0072B2", 1), line(y, "#0072B2", "left", 1)]
    fig = stride_figure(["hip", "knee", "", "foot"], traces, [upright(60.0, "#0072B2", 1)], directions("up", "down", 3))
    fig = checked(fig)
    assert [(t.fill, t.xaxis, t.yaxis) for t in fig.data] == [("toself", "x2", "y2")] * 2 + [(None, "x2", "y2")]
    (shape,) = fig.layout.shapes
    assert (shape.x0, shape.x1, shape.y0, shape.y1, shape.xref, shape.yref) == (60, 60, 0, 1, "x2", "y2 domain")
    words = {one.text: (one.xref, one.yref, one.y) for one in fig.layout.annotations if one.text in ("up", "down")}
    assert words == {"up": ("x4 domain", "y4 domain", 1.0), "down": ("x4 domain", "y4 domain", 0.0)}
    below = [fig.layout[f"xaxis{k}"].title.text for k in ("", "2", "3", "4")]
    assert below == [None, "stride (%)", None, "stride (%)"], "below the lowest panel of a column that has one"
