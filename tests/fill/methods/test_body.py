"""Laws of kriging on the pose: what is left out and averaged, which reference markers count, what the mirror says."""

import numpy as np
import pytest
from scipy.special import gamma, kv

from kinemark.fill import Body, Gap, LocalRegression, MarkerArray, fill, find_gaps
from kinemark.fill.jumping_markers import JumpingMarkers
from kinemark.fill.methods.body import _best, _gap_training, _trial, common_hyper
from kinemark.fill.methods.kriging import FramePairs, Hyper, covariance, fit, left_out, matern, predict
from kinemark.fill.methods.stage import filler_of
from kinemark.fill.methods.training_frames import local_view, training_frames_of
from kinemark.fill.mirrored_markers import partners
from kinemark.fill.reference_ranking import Ranks
from kinemark.io.trial import read_trial
from kinemark.synth import walking, with_markers
from support.filling import moving, off, trial
from support.shared import shared_data


class Frames:
    """Frames at random poses and turns, some of two sources; pairs of some with others, of the first source first."""

    def __init__(self, n, *, own, seed=0):
        rng = np.random.default_rng(seed)
        self.t, self.own = np.arange(n) / 30, own
        self.parts = rng.normal(0, 0.5, (2, n, 4))
        self.square = (self.parts**2).sum(2)

    def pairs(self, rows, columns):
        dot = np.einsum("prd,pcd->prc", self.parts[:, rows], self.parts[:, columns])
        apart = np.abs(self.t[rows][:, None] - self.t[columns])
        own = np.count_nonzero(rows < self.own), np.count_nonzero(columns < self.own)
        return FramePairs(dot, self.square[:, rows], self.square[:, columns], apart, own)


class TestKriging:
    def test_what_a_block_is_missed_by_is_what_learning_without_it_misses_it_by(self):
        seen, every = Frames(40, own=25), np.arange(40)
        y, h = np.random.default_rng(1).normal(0, 3, (40, 3)), Hyper(lam=5.0, nu=0.1)
        blocks = [np.arange(5, 12), np.arange(30, 37)]
        off = []
        for b in blocks:
            rest = np.setdiff1d(every, b)
            predictions, _ = predict(seen.pairs(b, rest), fit(seen.pairs(rest, rest), y[rest], h))
            off.append(np.linalg.norm(predictions - y[b], axis=1))
        assert np.isclose(left_out(fit(seen.pairs(every, every), y, h), blocks), np.concatenate(off).mean(), rtol=1e-6)

    def test_what_is_seen_is_met_and_what_is_far_is_not_known(self):
        frames, n = Frames(35, own=35), np.arange(30)
        y, h = np.random.default_rng(2).normal(0, 3, (30, 3)), Hyper(nu=1e-6)
        seen = fit(frames.pairs(n, n), y, h)
        there, var = predict(frames.pairs(n, n), seen)
        _, beyond = predict(frames.pairs(np.arange(30, 35), n), seen)
        assert np.allclose(there, y, atol=0.01) and var.max() < 1e-3 * beyond.min()

    @pytest.mark.parametrize("order", [1.5, 3.5])
    def test_matern_is_that_of_bessel_functions(self, order):
        r = np.linspace(0.01, 6, 50)
        x = np.sqrt(2 * order) * r
        assert np.allclose(matern(r, order), 2 ** (1 - order) / gamma(order) * x**order * kv(order, x), rtol=1e-9)

    def test_how_the_part_is_turned_counts_by_theta(self):
        frames, n = Frames(20, own=12), np.arange(20)
        without = frames.pairs(n, n)._replace(dot=np.stack([frames.pairs(n, n).dot[0], np.zeros((20, 20))]))
        without = without._replace(rows=without.rows * [[1], [0]], columns=without.columns * [[1], [0]])
        unturned, turned = Hyper(theta=0.0), Hyper(theta=0.5)
        assert np.allclose(covariance(frames.pairs(n, n), unturned), covariance(without, unturned))
        assert not np.allclose(covariance(frames.pairs(n, n), turned), covariance(without, turned), rtol=0.01)


