"""How far paths leave what carries them: of many at once as of each alone, and none where a body moves as one."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from kinemark.edit.probable_errors.carried import Leaving, left_mm, left_together_mm

PATHS, FRAMES = 30, 40


@pytest.fixture
def paths():
    """Paths of a body that turns, with noise and gaps; of frames from 30 on only four or three are there."""
    rng = np.random.default_rng(5)
    body = rng.normal(0, 300, (PATHS, 3))
    turned = [Rotation.from_rotvec([0, 0, 0.02 * f]).apply(body) + np.array([5.0 * f, 0, 0]) for f in range(FRAMES)]
    xyz = np.stack(turned, 1) + rng.normal(0, 2, (PATHS, FRAMES, 3))
    xyz[rng.random((PATHS, FRAMES)) < 0.15] = np.nan
    xyz[4:, 30:], xyz[3:, 36:] = np.nan, np.nan
    seen = np.isfinite(xyz).all(2)
    return SimpleNamespace(xyz=xyz, seen=seen, frames=[np.flatnonzero(own) for own in seen], rate=100.0)


def test_many_at_once_leave_what_carries_them_as_each_does_alone(paths):
    known = 0
    for f in range(FRAMES - 5):
        for g in (f + 1, f + 4):
            some = np.flatnonzero(paths.seen[:, f] & paths.seen[:, g])
            alone = [left_mm(paths, p, g, f) for p in some.tolist()]
            np.testing.assert_allclose(left_together_mm(paths, some, f, g), alone, atol=1e-9)
            known += np.isfinite(alone).sum()
    assert 1000 < known < sum((paths.seen[:, f] & paths.seen[:, f + 1]).sum() for f in range(FRAMES - 5)) * 2


def test_one_that_leaps_is_told_from_what_is_beside_it(paths):
    p = 2
    f = int(np.flatnonzero(paths.seen[p, :-1] & paths.seen[p, 1:])[0])
    paths.xyz[p, f + 1] += [60.0, 0, 0]
    leaving = Leaving(paths)
    beside = leaving.beside(p, f, f + 1)
    assert 0 < beside < 10 < 40 < leaving.mm(p, f, f + 1)
    assert beside == leaving.beside(p, f, f + 1)
