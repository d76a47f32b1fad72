"""A fill meets the samples beside its gap, also where a reference marker is missing there."""

import numpy as np
import pytest

from kinemark.fill import Body, Gap
from kinemark.fill.methods.body import fill_body
from kinemark.fill.methods.edge_tie import edge_offsets, tied
from kinemark.fill.methods.kriging import Hyper
from support.filling import moving, off

GAP = Gap(0, 100, 140)


def parabola(frames=200):
    t = np.arange(frames)[:, None]
    return np.array([3.0, -2.0, 1.0]) * t + np.array([0.02, 0.05, -0.03]) * t**2


@pytest.mark.parametrize("side", ["before", "after", "both"])
def test_a_fill_that_was_moved_off_is_moved_back_at_each_edge_that_was_not_learnt(side):
    path, away = parabola(), np.array([5.0, -3.0, 2.0])
    learnt = {99: side == "after", 140: side == "before"}
    offsets = edge_offsets(path, GAP, path[100:140] + away, learnt)
    for edge, known in learnt.items():
        assert np.allclose(offsets[edge], 0 if known else -away, atol=0.06)  # half of the acceleration's step
    back = tied(path[100:140] + away, GAP, offsets, rate=100.0, hyper=Hyper())
    for edge, frame in ((99, 0), (140, -1)):
        miss = np.linalg.norm(back[frame] - path[100:140][frame])
        assert miss > 3 if learnt[edge] else miss < 1.0


def test_a_fill_that_fits_and_an_end_of_the_trial_are_left_alone():
    path = parabola()
    xyz = path[100:140] + 1.0
    assert tied(xyz, GAP, edge_offsets(path, GAP, xyz, {99: True, 140: True}), rate=100.0, hyper=Hyper()) is xyz
    end = Gap(0, 180, 200)
    assert list(edge_offsets(path, end, path[180:], {179: False})) == [179]


@pytest.mark.parametrize("where", [slice(80, 100), slice(140, 160)])
def test_a_reference_marker_missing_beside_the_gap_does_not_part_the_fill_from_what_is_measured(where):
    """Soft tissue moves on the body by millimetres, so that the pose alone does not tell where the marker is."""
    motion = moving(400, soft=4.0, noise=0.05)
    drift = 6.0 * np.sin(np.arange(400) / 12.0)
    xyz = motion.xyz.copy()
    xyz[0, :, 2] += drift
    hidden = motion._replace(xyz=xyz).hidden([GAP, Gap(3, where.start, where.stop)])
    missed = off(fill_body(hidden, [GAP], method=Body())[0], motion._replace(xyz=xyz), GAP)
    assert missed[0] < 0.5 and missed[-1] < 0.5
