"""How a file's program took the feet, from the offsets that it states."""

from dataclasses import replace

import pytest

from kinemark.gait.static_checks import feet_taken
from kinemark.io.c3d.subject_measures import measures_of
from support.plug_in_gait import TRIALS, points, trial

STATICS = sorted({(one.static, one.flat) for one in TRIALS})


@pytest.mark.parametrize(("static", "flat"), STATICS)
def test_each_published_trial_is_told_as_it_was_processed(static, flat):
    stated = measures_of(trial(static).source)
    taken = feet_taken(stated, points(static))
    assert taken is not None and taken.flat == flat and taken.by_deg > 0.5
    other = replace(stated.left, plantar_offset_deg=stated.left.plantar_offset_deg + 1.0)
    assert feet_taken(replace(stated, left=other), points(static)) is None
