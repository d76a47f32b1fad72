"""The report's page: complete, harmless, and drawn so that nothing is hidden."""

import base64
import json
import re
from dataclasses import replace

import numpy as np
import pytest
from plotly.offline import get_plotlyjs

from kinemark.data import Detections, Origin, Step, Tracks, Validity, make_finding
from kinemark.findings.cameras import upwards
from kinemark.geometry import project
from kinemark.io.images import read_image
from kinemark.report import write_report
from kinemark.report.figures_detections import SEPARATED, VALID, brightest, fullest_frames, kinds_of, spots_figure
from kinemark.report.page import figures as page_figures
from kinemark.report.scene3d import corners, scene
from kinemark.report.tables import spots_table
from kinemark.report.thin import blocks, envelope
from support.captures import RATE, camera_at, capture, judge, ring, walk
from support.drawings import checked

EVIL = '<script>alert("1")</script><a href="http://evil.example/">'


@pytest.fixture(scope="module")
def evil_page(tmp_path_factory):
    """A page whose every name is markup, without the plotly.js bundle."""
    rig = ring(names=[f"{EVIL}{c}" for c in range(4)])
    rig = replace(rig, method=EVIL)
    records = capture(rig, walk(), names=[f"{EVIL}{m}" for m in range(3)])
    steps = [Step(EVIL, EVIL, {EVIL: EVIL}, EVIL, EVIL, 1.0)]
    evil = [
        make_finding("grid_image_unused", cameras=[EVIL], reason=EVIL),
        make_finding("angle_beyond_normal", joint=EVIL, angle=EVIL, frames_share=0.5, most_deg=3.0),
    ]
    figures = judge(rig, records, session=EVIL, trial=EVIL, steps=steps, findings=evil)
    path = tmp_path_factory.mktemp("page") / "report.html"
    write_report(path, quality=figures, rig=rig, **records)
    html = path.read_text(encoding="utf-8")
    assert html.count(get_plotlyjs()) == 1
    return html.replace(get_plotlyjs(), "")


def test_the_page_loads_nothing_from_outside(evil_page):
    assert not re.search(r"""\b(src|href|action|data)\s*=\s*["']?\s*(https?:)?//""", evil_page, re.IGNORECASE)
    assert not re.search(r"@import|url\(|<link|<img|<iframe", evil_page)
    assert "default-src 'none'" in evil_page
    assert "showSendToCloud: false" in evil_page


def test_names_never_become_markup(evil_page):
    assert "<script>alert" not in evil_page
    assert '<a href="http' not in evil_page
    assert "&lt;script&gt;alert" in evil_page
    # Plotly reads markup in the names that figures show
    assert "\\u003cscript\\u003ealert" not in evil_page
    assert "\\u003ca href" not in evil_page


def test_the_page_holds_every_figure_and_term(evil_page):
    specs = dict(re.findall(r'<script type="application/json" data-for="(\w+)">(.*?)</script>', evil_page, re.DOTALL))
    assert len(specs) == 12
    assert all("data" in json.loads(spec) for spec in specs.values())
    for name in specs:
        assert f'id="{name}"' in evil_page
    for term in ("Residual", "Jitter", "Gap", "In view"):
        assert f"<dt>{term}</dt>" in evil_page
    assert "$" not in re.sub(r"<script.*?</script>", "", evil_page, flags=re.DOTALL)


def test_points_in_no_track_are_drawn_apart():
    rig = ring()
    records = capture(rig, walk(markers=3))
    tracks = Tracks(records["tracks"].cloud, np.where(records["tracks"].id == 1, -1, records["tracks"].id))
    fig = checked(scene(rig, tracks, records["trajectories"]))
    (loose,) = [t for t in fig.data if t.name == "points in no track"]
    assert np.allclose(np.stack([loose.x, loose.y, loose.z], 1), walk(markers=3)[1], atol=1e-3)


