"""The journal: appended, never changed, and nothing that was answered is ever lost."""

import os
import signal
import subprocess
import sys
import threading

import pytest

from kinemark import KinemarkError
from kinemark.data.edits import Signed, Trim, live
from kinemark.engine.editing.journal import Journal, StaleJournal


@pytest.fixture
def journal(tmp_path):
    return Journal.of(tmp_path, "walk01")


def said(journal):
    """The trims that count."""
    return [edit.last for entry in live(journal.entries) for edit in entry.edits if isinstance(edit, Trim)]


def test_what_is_said_stands_with_who_when_and_why(journal):
    assert journal.entries == () and not journal.path.exists()
    entry = journal.append([Trim(1, 9)], by="EG", why="walked out of view")
    assert journal.entries == (entry,)
    assert (entry.id, entry.by, entry.why) == (1, "EG", "walked out of view") and entry.at.startswith("20")
    assert journal.append([Trim(1, 8)]).by, "the user of the machine, where nobody says"
    assert journal.path.name == "walk01.jsonl" and not journal.faults


def test_undo_and_redo_are_entries_and_nothing_is_ever_rewritten(journal):
    for last in (5, 6, 7):
        journal.append([Trim(1, last)])
    before = journal.path.read_bytes()
    steps = []
    for act in (journal.undo, journal.undo, journal.redo, journal.redo, journal.undo):
        act()
        steps.append(said(journal))
    assert steps == [[5, 6], [5], [5, 6], [5, 6, 7], [5, 6]]
    assert journal.path.read_bytes().startswith(before)
    journal.append([Trim(1, 8)])
    with pytest.raises(KinemarkError, match="nothing was undone last"):
        journal.redo()
    journal.undo(1)
    assert said(journal) == [6, 8]
    with pytest.raises(KinemarkError, match="undone before"):
        journal.undo(1)
    with pytest.raises(KinemarkError, match="no entry 99"):
        journal.undo(99)


def test_undo_passes_over_signatures_and_says_where_there_is_nothing(journal):
    with pytest.raises(KinemarkError, match="nothing to undo"):
        journal.undo()
    journal.append([Trim(1, 5)])
    journal.append([Signed(journal.head)])
    journal.undo()
    assert said(journal) == []


def test_a_writer_who_has_not_seen_the_last_line_is_refused(journal):
    head = journal.append([Trim(1, 5)]) and journal.head
    journal.append([Trim(1, 6)], head=head)
    with pytest.raises(StaleJournal):
        journal.append([Trim(1, 7)], head=head)
    assert said(journal) == [5, 6]


def test_writers_at_once_write_one_after_the_other(journal):
    writers = [threading.Thread(target=journal.append, args=([Trim(1, k)],)) for k in range(2, 12)]
    for writer in writers:
        writer.start()
    for writer in writers:
        writer.join()
    assert sorted(said(journal)) == list(range(2, 12)) and not journal.faults
    assert [entry.id for entry in journal.entries] == list(range(1, 11))


def test_after_a_cut_off_line_the_journal_goes_on_and_names_it(journal):
    journal.append([Trim(1, 5)])
    journal.append([Trim(1, 6)])
    whole = journal.path.read_bytes()
    journal.path.write_bytes(whole[:-40])
    entry = journal.append([Trim(1, 7)])
    assert said(journal) == [5, 7] and entry.id == 3
    assert [(fault.line, fault.kind) for fault in journal.faults] == [(2, "damaged")]


WRITER = """
import sys
from pathlib import Path
from kinemark.data.edits import Trim
from kinemark.engine.editing.journal import Journal
journal = Journal(Path(sys.argv[1]))
for k in range(1, 100000):
    journal.append([Trim(1, k)])
    print(k, flush=True)
"""


@pytest.mark.skipif(os.name != "posix", reason="kills a process by a signal")
def test_other_ends_of_lines_change_nothing(journal):
    journal.append([Trim(1, 2)], by="EG")
    journal.append([Trim(1, 3)], by="EG")
    before = journal.read()
    journal.path.write_bytes(journal.path.read_bytes().replace(b"\n", b"\r\n"))
    assert journal.read() == before and not journal.faults
    journal.append([Trim(1, 4)], by="EG", head=before.head)
    assert said(journal) == [2, 3, 4] and not journal.faults


def test_a_process_killed_while_it_writes_loses_nothing_that_was_answered(journal):
    with subprocess.Popen([sys.executable, "-c", WRITER, journal.path], stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        answered = [int(process.stdout.readline()) for _ in range(25)]
        process.send_signal(signal.SIGKILL)
        answered += [int(line) for line in process.stdout.read().split() if line]
    assert said(journal)[: len(answered)] == answered
    assert len(said(journal)) <= len(answered) + 1


def test_a_disk_that_refuses_says_so_and_leaves_the_journal_as_it_was(journal, monkeypatch):
    journal.append([Trim(1, 5)])
    before = journal.path.read_bytes()
    write = os.write

    def full(file, data):
        write(file, data[: len(data) // 2])
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "write", full)
    with pytest.raises(KinemarkError, match="Nothing was said"):
        journal.append([Trim(1, 6)])
    monkeypatch.setattr(os, "write", write)
    assert journal.path.read_bytes() == before
