"""What local regression states of its error."""

import numpy as np

from kinemark.fill import Gap, LocalRegression
from kinemark.fill.methods.local_regression import fill_local_regression
from support.filling import moving


def test_it_is_less_sure_of_what_is_far_from_what_it_learnt_from():
    """A reference marker swells out in the second gap as it does nowhere else."""
    motion, gaps = moving(300, soft=3.0, noise=0.2), [Gap(2, 100, 120), Gap(2, 200, 220)]
    xyz = motion.hidden(gaps).xyz
    xyz[4, 200:220] += 20.0 * np.sin(np.linspace(0, np.pi, 20))[:, None] ** 2
    said = fill_local_regression(motion._replace(xyz=xyz), gaps, method=LocalRegression())
    usual, rare = (np.sqrt(np.trace(one.cov, axis1=1, axis2=2)) for one in said)
    assert rare[10] > 2 * usual[10] > 0
    assert usual[0] < 0.6 * usual[10] and usual[-1] < 0.6 * usual[10]
