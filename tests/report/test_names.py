"""Names are shortened in figures, never where they differ, and stand whole in tables."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from kinemark.report.tables import Table
from kinemark.report.templating import environment
from kinemark.report.theme import LONGEST, labels, shortened


def test_markers_of_one_subject_keep_what_tells_them_apart():
    names = [f"Participant_042_session_2:{marker}" for marker in ("LASI", "RASI", "LKNE", "RKNE")]
    shown = shortened(names)
    assert len(set(shown)) == 4
    assert all(short.endswith(name[-4:]) and len(short) <= LONGEST for short, name in zip(shown, names, strict=True))


def test_a_long_name_among_others_loses_its_end():
    assert shortened(["a", "b" * 60]) == ["a", "b" * (LONGEST - 1) + "…"]


def test_names_that_differ_at_both_ends_stay_whole():
    same = "x" * 40
    names = [f"a{same}1", f"a{same}2", f"b{same}1", f"b{same}2", f"a{same}1"]
    assert len(set(shortened(names))) == 4 and shortened(names)[0] == shortened(names)[4]


@given(st.lists(st.text("abx", min_size=0, max_size=60), max_size=12))
def test_different_names_stay_different(names):
    shown = shortened(names)
    assert len(shown) == len(names)
    assert len(set(shown)) == len(set(names))


def test_markup_in_names_stays_text():
    assert labels(["<b>", ""]) == ["&lt;b&gt;", " "]


@pytest.mark.parametrize("name", ["x" * 80, "Subject with a long name:marker with a long name, left side"])
def test_tables_have_names_whole(name):
    html = str(environment().get_template("macros.html").module.table(Table(["name"], [[name]])))
    style = environment().get_template("frame.html").render(library=None, heading="h", below="b", nav={})
    assert name in html and "ellipsis" not in style
