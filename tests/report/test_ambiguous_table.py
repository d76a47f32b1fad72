"""The table of close decisions: grouped by value, worded in one place."""

import pytest

from kinemark.report.tables import SILENT, grouped
from kinemark.report.tables import ambiguous_table as plain_table
from kinemark.report.templating import environment
from kinemark.report.words import reasons as words


def ambiguous_table(decisions, *, listed):
    """The table as the page has it."""
    return str(environment().get_template("macros.html").module.table(plain_table(decisions, listed=listed)))


def decision(kind, at, who, reason, **values):
    return {
        "kind": kind,
        "first_frame": at,
        "last_frame": at + 1,
        "time_s": at / 100,
        "trajectories": who,
        "reason": reason,
        "values": values,
    }


def test_the_same_reason_about_the_same_markers_is_one_row():
    many = [decision("swap", 10 * k, ["*3"], "found_again", sd_mm=mm) for k, mm in enumerate((13, 21, 10))]
    others = [
        decision("swap", 15, ["*4"], "found_again", sd_mm=12),
        decision("swap", 16, ["*3"], "came_near", distance_mm=20),
    ]
    both = decision("merge", 5, ["*3"], "shared_images")
    decisions = sorted([*many, *others, both], key=lambda one: one["first_frame"])
    assert [len(own) for own in grouped(decisions)] == [3, 1, 1, 1]
    page = ambiguous_table(decisions, listed=True)
    assert page.count("<tr>") == 1 + 4
    assert "10–21 mm" in page and "0.00, 0.10, 0.20" in page and "12 mm" in page


def test_what_is_wrong_most_often_is_first_and_of_one_reason_the_earliest():
    decisions = [
        decision("swap", 1, ["*1"], "found_again", sd_mm=12),
        decision("swap", 2, ["*2"], "came_near", distance_mm=12),
        decision("swap", 3, ["*3"], "came_near", distance_mm=12),
        decision("merge", 4, ["*4"], "shared_images"),
    ]
    assert [row[0] for row in plain_table(decisions, listed=True).rows] == ["*2", "*3", "*1", "*4"]


def test_rows_are_grouped_by_value_whatever_the_words_are(monkeypatch):
    decisions = [
        decision("swap", 0, ["*3"], "found_again", sd_mm=12),
        decision("swap", 1, ["*3"], "came_near", distance_mm=12),
    ]
    monkeypatch.setitem(words.REASONS, "found_again", "7 of 9")
    monkeypatch.setitem(words.REASONS, "came_near", "7 of 9")
    assert [len(own) for own in grouped(decisions)] == [1, 1]


def test_many_moments_are_counted_and_none_is_lost():
    page = ambiguous_table([decision("swap", 10 * k, ["*3"], "found_again", sd_mm=13) for k in range(40)], listed=True)
    assert "<td>40</td>" in page and "… 3.90" in page and page.count("<tr>") == 2


def test_a_method_that_tells_no_decisions_is_not_free_of_them():
    assert "None." in ambiguous_table([], listed=True)
    assert SILENT in ambiguous_table([], listed=False) and "None." not in ambiguous_table([], listed=False)


def test_names_from_outside_are_text():
    assert "<b>" not in ambiguous_table([decision("swap", 1, ["<b>"], "came_near", distance_mm=3)], listed=True)


@pytest.mark.parametrize("reason", words.REASONS)
def test_every_reason_has_words_for_any_number(reason):
    names = {"distance_mm", "sd_mm", "likelihood_ratio", "margin"}
    for value in (None, 0.0, 1e30, -3.0):
        text = words.reason_text([{"reason": reason, "values": dict.fromkeys(names, value)}])
        assert text and "{" not in text and "None" not in text
