"""The usual limit of the expected error goes with the size of what is measured."""

import numpy as np
import pytest

from kinemark.fill import LIMIT, Gap, Linear, fill, usual_limit
from kinemark.findings.gaps import filling_figures
from support.filling import moving, trial

PERSON = moving(markers=12)._replace(xyz=4 * moving(markers=12).xyz)
GAPS = [Gap(k, 60 + 15 * k, 60 + 15 * k + length) for k, length in enumerate((8, 20, 60, 90, 30, 50))]


def of_size(scale):
    """What is a person's size at 1, with gaps of which only the short ones are filled well along a line."""
    hidden = PERSON.hidden(GAPS)
    return trial(hidden._replace(xyz=scale * hidden.xyz))


def test_a_person_has_the_usual_limit_and_a_hand_or_an_insect_less_in_proportion():
    xyz = PERSON.xyz
    assert usual_limit(xyz) == usual_limit(3 * xyz) == LIMIT
    hand = usual_limit(0.1 * xyz)
    assert 0 < hand < LIMIT / 2
    assert usual_limit(0.01 * xyz) == pytest.approx(hand / 10)
    assert usual_limit(xyz[:1]) == usual_limit(np.full((3, 10, 3), np.nan)) == usual_limit(0 * xyz) == LIMIT
    assert usual_limit(np.zeros((2, 0, 3))) == usual_limit(np.zeros((0, 10, 3))) == LIMIT


def test_what_an_insect_leaves_open_goes_with_its_size():
    hand, insect = (fill(of_size(scale), method=Linear()).gaps for scale in (0.1, 0.01))
    assert {gap.state for gap in hand} == {"filled", "above_limit"}
    assert [gap.state for gap in hand] == [gap.state for gap in insect]
    assert all(gap.method for gap in fill(of_size(0.01), method=Linear(), limit_mm=LIMIT).gaps)  # as it was stated


def test_the_page_tells_the_limit_that_was_meant():
    for scale in (1.0, 0.1):
        before = of_size(scale)
        figures = filling_figures(fill(before, method=Linear()), before, source="s", method="linear", limit_mm=None)
        assert figures["limit_mm"] == usual_limit(before.xyz)
        told = [one for one in figures["findings"] if one["kind"] == "gaps_uncertain"]
        assert all(one["values"]["limit_mm"] == figures["limit_mm"] / 2 for one in told)
