"""Laws of kriging on the pose: what is left out and averaged, which donors are trusted, what the other side says."""

import numpy as np
import pytest
from shared import shared_data
from test_fill import moving, off, trial

from kinemark.fill import Body, Edges, Gap, LocalRegression, Motion, fill, find_gaps
from kinemark.fill.kriging import Hyper, Pairs, fit, left_out, predict
from kinemark.fill.methods import FILLERS
from kinemark.fill.trusted import Trust
from kinemark.formats import read
from kinemark.synth import dressed, walking


def frames(n, *, seed=0, wanted=0):
    """n frames to learn from and some more, in pairs with those n; |φ|² of all."""
    rng = np.random.default_rng(seed)
    t, phi = np.arange(n + wanted) / 30, rng.normal(0, 0.5, (n + wanted, 4))
    side = np.arange(n + wanted) % 3 == 0
    square = (phi**2).sum(1)
    dot = phi @ phi[:n].T
    half = (square[:, None] + square[:n]) / 2 - dot
    return Pairs(dot, half, np.abs(t[:, None] - t[:n]), side[:, None] == side[:n]), square


class TestKriging:
    def test_what_a_block_is_missed_by_is_what_learning_without_it_misses_it_by(self):
        pairs, square = frames(40)
        y, h = np.random.default_rng(1).normal(0, 3, (40, 3)), Hyper(lam=5.0, nu=0.1)
        blocks = [np.arange(5, 12), np.arange(30, 37)]
        off = []
        for b in blocks:
            rest = np.setdiff1d(np.arange(40), b)
            some = Pairs(*(each[rest][:, rest] for each in pairs))
            wanted = Pairs(*(each[b][:, rest] for each in pairs))
            said, _ = predict(wanted, square[b], fit(some, y[rest], h))
            off.append(np.linalg.norm(said - y[b], axis=1))
        assert np.isclose(left_out(fit(pairs, y, h), blocks), np.concatenate(off).mean(), rtol=1e-6)

    def test_what_is_seen_is_met_and_what_is_far_is_not_known(self):
        pairs, square = frames(30, wanted=5)
        y, h = np.random.default_rng(2).normal(0, 3, (30, 3)), Hyper(nu=1e-6)
        seen = fit(Pairs(*(each[:30] for each in pairs)), y, h)
        there, var = predict(Pairs(*(each[:30] for each in pairs)), square[:30], seen)
        _, beyond = predict(Pairs(*(each[30:] for each in pairs)), square[30:], seen)
        assert np.allclose(there, y, atol=0.01) and var.max() < 1e-3 * beyond.min()


def test_several_frames_and_bends_do_better_than_one():
    subject = dressed(walking(duration_s=3, rate=100.0, wobble_mm=2.0, seed=6), 24, seed=6)
    motion = Motion(subject.xyz + np.random.default_rng(6).normal(0, 0.4, subject.xyz.shape), 100.0, subject.names)
    ratio = []
    for marker in range(0, 24, 2):
        gap = Gap(marker, 60, 200)
        one, many = (
            off(FILLERS[Body](motion.hidden([gap]), [gap], method=method)[0], motion, gap).mean()
            for method in (Body(bases=1, kept=1), Body())
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
    return Motion(xyz + rng.normal(0, 0.3, xyz.shape), 100.0, tuple(f"{s}M{k}" for s in "LR" for k in range(7)))


def test_the_other_side_teaches_where_little_of_the_stride_is_left():
    """What is seen of the marker is one part of the stride: its mean is not the other side's; and the partner of the
    marker is no donor, as its own partner is missing."""
    errors = []
    for seed in (3, 4):
        motion = mirrored(200, seed=seed)
        for marker in range(7):
            gap = Gap(marker, 10, 185)
            (said,) = FILLERS[Body](motion.hidden([gap]), [gap], method=Body())
            errors.append(off(said, motion, gap).mean())
    assert np.median(errors) < 2  # 4.7 mm with the mean of what is left


class TestTrust:
    @pytest.mark.parametrize("method", [LocalRegression(), Body()], ids=lambda m: type(m).__name__)
    def test_a_donor_that_jumps_within_the_gap_hardly_matters(self, method):
        motion, gap = moving(400, soft=3.0, noise=0.2), Gap(2, 150, 230)
        hidden = motion.hidden([gap])
        filler = FILLERS[type(method)]
        (whole,) = filler(hidden, [gap], method=method)
        for donor in whole.donors[:3]:
            bad = hidden.xyz.copy()
            bad[donor, 170:200] += [30.0, 0, 0]
            (said,) = filler(hidden._replace(xyz=bad), [gap], method=method)
            assert donor not in said.donors
            assert np.linalg.norm(said.xyz - whole.xyz, axis=1).max() < 2

    def test_the_error_said_is_true_although_a_donor_jumps(self):
        inside, ratio = [], []
        for seed in range(4):
            motion, gap = moving(400, soft=3.0, noise=0.3, seed=seed), Gap(2, 150, 230)
            hidden = motion.hidden([gap])
            hidden.xyz[5, 170:200] += [30.0, 0, 0]
            done = fill(trial(hidden), method=Body(), edges=Edges(most=0))
            path, at = done.trajectories.paths[2], slice(150, 230)
            error = path.xyz[at] - motion.xyz[2, at]
            sd = np.sqrt(np.diagonal(path.cov[at], axis1=1, axis2=2))
            inside.append((np.abs(error) < 1.96 * sd).mean())
            ratio.append(np.linalg.norm(error, axis=1).mean() / done.gaps[0].expected_mm)
        assert np.mean(inside) > 0.9 and 0.5 < np.exp(np.mean(np.log(ratio))) < 2

    def test_a_fast_movement_is_no_jump(self):
        motion = moving(300)
        motion.xyz[:, 150:] += [60.0, 0, 0]  # within one frame
        assert Trust(motion).bends[:, 145:155].any(1).all() and Trust(motion).of(Gap(0, 140, 160)).all()

    def test_the_neighbours_of_one_that_jumps_are_trusted(self):
        motion = moving(300)
        motion.xyz[3, 150:155] += 40.0
        assert np.flatnonzero(~Trust(motion).of(Gap(0, 140, 160))).tolist() == [3]
        assert Trust(motion).of(Gap(0, 200, 220)).all()

    def test_in_a_serve_the_arm_that_jumps_does_not_take_the_shoulder_along(self):
        folder = shared_data("mocap3d/tennis_serve_gap_pair")
        truth, gaps = (read(folder / f"kinematics_tennis_serve{end}.c3d").trajectories for end in ("", "_nan"))
        motion = Motion.of(gaps)
        worst = next(gap for gap in find_gaps(motion) if gap.start == 192)
        (said,) = FILLERS[Body](motion, [worst], method=Body())
        assert off(said, Motion.of(truth), worst).mean() < 10  # of 45 mm with the upper arm as a donor
