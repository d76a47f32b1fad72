"""The picture of a marker set has each marker once a view, at its place, and names are text whatever they hold."""

import xml.etree.ElementTree as ET

import pytest

from kinemark.data import KinemarkError, MarkerSet
from kinemark.io.marker_sets import marker_sets, read_marker_set
from kinemark.report.marker_figure import marker_set_html, marker_set_svg

SVG = "{http://www.w3.org/2000/svg}"


def dots(text):
    return [circle.find(f"{SVG}title").text.partition(":")[0] for circle in ET.fromstring(text).iter(f"{SVG}circle")]


@pytest.mark.parametrize("name", marker_sets())
def test_every_marker_is_in_its_views(name):
    found = read_marker_set(name)
    seen = dots(marker_set_svg(found))
    for marker in found.names:
        assert seen.count(marker) == (2 if found.faces[marker] == "both" else 1)


@pytest.mark.parametrize("name", marker_sets())
def test_names_do_not_lie_upon_each_other_and_all_is_in_the_picture(name):
    root = ET.fromstring(marker_set_svg(read_marker_set(name)))
    height = float(root.get("viewBox").split()[3])
    for group in root.iter(f"{SVG}g"):
        columns = {}
        for text in group.findall(f"{SVG}text"):
            if text.find(f"{SVG}title") is not None:
                columns.setdefault(text.get("x"), []).append(float(text.get("y")))
        for ys in columns.values():
            assert all(b - a >= 14.9 for a, b in zip(sorted(ys), sorted(ys)[1:], strict=False))
            assert min(ys) > 0 and max(ys) < height - 20


def test_the_subjects_left_is_on_the_right_of_the_front_view():
    root = ET.fromstring(marker_set_svg(read_marker_set("kiss-15")))
    front, back = (group for group in root.findall(f"{SVG}g") if group.get("transform"))

    def x(view, name):
        circles = view.iter(f"{SVG}circle")
        return next(float(c.get("cx")) for c in circles if c.find(f"{SVG}title").text.startswith(name))

    assert x(front, "LKNE") > 0 > x(front, "RKNE") and x(back, "LKNE") < 0 < x(back, "RKNE")


def test_names_are_text():
    evil = '</svg><script>alert("1")</script>&'
    found = MarkerSet((evil, "b"), places={evil: (0, 0, 0), "b": (0, 0.1, 1)}, meaning={"b": evil}, name=evil)
    for text in (marker_set_svg(found), marker_set_html(found)):
        assert "<script" not in text
    assert len(dots(marker_set_svg(found))) == 4


def test_a_set_without_places_is_refused():
    with pytest.raises(KinemarkError, match="says no places"):
        marker_set_svg(MarkerSet(("A", "B"), name="bare"))
