"""Problems of files by what their trial tells: the study counts changes in long gaps too, and fits within bounds."""

import numpy as np
import pytest

from kinemark.edit.probable_errors.probability import TAIL
from kinemark.engine.editing.editing import Editing
from kinemark.engine.editing.journal import Journal
from kinemark.engine.problems import problems
from support.studies import STUDIES
from support.walked import clean, without


def test_a_change_in_a_gap_too_long_for_motion_is_a_change(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(str(STUDIES))
    import trial_bulk

    editing = Editing("walk", Journal.of(tmp_path, "walk"), without(clean(), 5, 60, 350), by="EG")
    (one,) = (p for p in problems(editing).items if (p.first, p.last) == (60, 351))
    assert "assumed_mm" in one.values and trial_bulk.kind_of(one) == "change"


@pytest.mark.parametrize("c", [(1.3, 1.6), (0.0, 1.0), (1.0, 3.0)])
def test_what_is_fitted_is_what_the_trials_tell_as_far_as_more_evidence_stays_likelier(monkeypatch, c):
    monkeypatch.syspath_prepend(str(STUDIES))
    import trial_bulk

    rng = np.random.default_rng(1)
    x = np.column_stack([rng.normal(0, 2, 4000), rng.exponential(1.0, 4000), rng.exponential(1.0, 4000)])
    true = rng.random(4000) < 1 / (1 + np.exp(-(x @ [1.0, c[0], -c[1]])))
    rows = [trial_bulk.Told("", "leap", 0.5, tuple(one), bool(y), 0, 100.0, {}) for one, y in zip(x, true, strict=True)]
    more, common = trial_bulk.fit(rows)
    assert abs(more - c[0]) < 0.2 or c[1] > TAIL
    assert more >= 0 and common < TAIL and abs(common - min(c[1], TAIL)) < 0.2


def test_a_kind_that_is_feared_too_much_gets_a_level_of_its_own(monkeypatch):
    """What told of leaps was spread too little: of those said to be wrong with .36 by the others .13 were."""
    monkeypatch.syspath_prepend(str(STUDIES))
    import trial_bulk

    rng, rows = np.random.default_rng(2), []
    for trial in range(60):
        kinds = rng.choice(["leap", "spike"], 60).tolist()
        z = rng.normal(-3, 2, 60)
        real = np.where(np.array(kinds) == "leap", 1.8 * z - 1, z)
        true = rng.random(60) < 1 / (1 + np.exp(-real))
        said = zip(kinds, 1 / (1 + np.exp(-z)), true, strict=True)
        rows += [trial_bulk.Told("", kind, w, (0.0, 0.0, 0.0), bool(y), trial, 100.0, {}) for kind, w, y in said]
    levels = trial_bulk.fit_levels(rows)
    leap, spike = (trial_bulk.LEVELS.index(name) for name in ("leap", "spike_in_file"))
    assert levels.factor[leap] > 1.4 > levels.factor[spike] and levels.constant[leap] < levels.constant[spike]
    before, after = trial_bulk.judged(rows, None), trial_bulk.judged_by(rows, levels)

    def off(some):
        left = [one for one in some if one.kind == "leap" and one.wrong < 0.2]
        return sum(one.wrong for one in left) / max(sum(one.true for one in left), 1)

    assert off(after) < 1.4 < off(before)
