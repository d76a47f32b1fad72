"""Names in errors: the one that was meant, and not hundreds of others."""

import pytest

from kinemark.data import MarkerTrajectory, Trajectories
from kinemark.data.nearest_word import some_names


@pytest.mark.parametrize(
    ("names", "said"),
    [((), "none"), (("a", "b"), "a, b"), (tuple("abcde"), "a, b, c and 2 more")],
)
def test_a_list_of_names_is_short(names, said):
    assert some_names(names, 3) == said


def test_a_trial_of_many_markers_does_not_list_them_all():
    trial = Trajectories(tuple(MarkerTrajectory.measured(f"M{k}", [[0.0, 0, 0]]) for k in range(180)), 100.0)
    with pytest.raises(KeyError, match="and 168 more"):
        trial["LASI"]
