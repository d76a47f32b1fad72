"""The task: a rendered trial with faults is mended by somebody who sees only the screen, and judged by truth.

Three exchanges, two pieces without a name, left and right exchanged, four gaps, a ghost and a spike (`support.faults`).
"""

import re
import shutil

import numpy as np

from kinemark.apps.demo import NEAR_MM
from kinemark.data import Origin
from kinemark.data.edits import is_named
from kinemark.engine.editing import editing as editing_module
from kinemark.engine.session import Session
from support.faults import faulty
from support.screen_operator import Operator

MOST_ACTIONS, MOST_SECONDS = 40, 90.0
HARMED_MM = 5.0  # off the tracker's own place, which is within a millimetre of the truth


def edited(folder, *, faults=True):
    """The trial with its edits and chosen fills, as the library has it; and as the tracker without faults left it."""
    measured = editing_module.measured_of
    trial = Session.open(folder).trial("walk01")
    clean = editing_module.Editing.of_trial(trial).trajectories
    try:
        if faults:
            editing_module.measured_of = lambda *given: faulty(measured(*given))
        now = editing_module.Editing.of_trial(trial).edited()
    finally:
        editing_module.measured_of = measured
    return now, clean


def swaps(trajectories, truth, names):
    """Named samples that are nearer to another marker's true place than to their own by far."""
    wrong = 0
    for path in trajectories:
        if path.name not in names:
            continue
        off = np.linalg.norm(path.xyz - truth[names.index(path.name)], axis=1)
        wrong += int((off > NEAR_MM).sum())
    return wrong


def test_a_novice_mends_the_trial_in_time(folder, faulty_studio, record_property):
    with np.load(folder / "truth.npz") as kept:
        truth, names = kept["xyz"], [str(name) for name in kept["names"]]
    operator = Operator(faulty_studio.open())
    operator.mend()
    record_property("actions", operator.actions)
    record_property("seconds", operator.seconds)
    print(f"{operator.actions} actions, {operator.seconds:.0f} s", *operator.did, sep="\n  ")

    now, clean = edited(folder)
    own = swaps(clean, truth, names)  # single samples that the tracker without faults has off
    assert swaps(now.trajectories, truth, names) <= own < 3
    assert not [path.name for path in now.trajectories if not is_named(path.name)], "something without a name is left"
    harmed = [(path.name, int(f)) for path in clean for f in lost_or_moved(path, now.trajectories)]
    assert len(harmed) <= allowed(clean), harmed
    assert operator.actions <= MOST_ACTIONS
    assert operator.seconds <= MOST_SECONDS
    assert faulty_studio.errors == []


def lost_or_moved(path, now):
    """Frames in which a good sample is gone, or elsewhere."""
    mine = now[path.name] if path.name in now.names else None
    there = path.origin == Origin.MEASURED
    if mine is None:
        return np.flatnonzero(there)
    off = np.linalg.norm(mine.xyz - path.xyz, axis=1)
    return np.flatnonzero(there & ~(off < HARMED_MM))


def allowed(clean):
    """Samples that the faults took: gaps, the two frames before each piece, and the spike."""
    from support.faults import Faults

    of = Faults()
    return sum(length for *_, length in of.gaps) + 2 * len(of.pieces) + sum(length for *_, length, _ in [of.spike])


def test_the_edits_hold_when_the_detection_is_changed_and_the_trial_run_again(folder, faulty_studio):
    """Outcomes after another detection: all are held, or said not to be."""
    operator = Operator(faulty_studio.open())
    operator.problems()
    faulty_studio.server.kill()
    settings = folder / "session.toml"
    settings.write_text(
        re.sub(r"\n\[fill\]", "\n[detect]\nnoise_sd = 2.0\n\n[fill]", settings.read_text("utf-8")), "utf-8"
    )
    shutil.rmtree(folder / "results" / "walk01")
    Session.open(folder).run()
    now, _ = edited(folder)
    assert {one.outcome for one in now.applied} <= {"held", "moot", "overruled"}
    with np.load(folder / "truth.npz") as kept:
        assert swaps(now.trajectories, kept["xyz"], [str(name) for name in kept["names"]]) <= 2 + 2
