"""Few markers in a mirrored world: what differs between left and right does so the other way round."""

from dataclasses import replace

import numpy as np

from kinemark.data import MarkerTrajectory
from kinemark.label import label, learn_template
from kinemark.label.asymmetry import sides_are_turned
from kinemark.label.side_pairs import mirrored
from support.named_sessions import walk as walker

UNLIKE = {"LTHI": ("LKNE", 0.10), "RTIB": ("RANK", 0.15), "LTIB": ("LKNE", 0.05), "RHEE": ("RTOE", 0.06)}
"""Markers that sit otherwise than their partners, by a share of the way to another."""


def worn(seed, unlike=UNLIKE):
    """A walk of 15 markers, of which these sit so."""
    trial = walker(seed).trajectories
    at = {name: trial[name].xyz for name in trial.names}
    at |= {name: at[name] + share * (at[to] - at[name]) for name, (to, share) in unlike.items()}
    return replace(trial, paths=tuple(MarkerTrajectory.measured(name, at[name]) for name in trial.names))


def in_mirror(trial):
    return replace(trial, paths=tuple(replace(p, xyz=p.xyz * [1, -1, 1]) for p in trial))


def test_a_mirrored_world_of_few_markers_is_told():
    template, walk = learn_template(worn(7)), worn(17)
    right, wrong = label(walk, template), label(in_mirror(walk), template)
    assert right.undecided is None and right.names == walk.names and set(right.state) == {"sure"}
    assert wrong.undecided is not None and wrong.undecided.kind == "world_mirrored" and "sure" not in wrong.state


def test_one_wand_that_was_put_on_anew_makes_no_mirrored_world():
    template = learn_template(worn(7, {"LTHI": ("LKNE", 0.15)}))
    other = mirrored(template.names)
    for unlike, names, told in (
        ({"LTHI": ("LKNE", 0.15)}, template.names, False),
        ({"RTHI": ("RKNE", 0.15)}, template.names, False),
        (UNLIKE, template.names, False),
        ({"LTHI": ("LKNE", 0.15)}, [template.names[k] for k in other], True),
    ):
        walk = worn(17, unlike)
        y = np.stack([walk[name].xyz[::10] for name in names], axis=1).astype(np.float32)
        assert sides_are_turned(y, template, other) is told