@pytest.mark.parametrize(("noise", "most"), [(0.0, 0.1), (0.3, 2.0)])
def test_a_marker_that_moves_smoothly_by_itself_is_met_in_a_short_gap(noise, most):
    """With a covariance that is only once differentiable, and the usual noise, 0.32 and 2.7 mm."""
    motion, t = moving(300, soft=3.0, noise=noise), np.arange(300) / 100
    motion.xyz[2] += 4 * np.stack([np.sin(13 * t), np.cos(11 * t), np.sin(9 * t + 1)], 1)
    errors = []
    for start in range(40, 240, 20):
        gap = Gap(2, start, start + 15)
        (predictions,) = filler_of(Body())(motion.hidden([gap]), [gap], method=Body())
        errors.append(off(predictions, motion, gap).mean())
    assert np.median(errors) < most


def test_several_frames_and_bends_do_better_than_one():
    subject = with_markers(walking(duration_s=3, rate=100.0, wobble_mm=2.0, seed=6), 24, seed=6)
    motion = MarkerArray(subject.xyz + np.random.default_rng(6).normal(0, 0.4, subject.xyz.shape), 100.0, subject.names)
    ratio = []
    for marker in range(0, 24, 2):
        gap = Gap(marker, 60, 200)
        one, many = (
            off(filler_of(Body())(motion.hidden([gap]), [gap], method=method)[0], motion, gap).mean()
            for method in (Body(local_frames=1, averaged=1), Body())
        )
        ratio.append(many / one)
    assert np.exp(np.mean(np.log(ratio))) < 0.97


def mirrored(n, *, seed=3):
    """Two sides of seven markers; the right one does half a cycle later, mirrored, what the left one does."""
    rng = np.random.default_rng(seed)
    shape, sway = rng.normal(0, 80, (7, 3)), rng.normal(0, 3, (3, 7, 3))

    def left(t):
        wave = np.stack([np.sin(t), np.cos(t), np.sin(2 * t)])
        return shape[:, None] + np.einsum("kf,kmi->mfi", wave, sway) + [300.0, 0, 900]

    phase = 2 * np.pi * np.arange(n) / 100
    xyz = np.concatenate([left(phase), left(phase + np.pi) * [-1.0, 1, 1]])
    return MarkerArray(xyz + rng.normal(0, 0.3, xyz.shape), 100.0, tuple(f"{s}M{k}" for s in "LR" for k in range(7)))


def test_the_other_side_teaches_where_little_of_the_stride_is_left():
    """What is seen of the marker is one part of the stride: its mean is not the other side's; and the partner of the
    marker is no reference marker, as its own partner is missing."""
    errors = []
    for seed in (3, 4):
        motion = mirrored(200, seed=seed)
        for marker in range(7):
            gap = Gap(marker, 10, 185)
            (predictions,) = filler_of(Body())(motion.hidden([gap]), [gap], method=Body())
            errors.append(off(predictions, motion, gap).mean())
    assert np.median(errors) < 2  # 4.7 mm with the mean of what is left


class TestTrust:
    @pytest.mark.parametrize("method", [LocalRegression(), Body()], ids=lambda m: type(m).__name__)
    def test_a_reference_marker_that_jumps_within_the_gap_hardly_matters(self, method):
        motion, gap = moving(400, soft=3.0, noise=0.2), Gap(2, 150, 230)
        hidden = motion.hidden([gap])
        filler = filler_of(method)
        (whole,) = filler(hidden, [gap], method=method)
        for reference in whole.references[:3]:
            bad = hidden.xyz.copy()
            bad[reference, 170:200] += [30.0, 0, 0]
            (predictions,) = filler(hidden._replace(xyz=bad), [gap], method=method)
            assert reference not in predictions.references
            assert np.linalg.norm(predictions.xyz - whole.xyz, axis=1).max() < 2

    def test_the_error_said_is_true_although_a_reference_marker_jumps(self):
        inside, ratio = [], []
        for seed in range(4):
            motion, gap = moving(400, soft=3.0, noise=0.3, seed=seed), Gap(2, 150, 230)
            hidden = motion.hidden([gap])
            hidden.xyz[5, 170:200] += [30.0, 0, 0]
            done = fill(trial(hidden), method=Body(), limit_mm=np.inf)  # none is left open, however it jumps
            path, at = done.trajectories.paths[2], slice(150, 230)
            error = path.xyz[at] - motion.xyz[2, at]
            sd = np.sqrt(np.diagonal(path.cov[at], axis1=1, axis2=2))
            inside.append((np.abs(error) < 1.96 * sd).mean())
            ratio.append(np.linalg.norm(error, axis=1).mean() / done.gaps[0].expected_mm)
        assert np.mean(inside) > 0.9 and 0.5 < np.exp(np.mean(np.log(ratio))) < 2

    def test_a_fast_movement_is_no_jump(self):
        motion = moving(300)
        motion.xyz[:, 150:] += [60.0, 0, 0]  # within one frame
        assert (
            JumpingMarkers(motion, Ranks(motion)).bends[:, 145:155].any(1).all()
            and JumpingMarkers(motion, Ranks(motion)).of(Gap(0, 140, 160)).all()
        )

    def test_the_neighbours_of_one_that_jumps_are_trusted(self):
        motion = moving(300)
        motion.xyz[3, 150:155] += 40.0
        assert np.flatnonzero(~JumpingMarkers(motion, Ranks(motion)).of(Gap(0, 140, 160))).tolist() == [3]
        assert JumpingMarkers(motion, Ranks(motion)).of(Gap(0, 200, 220)).all()

    def test_in_a_serve_the_arm_that_jumps_does_not_take_the_shoulder_along(self):
        folder = shared_data("mocap3d/tennis_serve_gap_pair")
        truth, gaps = (read_trial(folder / f"kinematics_tennis_serve{end}.c3d").trajectories for end in ("", "_nan"))
        motion = MarkerArray.of(gaps)
        worst = next(gap for gap in find_gaps(motion) if gap.start == 192)
        (predictions,) = filler_of(Body())(motion, [worst], method=Body())
        assert (
            off(predictions, MarkerArray.of(truth), worst).mean() < 10
        )  # of 45 mm with the upper arm as a reference marker


