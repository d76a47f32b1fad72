"""What the report says of close decisions and of what was noticed."""

import pytest

from kinemark.findings.trial_advice import warnings
from kinemark.report.ambiguous_table import SILENT, ambiguous_table, grouped
from support.captures import capture, judge, ring, walk


def doubt(kind, at, who, reason):
    return {
        "kind": kind,
        "first_frame": at,
        "last_frame": at + 1,
        "time_s": at / 100,
        "trajectories": who,
        "reason": reason,
    }


LOST = "lost, and found again where its place was known to {} mm only"


def test_the_same_doubt_about_the_same_markers_is_one_row():
    many = [doubt("swap", 10 * k, ["*3"], LOST.format(mm)) for k, mm in enumerate((13, 21, 10))]
    others = [doubt("swap", 15, ["*4"], LOST.format(12)), doubt("swap", 16, ["*3"], "jumped by 20 mm")]
    both = doubt("merge", 5, ["*3"], "lived on images in which markers run together")
    doubts = sorted([*many, *others, both], key=lambda one: one["first_frame"])
    assert [len(own) for own in grouped(doubts)] == [3, 1, 1, 1]
    page = ambiguous_table(doubts, told=True)
    assert page.count("<tr>") == 1 + 4
    assert "known to 10–21 mm only" in page and "0.00, 0.10, 0.20" in page and "known to 12 mm only" in page


def test_many_moments_are_counted_and_none_is_lost():
    page = ambiguous_table([doubt("swap", 10 * k, ["*3"], LOST.format(13)) for k in range(40)], told=True)
    assert "<td>40</td>" in page and "… 3.90" in page and page.count("<tr>") == 2


def test_a_method_that_tells_no_doubts_is_not_free_of_them():
    assert "None." in ambiguous_table([], told=True)
    assert SILENT in ambiguous_table([], told=False) and "None." not in ambiguous_table([], told=False)


def test_names_from_outside_are_text():
    assert "<b>" not in ambiguous_table([doubt("swap", 1, ["<b>"], "x <b> 3")], told=True)


@pytest.fixture
def figures():
    rig = ring()
    return judge(rig, capture(rig, walk()))


def advice(figures, sentence):
    (one,) = [w for w in warnings(figures | {"diagnostics": [sentence]}) if w["what"] == sentence]
    return one["do"]


def test_advice_is_for_what_was_noticed(figures):
    assert "rate_hz" in advice(figures, "Markers move at 60 m/s: is the frame rate of 5000 Hz that of the recording?")
    assert "calibrate again" in advice(figures, "The images of camera cam3 fit no track from frame 4 on: was it moved?")


def test_a_camera_that_was_noticed_is_not_blamed_twice(figures):
    figures["cameras"][2]["used_of_valid_share"] = 0.1
    name = figures["cameras"][2]["name"]
    assert any("became no part" in w["what"] for w in warnings(figures))
    told = figures | {"diagnostics": [f"The images of camera {name} fit no track from frame 4 on: was it moved?"]}
    assert not any("became no part" in w["what"] for w in warnings(told))
