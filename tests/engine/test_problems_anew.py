"""Problems after any edits are those of a whole calculation, to the bit, whatever was looked at before."""

import numpy as np
import pytest

from kinemark import KinemarkError
from kinemark.data.edits import Undo, is_named
from kinemark.engine.editing.editing import Editing
from kinemark.engine.editing.journal import Journal
from kinemark.engine.problems import problems
from kinemark.engine.problems.of_names import _checked_names
from kinemark.engine.problems.of_paths import _found
from support.walked import clean, exchanged, nearest, spiked, walk

FRAMES = 400


def editing_of(trajectories, folder):
    return Editing("walk", Journal.of(folder, "walk"), trajectories, by="EG")


def forget():
    """All that was worked out before."""
    _found.cache_clear()
    _checked_names.cache_clear()


def some_act(editing, rng):
    """Something a person may say."""
    now = editing.edited().trajectories
    names = [path.name for path in now if (path.origin > 0).any()]
    one, other = rng.choice(names, 2, replace=False).tolist()
    f = int(rng.integers(2, FRAMES - 20))
    entries = editing.journal.read().entries
    found = problems(editing).items
    kinds = {
        "claim": lambda: editing.claim(one, f"N{rng.integers(3)}" if rng.random() < 0.8 else None, first=f),
        "exchange": lambda: editing.exchange(one, other, first=f),
        "erase": lambda: editing.erase(one, f, f + 9),
        "take": lambda: editing.say(*found[0].alternatives[int(rng.integers(2))].edits),
        "event": lambda: editing.event("Foot Strike", "Left", f / 100),
        "gap": lambda: editing.gap(one, f, f + 9, "open"),
        "undo": lambda: editing.say(Undo(entries[int(rng.integers(len(entries)))].id)),
    }
    if not is_named(one):
        kinds.pop("erase"), kinds.pop("gap")
    if not entries:
        kinds.pop("undo")
    if not found or not found[0].alternatives[-1].edits:
        kinds.pop("take")
    kinds[str(rng.choice(list(kinds)))]()


@pytest.mark.parametrize("seed", range(3))
def test_problems_after_random_edits_are_those_of_a_whole_calculation(tmp_path, seed):
    rng = np.random.default_rng(seed)
    faulty = spiked(exchanged(clean(), 9, nearest(walk()[1], 9, 200), 200), 6, 100, 103)
    editing = editing_of(faulty, tmp_path)
    for _ in range(6):
        try:
            some_act(editing, rng)
        except KinemarkError:
            continue
        kept = repr(problems(editing))
        again = repr(problems(editing))
        forget()
        assert kept == again == repr(problems(editing))


def test_verdicts_events_and_choices_work_nothing_out_anew_and_undo_neither(tmp_path):
    forget()
    editing = editing_of(spiked(clean(), 6, 100, 103), tmp_path)
    found = problems(editing).items[0]
    keep = next(way for way in found.alternatives if way.action == "keep")
    editing.say(*keep.edits)
    editing.event("Foot Strike", "Left", 1.0)
    assert found.id not in [one.id for one in problems(editing).items]
    editing.erase(walk()[0][3], 20, 30)
    problems(editing)
    editing.say(Undo(3))
    problems(editing)
    assert _found.cache_info().misses == _checked_names.cache_info().misses == 2