def test_lines_break_at_gaps_and_the_timeline_hides_none():
    xyz = walk(markers=2, frames=5000)
    xyz[0, 777] = np.nan  # a single frame, though each column stands for five
    xyz[1, 1000:1500] = np.nan
    rig = ring(3)
    records = capture(rig, xyz)
    drawn = page_figures(judge(rig, records), rig, records["detections"], records["tracks"], records["trajectories"])
    drawn = {name: checked(drawn[name]) for name in ("timeline", "trajectories")}
    timeline = drawn["timeline"].data[0]
    k = round(timeline.dx * RATE)
    row = list(drawn["timeline"].layout.yaxis.ticktext).index("m0")
    assert np.flatnonzero(timeline.z[row] == Origin.MISSING).tolist() == [777 // k]
    for trace in drawn["trajectories"].data[3:]:
        x = trace.x0 + trace.dx * np.arange(len(trace.y))
        inside = (x > 1010 / RATE) & (x < 1490 / RATE)
        assert inside.any()
        assert not trace.connectgaps
        assert np.isnan(trace.y[inside]).all()


@pytest.mark.parametrize("n", [1, 7, 1000, 1001, 4999])
def test_envelope_keeps_spikes_extremes_and_order(n):
    values = np.random.default_rng(n).normal(size=n)
    values[n // 2] = 50.0
    frame, thin = envelope(values, 200)
    assert len(frame) == len(thin) <= 200
    assert (np.diff(frame) >= 0).all()
    assert np.array_equal(values[frame], thin)
    assert thin.max() == 50.0
    assert thin.min() == values.min()


def test_blocks_cover_everything_once():
    assert np.asarray(blocks(np.arange(10), 4)).tolist() == [[0, 1, 2], [3, 4, 5], [6, 7, 8], [9, 9, 9]]
    assert blocks(np.zeros((2, 0)), 4).size == 0


def test_frustum_corners_project_to_the_corners_of_the_image():
    camera = replace(camera_at("a", 30), distortion=np.zeros(5))
    wanted = np.array([[0, 0], [640, 0], [640, 480], [0, 480]]) - 0.5
    assert project(camera, corners(camera, 500.0)) == pytest.approx(wanted)
    assert corners(camera, 500.0) @ camera.R[2] + camera.t[2] == pytest.approx(500.0)


def test_the_scene_stands_on_its_floor_whichever_axis_points_up():
    rig = ring(4)
    assert upwards(rig) == 2
    turn = np.array([[0.0, 1, 0], [0, 0, 1], [1, 0, 0]])  # z up becomes y up
    turned = replace(rig, cameras=tuple(replace(c, R=c.R @ turn.T) for c in rig))
    assert upwards(turned) == 1


# -- what was detected -------------------------------------------------------------------------------------------------


def spots():
    """Two cameras, three frames; the first camera has most to tell in frame 2, the second in none."""
    validity = np.zeros(14, np.uint8)
    validity[[1, 6, 7]] = Validity.TOO_SMALL, Validity.AT_EDGE, Validity.MASKED
    merged = np.zeros(14, bool)
    merged[5] = True
    uv = np.random.default_rng(0).uniform(20, 400, (14, 2))
    return Detections.build(("a", "b"), 50.0, [[3, 2, 4], [2, 2, 1]], uv, validity=validity, merged=merged)


CAMERAS = [{"name": "a", "size_px": [640, 480]}, {"name": "b", "size_px": None}]


def test_the_frame_that_is_shown_is_the_one_with_most_to_tell():
    assert fullest_frames(spots()) == [2, 0]
    long = Detections.build(("a",), 50.0, np.ones((1, 500)), np.zeros((500, 2)), validity=np.arange(500) >= 400)
    filling = Detections.build(("a",), 50.0, [[0, 2, 5, 4]], np.zeros((11, 2)))
    assert fullest_frames(filling) == [2]  # where no spot is faulty, the one with most spots
    assert fullest_frames(long) == [0]  # nobody decodes a whole video for one picture
    assert fullest_frames(Detections.build(("a", "b"), 50.0, np.zeros((2, 0)), np.zeros((0, 2)))) == [0, 0]


def test_every_spot_of_the_frame_is_drawn_once_with_its_reason():
    seen = spots()
    assert kinds_of(seen)[[0, 1, 5, 6, 7]].tolist() == [VALID, "too small", SEPARATED, "at edge", "masked"]
    fig = checked(spots_figure(seen, CAMERAS))
    for c, f in enumerate(fullest_frames(seen)):
        axis = f"x{c + 1 if c else ''}"
        drawn = {t.name: np.stack([t.x, t.y], 1) for t in fig.data if t.name and t.xaxis == axis}
        rows = np.arange(len(seen))[seen.rows(c, f)]
        assert sum(map(len, drawn.values())) == len(rows)
        for row in rows:
            of_kind = drawn[kinds_of(seen)[row]]
            assert np.abs(of_kind - seen.uv[row]).sum(1).min() < 1e-3
    told = [t.name for t in fig.data if t.showlegend]
    assert len(told) == len(set(told)) == 4
    dots = [t for t in fig.data if t.showlegend is False and t.marker.size == 3]
    assert len(dots) == 1 and len(dots[0].x) == 3  # also the one of frame 0


def decoded(source, path):
    """The grey values of a picture in the page."""
    path.write_bytes(base64.b64decode(source.removeprefix("data:image/png;base64,")))
    return read_image(path)


def test_pictures_lie_under_the_spots_and_keep_the_brightest_pixels(tmp_path):
    picture = np.zeros((480, 640), np.uint8)
    picture[101, 203] = 200
    coarse = brightest(picture, 2)
    assert coarse.shape == (240, 320) and np.argwhere(coarse).tolist() == [[50, 101]]
    fig = checked(spots_figure(spots(), CAMERAS, [picture, 16 * picture[:100].astype(np.uint16) + 1]))
    first, second = (t for t in fig.data if t.type == "image")
    grey, other = (decoded(t.source, tmp_path / "picture.png") for t in (first, second))
    assert grey.max() == 255 and other.max() == 255 and grey.shape == (480 // 2, 640 // 2)
    v, u = np.argwhere(grey == 255)[0]
    assert abs(first.x0 + u * first.dx - 203) <= 0.5 and abs(first.y0 + v * first.dy - 101) <= 0.5


def test_spots_are_counted_by_reason():
    rig = ring(3)
    records = capture(rig, walk(markers=4, frames=10))
    validity = np.zeros(len(records["detections"]), np.uint8)
    validity[[0, 1, 40]] = Validity.TOO_SMALL, Validity.MASKED, Validity.TOO_SMALL
    records["detections"] = replace(records["detections"], validity=validity, merged=np.arange(len(validity)) == 2)
    cameras = judge(rig, records)["cameras"]
    assert cameras[0]["invalid"] | {"too_small": 1, "masked": 1} == cameras[0]["invalid"]
    assert [sum(c["invalid"].values()) for c in cameras] == [2, 1, 0]
    assert [c["separated"] for c in cameras] == [1, 0, 0]
    assert list(spots_table(cameras).rows[0]) == ["cam1", "40", "38", "1", "1", "0", "0", "0", "1"]
