"""What an entry of the journal says in a line, however much was said at once."""

from kinemark.data.edits import Claim, Erase, GapChoice, Stretch, Trim, Verdict, Witness
from kinemark.report.words import edit_text, entry_text


def test_few_edits_are_all_said():
    edits = [Erase("LKNE", 1, 2), Erase("RKNE", 3, 3), Trim(1, 90)]
    assert entry_text(edits) == "; ".join(map(edit_text, edits))


def test_of_many_of_a_kind_the_first_are_said_and_how_many_more_there_are():
    gaps = [GapChoice(f"M{k}", 10 * k, 10 * k + 3, "best") for k in range(1, 41)]
    said = entry_text([*gaps, Trim(1, 90)])
    assert said == f"{edit_text(gaps[0])}; {edit_text(gaps[1])}; and 38 more; {edit_text(Trim(1, 90))}"


def where(first, last, *frames):
    return Stretch(first, last, tuple(Witness(frame, (1.0, 2.0, 3.0), ()) for frame in frames), "")


def test_an_exchange_that_was_settled_is_one_word_and_not_two_places():
    at = where(31, None, 31, 100)
    edits = [Claim(at, "LANK"), Claim(at, "LHEE"), Verdict("swap", (at,), False)]
    assert entry_text(edits) == "LANK and LHEE exchanged, frames 31–100 and on"


def test_pieces_that_are_one_marker_are_said_together():
    pieces = where(None, None, 1, 62), where(None, None, 65, 100)
    edits = [*(Claim(at, "LTIB") for at in pieces), Verdict("join", pieces, False)]
    assert entry_text(edits) == "one marker: LTIB, frames 1–62 and frames 65–100"


def test_a_verdict_says_where():
    """Two spikes that were right were two equal lines."""
    assert (
        entry_text([Verdict("spike", (where(95, 99, 95, 97, 99),), True)])
        == "spike? within frames 95–99: right as it is"
    )


def test_claims_of_other_places_are_said_one_by_one():
    edits = [Claim(where(1, 9, 1, 9), "A"), Claim(where(3, 9, 3, 9), "B"), Verdict("swap", (), False)]
    assert entry_text(edits).startswith("A: frames 1–9, from")
