"""Further rows of `labelling.py`: files whose nameless tracks stay beside the markers, and parts of the body.

Nothing was tuned on them but what docs/theory/label.md says.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from labelling_cases import (
    CHILD,
    CHILDREN,
    GAIT,
    PLATES,
    ROOT,
    TUNED_CHILDREN,
    Row,
    child,
    only,
    read,
    whole_body,
)

from kinemark.data import Trajectories
from kinemark.io.marker_sets import read_marker_set
from kinemark.label import learn_template, static_template
from kinemark.label.from_set import static_bystanders

MARKERS_OF_LEGS = "LASI RASI SACR LPSI RPSI LTHI LKNE LTIB LANK LHEE LTOE RTHI RKNE RTIB RANK RHEE RTOE"
"""Of plug-in-gait-lower, and the sacrum."""
LEGS = tuple(MARKERS_OF_LEGS.split())


def rows_of_parts() -> Iterator[Row]:
    """All of them whose files are here."""
    if ROOT.is_dir():
        yield from with_nameless()
        yield from part_of_body()


def with_nameless() -> Iterator[Row]:
    """Files whose tracks without names stay beside the markers, as `kinemark label` sees them.

    Of the whole body 37 of 42 are markers that its set does not have, on head, thighs, shanks and feet, seen all
    through; two are twins of the heels, three what was left of single frames all over the body, in one channel each.
    """
    body, move = whole_body(), "pig_wholebody/Movement_trial.c3d"
    full = read_marker_set("plug-in-gait-full")
    trial = _with_nameless(move, full.moving)
    yield Row("whole body static, 42 nameless", static_template(body, full), trial, nameless=True)
    still = read("pig_wholebody/Static_trial.c3d")
    own, wider = static_template(still, full), static_bystanders(still, full)
    yield Row("whole body static with 37 of the 42 nameless", own, trial, nameless=True, wider=wider)
    half = trial.n_frames // 2
    learnt = learn_template(only(trial, full.moving).frames(0, half))
    yield Row("whole body by first half, 42 nameless", learnt, trial.frames(half, trial.n_frames), nameless=True)
    plates = read_marker_set("plug-in-gait-lower")
    static = static_template(read(f"{PLATES}Calibration3_FF.c3d"), plates)
    file = f"{PLATES}Motion3_FF.c3d"
    yield Row("three plates static, 7 nameless", static, _with_nameless(file, static.names), nameless=True)
    for name, of, n in (("HC030A", 1, 5), ("HC031A", 1, 1), ("HC033A", 0, 1), ("HC033A", 1, 2)):
        folder, *trials, _ = CHILDREN[name]
        template = learn_template(child(name, 1 - of))
        trial = _with_nameless(f"{folder}/{name}{trials[of]}.c3d", CHILD)
        yield Row(f"{name}{trials[1 - of]} labels {trials[of]}, {n} nameless", template, trial, nameless=True)
    hand = read("ulema_hand_to_head/GHr.c3d")
    half = hand.n_frames // 2
    learnt = learn_template(hand.frames(0, half))
    yield Row(
        "hand to head by first half, 32 nameless",
        learnt,
        _with_nameless("ulema_hand_to_head/GHr.c3d", learnt.names).frames(half, hand.n_frames),
        nameless=True,
    )


def part_of_body() -> Iterator[Row]:
    """Legs or upper body alone, by the template of a whole body; the sacrum is none of its set."""
    full = read_marker_set("plug-in-gait-full")
    trials = [
        ("qualisys", read("qualisys_gait/Static - CGM2 1.c3d"), read(GAIT)),
        ("whole body", whole_body(), read("pig_wholebody/Movement_trial.c3d")),
        *((name, child(name, 2), child(name, 0)) for name in CHILDREN),
    ]
    for name, static, trial in trials:
        template = static_template(static, full)
        upper = [one for one in template.names if one not in LEGS]
        yield Row(f"{name} static, legs alone", template, only(trial, LEGS), tuned=name in TUNED_CHILDREN)
        yield Row(f"{name} static, upper body alone", template, only(trial, upper), tuned=name in TUNED_CHILDREN)


def _with_nameless(file: str, names: Sequence[str]) -> Trajectories:
    """Those of the markers that the file has, and its tracks without names that have samples."""
    trial = read(file)
    own = {*names, *(path.name for path in trial if path.name.startswith("*") and np.isfinite(path.xyz).any())}
    return trial.select([name for name in trial.names if name in own])
