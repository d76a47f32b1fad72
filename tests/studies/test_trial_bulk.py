"""Problems of files by what their trial tells: the study counts changes in long gaps too, and fits within bounds."""

import numpy as np
import pytest

from kinemark.edit.probable_errors import Moment
from kinemark.edit.probable_errors.probability import TAIL, logit_in_trial
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


@pytest.mark.parametrize("c", [(1.3, 1.6, 0.0, 0.8), (0.5, 1.0, 0.6, 1.5), (1.0, 3.0, 0.3, 0.0)])
def test_what_is_fitted_is_what_the_trials_tell_as_far_as_more_evidence_stays_likelier(monkeypatch, c):
    """Coefficients of (3), and of (5) for what is unlikely."""
    monkeypatch.syspath_prepend(str(STUDIES))
    import trial_bulk

    rng = np.random.default_rng(1)
    bulk = rng.normal(0, 2, 20_000), rng.exponential(1.0, 20_000), rng.exponential(1.0, 20_000), rng.random(20_000) ** 4
    x = np.column_stack(bulk)
    true = rng.random(20_000) < 1 / (1 + np.exp(-logit_in_trial(x, c)))
    at = Moment(0.0, frozenset({0}))
    rows = [
        trial_bulk.Told("", "leap", 0.5, tuple(one), bool(y), 0, 100.0, {}, at) for one, y in zip(x, true, strict=True)
    ]
    more, common, faster, together = trial_bulk.fit(rows)
    assert more >= 0 and faster >= 0 and together >= 0 and common < TAIL and abs(common - min(c[1], TAIL)) < 0.2
    assert np.abs(np.array([more, faster, together]) - [c[0], *c[2:]]).max() < 0.2 or c[1] > TAIL
