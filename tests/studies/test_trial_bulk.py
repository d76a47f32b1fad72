"""Problems of files by what their trial tells: the study counts changes in long gaps too."""

from kinemark.engine.editing import Editing
from kinemark.engine.journal import Journal
from kinemark.engine.problems import problems
from support.studies import STUDIES
from support.walked import clean, without


def test_a_change_in_a_gap_too_long_for_motion_is_a_change(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(str(STUDIES))
    import trial_bulk

    editing = Editing("walk", Journal.of(tmp_path, "walk"), without(clean(), 5, 60, 350), by="EG")
    (one,) = (p for p in problems(editing).items if (p.first, p.last) == (60, 351))
    assert "assumed_mm" in one.values and trial_bulk.kind_of(one) == "change"