def test_what_a_frame_varies_by_is_that_of_the_whole_covariance():
    frames, n, w = Frames(40, own=25), np.arange(35), np.arange(20, 25)
    n = np.setdiff1d(n, w)
    y, h = np.random.default_rng(1).normal(0, 3, (30, 3)), Hyper(lam=0.1, nu=0.1, theta=0.5, ell=0.02)
    found = fit(frames.pairs(n, n), y, h)
    k, K = covariance(frames.pairs(w, n), h), covariance(frames.pairs(n, n), h) + h.nu * np.eye(30)
    left = np.diag(covariance(frames.pairs(w, w), h)) - np.einsum("ij,ji->i", k, np.linalg.solve(K, k.T))
    assert np.allclose(predict(frames.pairs(w, n), found)[1], left[:, None] * found.tau2, rtol=1e-6)


def test_which_way_the_other_side_faces_does_not_matter():
    motion, gap = mirrored(200), Gap(0, 60, 120)
    references, side = np.arange(1, 5), partners(motion.names)
    hidden = motion.hidden([gap])
    training = training_frames_of(hidden, hidden.seen, gap, references, partner=side, most=100, rate_hz=30.0)
    R = np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]])
    xyz = np.where((training.side == 1)[:, None], training.xyz @ R.T, training.xyz)
    one, other = (local_view(s, (1, 2, 3)) for s in (training, training._replace(xyz=xyz)))
    assert np.allclose(one.turned, other.turned, atol=1e-9) and np.allclose(one.pose, other.pose, atol=1e-9)


def test_hyper_of_many_gaps_is_no_single_ones():
    motion, t = moving(300, soft=3.0, noise=0.3), np.arange(300) / 100
    motion.xyz[2] += 4 * np.stack([np.sin(13 * t), np.cos(11 * t), np.sin(9 * t + 1)], 1)
    gaps = [Gap(m, s, s + 15) for m, s in ((2, 60), (0, 100), (1, 150), (3, 200))]
    hidden = motion.hidden(gaps)
    common = common_hyper(hidden, gaps, method=Body())
    assert common == common_hyper(hidden, gaps[::-1], method=Body())
    assert common != common_hyper(hidden, gaps[:1], method=Body())
    assert common_hyper(hidden, [], method=Body()) == Hyper()
    assert common_hyper(hidden._replace(xyz=np.full_like(hidden.xyz, np.nan)), gaps, method=Body()) == Hyper()


def test_four_like_gaps_have_the_hyper_of_one():
    for marker in (1, 2, 3, 6):
        motion, gap = mirrored(200, seed=3), Gap(marker, 60, 100)
        look = _gap_training(_trial(motion.hidden([gap]), Body()), gap, Body())
        assert _best([look] * 4) == _best([look])
