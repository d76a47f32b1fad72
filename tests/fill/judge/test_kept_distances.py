"""Fills of markers that are lost together: moved by the distances that these keep, and by nothing else."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from kinemark.fill import Auto, Gap, fill, judged_fill
from kinemark.fill.filled_gap import FilledGap
from kinemark.fill.judge.choice import ChosenFill
from kinemark.fill.judge.kept_distances import with_kept_distances
from kinemark.fill.marker_array import Prediction
from support.filling import moving, trial

SD = 4.0


def lost(motion, gaps, *, wrong, seed=0, candidates=2, sd=lambda length: np.full(length, SD), times=1.0):
    """The trial without these gaps, and fills of them: each off by a place of its own all through, mm.

    Their standard deviations are those of `sd`, and times as much of the largest is what they say it is.
    """
    rng = np.random.default_rng(seed)
    fills = []
    for gap in gaps:
        xyz = motion.xyz[gap.marker, gap.start : gap.stop] + wrong * rng.normal(0, SD, 3)
        cov = sd(gap.length)[:, None, None] ** 2 * np.eye(3)
        about = motion.names[gap.marker], gap.start, gap.stop, "body", float(np.sqrt(3) * sd(gap.length).mean())
        found = FilledGap(*about, sd_mm=times * float(sd(gap.length).max()))
        fills.append(ChosenFill(gap, found, Prediction(xyz, cov), cov, [None] * candidates))
    return motion.hidden(gaps), fills


def off(motion, fills):
    return [
        np.linalg.norm(f.prediction.xyz - motion.xyz[f.gap.marker, f.gap.start : f.gap.stop], axis=1) for f in fills
    ]


TOGETHER = [Gap(0, 100, 150), Gap(1, 110, 160), Gap(2, 90, 140)]


def test_markers_of_one_body_are_filled_at_their_distances_and_nearer_to_the_truth():
    better = []
    motion = moving(300, noise=0.1)
    for seed in range(12):
        hidden, fills = lost(motion, TOGETHER, wrong=1.0, seed=seed)
        moved = with_kept_distances(hidden, fills)
        better.append(np.mean(np.concatenate(off(motion, moved))) / np.mean(np.concatenate(off(motion, fills))))
        a, b = (f.prediction.xyz[s] for f, s in zip(moved, (slice(10, 40), slice(0, 30)), strict=False))
        truth = np.linalg.norm(motion.xyz[0, 110:140] - motion.xyz[1, 110:140], axis=1)
        assert np.abs(np.linalg.norm(a - b, axis=1) - truth).max() < 0.5
    assert np.mean(better) < 0.9


def test_true_fills_stay_where_they_are():
    hidden, fills = lost(motion := moving(300, soft=0.1, noise=0.02), TOGETHER, wrong=0.0)
    assert max(np.max(each) for each in off(motion, with_kept_distances(hidden, fills))) < 0.2


@pytest.mark.parametrize("gaps, candidates", [(TOGETHER[:1], 2), ([TOGETHER[0], Gap(1, 200, 220)], 2), (TOGETHER, 1)])
def test_alone_or_by_a_method_that_somebody_named_nothing_is_moved(gaps, candidates):
    hidden, fills = lost(moving(300), gaps, wrong=1.0, candidates=candidates)
    assert with_kept_distances(hidden, fills) == fills


def test_a_marker_that_goes_its_own_way_hardly_moves_another():
    motion = moving(300, noise=0.1)
    motion.xyz[1] += np.random.default_rng(1).normal(0, 60, (300, 1)) * np.ones(3)
    hidden, fills = lost(motion, TOGETHER[:2], wrong=1.0)
    (one, _) = with_kept_distances(hidden, fills)
    assert np.abs(one.prediction.xyz - fills[0].prediction.xyz).max() < 0.05


def test_a_fill_does_not_step_where_a_marker_of_its_body_is_lost_or_comes_back():
    """Its place is known the better the nearer its gap's edge: as a seen one's its distance says nothing there."""
    motion = moving(300, noise=0.1)
    for seed in range(4):
        hidden, fills = lost(motion, TOGETHER, wrong=1.0, seed=seed, sd=growing)
        (moved, *_) = with_kept_distances(hidden, fills)
        by = moved.prediction.xyz - fills[0].prediction.xyz
        steps = np.linalg.norm(np.diff(by, axis=0), axis=1)
        assert np.linalg.norm(by, axis=1).max() > 0.5 and steps.max() < 0.3 * np.linalg.norm(by, axis=1).max()


def growing(length):
    """Standard deviation, mm, in the frames of a gap: the greater, the farther from its edges."""
    u = (np.arange(length) + 1) / (length + 1)
    return 4 * SD * u * (1 - u)


def test_exact_fills_stay_where_they_are_though_their_distance_is_another_in_the_gap():
    motion = moving(300)
    motion.xyz[1, 110:160] += 0.05
    hidden, fills = lost(motion, TOGETHER, wrong=0.0, sd=lambda length: np.full(length, 1e-4 * SD))
    assert max(np.max(each) for each in off(motion, with_kept_distances(hidden, fills))) < 5e-4


def test_a_fill_whose_error_cannot_be_what_is_expected_moves_nothing():
    hidden, fills = lost(moving(300, noise=0.1), TOGETHER[:2], wrong=1.0)
    _, contradicted = lost(moving(300, noise=0.1), TOGETHER[:2], wrong=1.0, times=20.0)
    mixed = [fills[0], contradicted[1]]
    assert with_kept_distances(hidden, mixed) == mixed
    assert not any(one is other for one, other in zip(with_kept_distances(hidden, fills), fills, strict=True))


def test_a_turned_trial_is_filled_as_it_was_though_turned_fills_are_less_sure():
    """Calibrated covariances are of single coordinates: they differ by some per cent between directions of axes."""
    turn = Rotation.from_rotvec([0.4, -0.9, 1.2]).as_matrix()
    motion = moving(300, noise=0.1)
    hidden, fills = lost(motion, TOGETHER, wrong=1.0, sd=growing)
    turned = [
        one._replace(
            prediction=one.prediction._replace(xyz=one.prediction.xyz @ turn.T), cov=factor * turn @ one.cov @ turn.T
        )
        for one, factor in zip(fills, (1.0, 1.3, 0.8), strict=True)
    ]
    again = with_kept_distances(hidden._replace(xyz=hidden.xyz @ turn.T), turned)
    for one, other in zip(again, with_kept_distances(hidden, fills), strict=True):
        np.testing.assert_allclose(one.prediction.xyz @ turn, other.prediction.xyz, atol=1e-4)


def test_a_distance_seen_in_a_small_part_of_the_trial_moves_nothing():
    """As of markers of two segments seen together only at rest."""
    motion = moving(300, noise=0.1)
    motion.xyz[1, 60:] += np.minimum(np.arange(240), 100)[:, None]
    hidden, fills = lost(motion, [TOGETHER[0], Gap(1, 60, 299)], wrong=0.0)
    assert max(np.max(each) for each in off(motion, with_kept_distances(hidden, fills))) < 1e-9


def test_fill_keeps_the_distances_of_markers_lost_together(monkeypatch):
    motion = moving(300, soft=6.0, noise=0.3)
    hidden = trial(motion.hidden(TOGETHER))

    def spread(xyz):
        return np.linalg.norm(xyz[0, 110:140] - xyz[1, 110:140], axis=1)

    kept = spread(fill(hidden, limit_mm=np.inf).trajectories.xyz)
    monkeypatch.setattr(judged_fill, "with_kept_distances", lambda _, fills: list(fills))
    before = spread(fill(hidden, limit_mm=np.inf).trajectories.xyz)
    truth = spread(motion.xyz)
    assert np.abs(kept - truth).mean() < np.abs(before - truth).mean()


def test_the_jump_that_is_told_is_that_of_the_fill_in_the_end(monkeypatch):
    hidden = trial(moving(300, noise=0.1).hidden(TOGETHER))

    def stepped(_, fills):
        far = [one.prediction.xyz + 30.0 for one in fills]
        return [f._replace(prediction=f.prediction._replace(xyz=xyz)) for f, xyz in zip(fills, far, strict=True)]

    monkeypatch.setattr(judged_fill, "with_kept_distances", stepped)
    assert all(gap.jump_mm > 30.0 for gap in fill(hidden, method=Auto(("body", "cubic")), limit_mm=np.inf).gaps)
