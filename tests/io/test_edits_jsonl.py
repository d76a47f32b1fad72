"""The lines of a journal: what is written comes back, and whatever is done to the file is found."""

import json

import pytest

from kinemark.data.edits import (
    AddEvent,
    Claim,
    DropUnnamed,
    Entry,
    Erase,
    GapChoice,
    ImagePoint,
    Put,
    Signed,
    Smooth,
    Stretch,
    Trim,
    Undo,
    Verdict,
    Witness,
)
from kinemark.io.edits_jsonl import NOTHING, hash_of, line_of, parse_journal

WHERE = Stretch(
    3, None, (Witness(3, (0.1, -2.0, 1e5), (("cam 1", 1.25, 2.0), ("ü", 3.0, 4.5))), Witness(9, (1.0, 2.0, 3.0))), "w"
)
EVERY = (
    Claim(WHERE, "LKNE"),
    Claim(WHERE, None),
    Erase("LKNE", 1, 2),
    Put("LKNE", 3, (1.0, 2.0, 3.0), 0.5, (("cam1", 1.0, 2.0),), "w"),
    GapChoice("LKNE", 1, 2, "best"),
    Smooth("LKNE", 1, 9, 6.0),
    Smooth("LKNE", 1, 9, 6.0, "smooth", "woltring"),
    ImagePoint("cam1", 4, 1.0, 2.0, None),
    Verdict("swap", (WHERE, WHERE), True),
    Trim(1, 2),
    DropUnnamed(),
    AddEvent("Foot “Strike”\n", "Left", 0.5),
    Undo(1),
    Signed("ab"),
)


def journal(n=4):
    """Lines of a small journal."""
    lines, before = [], NOTHING
    for k in range(n):
        lines.append(line_of(Entry(k + 1, f"2026-11-23T04:0{k}:00", "op", "why" * k, "1", before, (Trim(1, 5 + k),))))
        before = hash_of(lines[-1])
    return lines


def test_a_line_that_says_no_function_of_smoothing_means_the_first():
    """So that journals of before there was a choice are read, and written, as they were."""
    line = line_of(Entry(1, "2026", "op", "", "1.0", NOTHING, (Smooth("LKNE", 1, 9, 6.0),)))
    assert b"function" not in line and b"butterworth" not in line
    assert parse_journal(line).entries[0].edits[0].function == "butterworth"


def test_every_edit_comes_back_as_it_was():
    entry = Entry(7, "2026", "op", "because\n", "1.0", NOTHING, EVERY)
    line = line_of(entry)
    assert line.count(b"\n") == 1
    assert parse_journal(line).entries == (entry,) and not parse_journal(line).faults


@pytest.mark.parametrize("change", [1, 0x20, 0x80])
def test_a_changed_byte_is_found_wherever_it_is(change):
    content = b"".join(journal(3))
    for at in range(len(content) - 1):
        tampered = bytearray(content)
        tampered[at] ^= change
        found = parse_journal(bytes(tampered))
        assert found.faults, at
        line = content[:at].count(b"\n") + 1
        assert min(fault.line for fault in found.faults) in (line, line + 1)
        assert {entry.id for entry in found.entries} >= {1, 2, 3} - {line, line + 1}, "the rest stands"


def test_a_mark_of_utf_8_that_an_editor_set_before_it_changes_nothing():
    content = b"".join(journal(3))
    assert parse_journal(b"\xef\xbb\xbf" + content) == parse_journal(content)


def test_a_journal_cut_off_anywhere_loses_only_what_was_cut():
    lines = journal(3)
    content = b"".join(lines)
    for at in range(len(content)):
        found = parse_journal(content[:at])
        whole = content[:at].count(b"\n")
        assert [entry.id for entry in found.entries][:whole] == list(range(1, whole + 1))
        assert len(found.entries) + len(found.faults) == len(content[:at].splitlines())


def test_lines_removed_added_moved_or_rewritten_with_their_hash_are_found():
    a, b, c, d = journal(4)
    forged = line_of(Entry(2, "2026", "other", "", "1", hash_of(a), (Trim(1, 2),)))
    for wrong in ([a, c, d], [b, c, d], [a, c, b, d], [a, b, b, c, d], [a, forged, c, d], [a, b, forged, c, d]):
        assert parse_journal(b"".join(wrong)).faults
    assert not parse_journal(a + b + c + d).faults


def test_an_edit_of_a_later_version_is_named_and_not_half_applied():
    line = line_of(Entry(1, "2026", "op", "", "9", NOTHING, (Trim(1, 2),)))
    for text in ('"kind":"warp"', '"kind":"trim","speed":3'):
        body = line.rpartition(b',"hash"')[0].replace(b'"kind":"trim"', text.encode())
        found = parse_journal(body + b',"hash":"' + hash_of(body).encode() + b'"}\n')
        assert [fault.kind for fault in found.faults] == ["unknown"] and not found.entries
    json.loads(line)  # other programs can read it


def test_a_line_nested_too_deeply_is_named():
    body = b'{"edits":' + b"[" * 100_000
    found = parse_journal(body + b',"hash":"' + hash_of(body).encode() + b'"}\n')
    assert [fault.kind for fault in found.faults] == ["unknown"]
