"""The covariance of a body that is not quite rigid."""

import numpy as np

from kinemark.fill import Gap
from kinemark.fill.methods.rigid_body import fill_rigid_body
from support.filling import moving

GAP = Gap(0, 200, 230)


def squares(motion):
    """(L) mm², the trace of the covariance in the gap."""
    (said,) = fill_rigid_body(motion.hidden([GAP]), [GAP])
    return np.trace(said.cov, axis1=1, axis2=2)


def test_a_body_that_changes_its_shape_in_the_gap_is_less_sure():
    """The gap shows nothing else that tells a hard one."""
    motion = moving(400, noise=0.3)
    bent = motion.xyz.copy()
    bent[1:, 190:240] += np.random.default_rng(1).normal(0, 10, (len(bent) - 1, 1, 3))
    assert (squares(motion._replace(xyz=bent)) > 4 * squares(motion)).all()


def test_a_body_without_any_change_of_shape_has_a_covariance():
    assert np.isfinite(squares(moving(400))).all()
