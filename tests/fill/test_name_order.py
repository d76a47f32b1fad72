"""The order in which a file lists its markers changes nothing of a fill."""

from dataclasses import replace

import numpy as np
import pytest

from kinemark.fill import Auto, fill, prepare
from kinemark.fill.name_order import as_before, by_name
from support.filling import swaying, trial

QUICK = Auto(candidates=("quintic", "rigid_body"))


def hidden(gaps, frames=300):
    """Eight markers that move on their body, and so many gaps of 5 to 40 frames in them, up to five in one marker."""
    whole, _ = swaying(8, frames, bend=6.0, seed=4)
    rng, xyz = np.random.default_rng(31), whole.xyz.copy()
    for k in range(gaps):
        start = 10 + 58 * (k // 8) + int(rng.integers(10))
        xyz[k % 8, start : start + int(rng.integers(5, 40))] = np.nan
    return trial(whole._replace(xyz=xyz))


def shuffled(trajectories, seed):
    order = np.random.default_rng(seed).permutation(len(trajectories))
    return replace(trajectories, paths=tuple(trajectories.paths[k] for k in order))


@pytest.mark.parametrize("gaps", [4, 24])
def test_a_file_of_another_order_is_filled_alike(gaps):
    """Hold-out gaps were drawn in the file's order: fills differed by millimetres, and expected errors by times."""
    given = hidden(gaps)
    other = shuffled(given, 1)
    one, two = (fill(t, method=QUICK, limit_mm=np.inf) for t in (given, other))
    assert two.trajectories.names == other.names, "markers stay where the file has them"
    figures = {(gap.marker, gap.start): gap for gap in one.gaps}
    assert [gap.marker for gap in two.gaps] == sorted((g.marker for g in one.gaps), key=other.names.index)
    for gap in two.gaps:
        same = figures[gap.marker, gap.start]
        assert (gap.method, gap.expected_mm, gap.candidates) == (same.method, same.expected_mm, same.candidates)
    for name in given.names:
        assert np.array_equal(one.trajectories[name].xyz, two.trajectories[name].xyz)
        assert np.array_equal(one.trajectories[name].cov, two.trajectories[name].cov, equal_nan=True)


def test_gaps_asked_for_one_by_one_are_alike_too():
    given = hidden(4)
    one, two = (prepare(t, method=QUICK).all_best() for t in (given, shuffled(given, 2)))
    assert {(f.gap.marker, f.first): f.expected_mm for f in one} == {
        (f.gap.marker, f.first): f.expected_mm for f in two
    }
    assert [f.gap.marker for f in one] == list(given.names[:4])


def test_markers_of_one_name_keep_their_places():
    given = hidden(4)
    paths = tuple(replace(path, name="BA"[k % 2]) for k, path in enumerate(given.paths))
    given = replace(given, paths=paths)
    assert by_name(given).names == tuple("AAAABBBB")
    assert all(a is b for a, b in zip(as_before(by_name(given), given).paths, paths, strict=True))
