"""Images with what is detected: every camera, every frame, invalid spots coloured and with their reason."""

import re
from xml.etree import ElementTree

import numpy as np
import pytest
from detection_pictures import enclosing, stacked_svg

from kinemark.data import Validity
from kinemark.detect import Blobs
from kinemark.engine.detection.frames import detected_frames
from kinemark.report.field_pictures import FieldPicture, field_svg, kind_of
from kinemark.report.figures_detections import KINDS
from support.command_line import command
from support.tried import session_in


@pytest.fixture(scope="module")
def tried(tmp_path_factory):
    return session_in(tmp_path_factory.mktemp("tried"), "[detect]\nthreshold = 50\nmin_area = 6\nmax_area = 400")


def blobs_of(uv, validity):
    n = len(uv)
    nothing = np.full(n, np.nan)
    size = np.full(n, 6.0)
    return Blobs(
        np.array([n]), np.array(uv, float), np.zeros((n, 2, 2)), nothing, size, size, nothing,
        np.array(validity, np.uint8), np.zeros(n, bool),
    )  # fmt: skip


def test_every_camera_and_frame_is_on_the_page_with_reasons(tried, tmp_path):
    page = tmp_path / "fields.html"
    command("detect", tried, "--pictures", page, "--frames", "6,10,20")
    html = page.read_text("utf-8")
    found = detected_frames(tried, "one", [6, 10, 20])
    assert len(re.findall("<svg", html)) == 6 and html.count('id="frame-') == 3
    for frame, images in found.frames:
        assert [one.camera for one in images] == ["c0", "c1"]
        for one in images:
            valid = (one.blobs.validity == Validity.VALID).sum()
            assert f"{one.camera}, frame {frame}: {valid} markers, {len(one.blobs.validity) - valid} invalid" in html
    drawn = re.findall(r"<text[^>]*>([^<]*)</text>", html)
    kinds = [kind_of(v, merged=False) for _, images in found.frames for one in images for v in one.blobs.validity if v]
    assert sorted(drawn) == sorted(kinds) and {"too large", "not round", "at edge"} <= set(kinds)


def test_what_is_not_there_is_said(tried, tmp_path):
    with pytest.raises(Exception, match="frames 1 to 20, and 21"):
        detected_frames(tried, "one", [21])
    with pytest.raises(Exception, match="frames"):
        command("detect", tried, "--pictures", tmp_path / "x.html", "--frames", "six")
    assert [f for f, _ in detected_frames(tried).frames] == [1, 6, 10, 15, 20]


def test_a_frame_is_where_the_spot_is_in_fields_and_in_regions():
    """In a field (two lines of a frame each) cut at (20, 10), a spot at (30, 15) is 10.5 columns in, 11 lines down."""
    blobs = blobs_of([(30, 15), (40, 12), (5, 5)], [Validity.VALID, Validity.TOO_SMALL, Validity.VALID])
    picture = FieldPicture("c", 1, np.zeros((50, 90), np.uint8), blobs, tall=2, region=(20, 10, 69, 39))
    root = ElementTree.fromstring(str(field_svg(picture)))
    space = "{http://www.w3.org/2000/svg}"
    assert root.get("viewBox") == "0 0 50 60"
    frames = root.findall(f"{space}rect")
    assert len(frames) == 2, "what is outside of the region is not drawn"
    x, y, w, h = (float(frames[0].get(key)) for key in ("x", "y", "width", "height"))
    assert (x + w / 2, y + h / 2) == pytest.approx((10.5, 11.0)) and h == 2 * w
    assert frames[0].get("stroke") == KINDS["valid"][0] and frames[1].get("stroke") == KINDS["too small"][0]
    assert [text.text for text in root.findall(f"{space}text")] == ["too small"]
    stacked = ElementTree.fromstring(stacked_svg([picture, picture], ["a < b", "c"]))
    assert [text.text for text in stacked.findall(f"{space}text")] == ["a < b", "c"]


def test_the_region_holds_all_valid_spots_of_all_pictures():
    many = [blobs_of([(30, 15), (2, 2)], [0, Validity.TOO_LARGE]), blobs_of([(80, 47)], [0])]
    assert enclosing(many, (90, 50), 4) == (23, 8, 87, 49)
    with pytest.raises(ValueError, match="nothing can be enclosed"):
        enclosing([blobs_of([(1, 1)], [1])], (90, 50), 4)
