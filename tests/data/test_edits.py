"""Edits are values that say what they cannot be; undo is an entry."""

import pytest

from kinemark.data.edits import Claim, Erase, GapChoice, Put, Smooth, Stretch, Trim, Undo, Witness, counting, live
from support.edited import entries

SPOT = Witness(3, (1.0, 2.0, 3.0))


@pytest.mark.parametrize(
    "wrong",
    [
        lambda: Erase("*3", 1, 2),
        lambda: Erase("", 1, 2),
        lambda: Erase("LKNE ", 1, 2),
        lambda: Erase("LKNE", 3, 2),
        lambda: Claim(Stretch(None, None, (SPOT,)), "*4"),
        lambda: Stretch(1, 2, ()),
        lambda: Stretch(1, 9, (SPOT, SPOT)),
        lambda: Stretch(1, 9, (Witness(3, (float("nan"), 0.0, 0.0)),)),
        lambda: Put("LKNE", 3, (0.0, 0.0, 0.0), 0.0),
        lambda: Put("LKNE", 3, (0.0, float("inf"), 0.0), 1.0),
        lambda: Smooth("LKNE", 1, 9, -1.0),
        lambda: Smooth("LKNE", 1, 9, 6.0, "smooth", "kernel"),
        lambda: GapChoice("LKNE", 5, 4, "best"),
        lambda: Trim(9, 1),
    ],
)
def test_what_cannot_be_said_is_refused(wrong):
    with pytest.raises(ValueError):
        wrong()


def test_undo_takes_back_and_undoing_that_gives_again():
    said = [Trim(1, 5), Trim(2, 5), Undo(2), Undo(3), Undo(1), Undo(4)]
    kept = [[entry.id for entry in live(entries(*said[:n]))] for n in range(7)]
    assert kept == [[], [1], [1, 2], [1], [1, 2], [2], []]
    assert [entry.id for entry in counting(entries(*said))] == [3, 5, 6]
