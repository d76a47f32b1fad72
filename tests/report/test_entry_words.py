"""What an entry of the journal says in a line, however much was said at once."""

from kinemark.data.edits import Erase, GapChoice, Trim
from kinemark.report.words import edit_text, entry_text


def test_few_edits_are_all_said():
    edits = [Erase("LKNE", 1, 2), Erase("RKNE", 3, 3), Trim(1, 90)]
    assert entry_text(edits) == "; ".join(map(edit_text, edits))


def test_of_many_of_a_kind_the_first_are_said_and_how_many_more_there_are():
    gaps = [GapChoice(f"M{k}", 10 * k, 10 * k + 3, "best") for k in range(1, 41)]
    said = entry_text([*gaps, Trim(1, 90)])
    assert said == f"{edit_text(gaps[0])}; {edit_text(gaps[1])}; and 38 more; {edit_text(Trim(1, 90))}"
