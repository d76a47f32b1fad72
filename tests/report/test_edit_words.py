"""How far a claim goes is said as it is."""

import pytest

from kinemark.data.edits import Claim, Stretch, Witness
from kinemark.report.words import edit_text


@pytest.mark.parametrize(
    ("first", "last", "words"),
    [
        (None, None, "LHEE: frames 3–9, the track as a whole, from (1, 2, 3) mm"),
        (4, None, "LHEE: frames 4–9 and on, from (1, 2, 3) mm"),
        (None, 8, "LHEE: frames 3–8 and before, from (1, 2, 3) mm"),
        (4, 8, "LHEE: frames 4–8, from (1, 2, 3) mm"),
    ],
)
def test_open_ends_of_a_claim_are_said(first, last, words):
    """A whole track of 701 frames was "frames 1–701 and on"."""
    where = Stretch(first, last, tuple(Witness(frame, (1.0, 2.0, 3.0), ()) for frame in (3, 9)), "")
    assert edit_text(Claim(where, "LHEE")) == words
