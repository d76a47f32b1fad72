"""The noise of cameras from epipolar distances, and the rig that is adjusted by them."""

from dataclasses import replace

import numpy as np
import pytest

from kinemark.track.simultaneous import Simultaneous, track_simultaneously
from kinemark.track.simultaneous.detection_index import read_images
from kinemark.track.simultaneous.following.candidate_points import fundamentals
from kinemark.track.simultaneous.noise.epipolar_noise import (
    WINDOW,
    Residuals,
    camera_noise,
    mixture,
    pair_excess,
    pair_of,
    partners,
    peaked,
    residuals,
)
from kinemark.track.simultaneous.noise.measurement_noise import learn_noise, sampled_frames
from kinemark.track.simultaneous.rig.adjusted_rig import adjusted_rig
from support.laboratory import camera, observe, ring
from support.motions import dance, swarm
from support.scenes import make, scene, tally
from support.scenes.imaging import Optics
from support.scenes.placements import off


def learned(rig, detections):
    """Standard deviation (C) px of the images of each camera."""
    images, C = read_images(detections, rig), len(rig)
    some = residuals(images, fundamentals(images.P), sampled_frames(images))
    return np.sqrt(camera_noise(some, mixture(some.off, pair_of(some, C), C * C, some.window), C).variance)


@pytest.mark.parametrize("cameras", [2, 3, 4, 8])
@pytest.mark.parametrize("noise", [0.1, 0.5])
def test_the_noise_is_found_with_two_cameras_and_more(cameras, noise):
    rig = ring(8).select([f"c{i}" for i in range(cameras)])
    detections, _ = observe(rig, dance(n=30, frames=40), noise=noise, cov=False)
    assert learned(rig, detections) == pytest.approx(noise, rel=0.3)


def test_few_markers_are_enough():
    rig = ring(8).select(["c0", "c1"])
    detections, _ = observe(rig, dance(n=6, frames=60), noise=0.3, cov=False)
    assert learned(rig, detections) == pytest.approx(0.3, rel=0.35)


def test_one_camera_that_is_worse_is_told_from_the_others():
    rig = ring(6)
    detections, _ = observe(rig, dance(n=30, frames=40), noise=0.1, cov=False)
    wrong = (detections.camera == 2)[:, None] * np.random.default_rng(0).normal(size=detections.uv.shape) * 0.8
    found = learned(rig, replace(detections, uv=detections.uv + wrong))
    assert found[2] == pytest.approx(0.8, rel=0.2)
    assert np.delete(found, 2) == pytest.approx(0.1, rel=0.5)


def among_uniform(sd, share, window):
    """The mixture of 4000 residuals, a share of them normal and the others anywhere within the window."""
    rng = np.random.default_rng(1)
    off = np.where(rng.random(4000) < share, sd * rng.normal(size=4000), rng.uniform(-window, window, 4000))
    return mixture(off, np.zeros(4000, int), 1, np.full(4000, window))


@pytest.mark.parametrize("sd", [0.05, 0.3, 0.6])
def test_residuals_that_end_at_less_than_the_window_are_not_one_wide_normal_distribution(sd):
    fit = among_uniform(sd, 0.3, 0.6 * WINDOW)
    assert np.sqrt(fit.variance[0]) == pytest.approx(sd, rel=0.15)
    assert fit.number[0] / 4000 == pytest.approx(0.3, abs=0.06)


@pytest.mark.parametrize("sd", [0.05, 0.3, 1.5])
@pytest.mark.parametrize("share", [0.3, 0.8])
def test_a_normal_distribution_among_uniform_residuals(sd, share):
    fit = among_uniform(sd, share, WINDOW)
    assert np.sqrt(fit.variance[0]) == pytest.approx(sd, rel=0.15)
    assert fit.number[0] / 4000 == pytest.approx(share, abs=0.06)


@pytest.mark.parametrize("place", [-4.0, 2.7])
@pytest.mark.parametrize("sd", [0.1, 0.5])
def test_a_peak_aside_is_found_where_none_is_at_0(place, sd):
    """The variance is that about 0, as the images are off by that; what weighs is near the peak."""
    rng = np.random.default_rng(1)
    off = np.where(rng.random(4000) < 0.3, place + sd * rng.normal(size=4000), rng.uniform(-WINDOW, WINDOW, 4000))
    fit = mixture(off, np.zeros(4000, int), 1, np.full(4000, WINDOW))
    assert peaked(fit).all()
    assert np.sqrt(fit.variance[0]) == pytest.approx(np.hypot(place, sd), rel=0.1)
    assert fit.number[0] / 4000 == pytest.approx(0.3, abs=0.06)
    assert (fit.weight[np.abs(off - place) > 3] < 0.1).all()


def test_a_peak_aside_of_two_cameras_beside_others_at_0_is_found_where_each_is_asked_for():
    rng = np.random.default_rng(1)
    group, near = np.repeat([0, 1], 2000), rng.random(4000) < 0.3
    off = np.where(near, 3.5 * group + 0.2 * rng.normal(size=4000), rng.uniform(-WINDOW, WINDOW, 4000))
    window = np.full(4000, WINDOW)
    assert not mixture(off, group, 2, window).about.any()
    fit = mixture(off, group, 2, window, each=True)
    assert np.sqrt(fit.variance[0]) == pytest.approx(0.2, rel=0.15)
    assert fit.about[0] == 0
    assert fit.about[1] == pytest.approx(3.5, abs=0.5)
    assert peaked(fit).all()


@pytest.mark.parametrize("seed", range(5))
def test_chance_alone_has_no_peak(seed):
    off = np.random.default_rng(seed).uniform(-WINDOW, WINDOW, 1000)
    assert not mixture(off, np.zeros(1000, int), 1, np.full(1000, WINDOW)).about.any()


def crowd():
    """Sixty markers and four cameras, the last about half as far from them as the others; images of 0.3 px."""
    rig = ring(3)
    rig = replace(rig, cameras=(*rig, camera("near", [1500.0, 100.0, 1800.0])))
    return rig, observe(rig, swarm(n=60, frames=40), noise=0.3, cov=False)[0]


def test_residuals_lie_anywhere_within_their_windows():
    """Those by chance, which are most of a crowd's: as many in each half of the window."""
    rig, detections = crowd()
    images = read_images(detections, rig)
    some = residuals(images, fundamentals(images.P), sampled_frames(images))
    assert (np.abs(some.off) < some.window).all()
    assert np.median(some.window[some.camera[1] == 3]) < 0.7 * WINDOW
    outer = np.abs(some.off) > 0.7 * some.window
    assert outer[np.abs(some.off) > 0.4 * some.window].mean() == pytest.approx(0.5, abs=0.05)


def test_a_camera_that_stands_near_a_crowd_is_not_taken_for_noisier():
    """Its residuals end at half of the window; taken for one wide peak they were of a noise several times too great."""
    rig, detections = crowd()
    assert learned(rig, detections) == pytest.approx(0.3, rel=0.3)


def by_pairs(C, **offs):
    """Residuals of the pairs of C cameras, by name as p01, whose lines in both images are alike."""
    pair = np.repeat([[int(name[1]), int(name[2])] for name in offs], [len(off) for off in offs.values()], axis=0).T
    off = np.concatenate(list(offs.values()))
    return Residuals(off, pair, pair, np.broadcast_to([0.0, 1.0], (2, len(off), 2)))


def test_a_camera_whose_file_is_off_more_in_some_places_has_the_mean_of_all():
    """Of `gait9`: the mean of logarithms is less, and images of markers were then left out."""
    rng = np.random.default_rng(3)
    sd = {"p01": 0.17, "p02": 0.26, "p03": 0.31, "p12": 0.1, "p13": 0.1, "p23": 0.1}
    some = by_pairs(4, **{name: own * rng.normal(size=300) for name, own in sd.items()})
    fit = mixture(some.off, pair_of(some, 4), 16, some.window)
    variance = camera_noise(some, fit, 4).variance
    assert variance[0] > 0.8 * (fit.variance[[1, 2, 3]].mean() - variance[1:].mean())  # of logarithms: 0.74


def test_two_cameras_whose_lines_are_several_px_off_are_adjusted():
    """Of 4535 samples none was found, as no image met another: a file that is 1 px off moved them 2.7 px apart."""
    made = make(scene(123012))
    count = tally(made, track_simultaneously(made.detections, made.rig, Simultaneous()).tracks)
    assert count.two_found >= 0.99 * count.two
    assert count.ghosts <= 5


def test_residuals_change_with_the_images_as_their_lines_say():
    rig = ring(3)
    detections, _ = observe(rig, dance(n=5, frames=4), noise=0.3)
    images = read_images(detections, rig)
    F = fundamentals(images.P)
    before = residuals(images, F, [0, 1, 2, 3])
    step = 1e-4 * np.random.default_rng(0).normal(size=images.uv.shape)
    after = residuals(images._replace(uv=images.uv + step), F, [0, 1, 2, 3])
    change = sum((line * step[detection]).sum(1) for line, detection in zip(before.line, before.detection, strict=True))
    near = np.abs(before.off) < 2
    assert np.abs(after.off - before.off - change)[near].max() < 2e-6


@pytest.mark.parametrize("cameras", [2, 4, 8])
def test_a_calibration_that_is_off_is_adjusted(cameras):
    rig = ring(8).select([f"c{i}" for i in range(cameras)])
    detections, _ = observe(rig, dance(n=30, frames=60), noise=0.1, cov=False)
    wrong = off(rig, 1.0, np.random.default_rng(4))
    images = read_images(detections, wrong)
    better = adjusted_rig(images, wrong, sampled_frames(images))
    assert np.median(learned(wrong, detections)) > 0.4
    assert np.median(learned(better, detections)) < 0.2


def test_a_good_calibration_is_left_alone():
    rig = ring(6)
    detections, _ = observe(rig, dance(n=20, frames=60), noise=0.1)
    images = read_images(detections, rig)
    better = adjusted_rig(images, rig, sampled_frames(images))
    turned = max(np.abs(one.R - other.R).max() for one, other in zip(rig, better, strict=True))
    assert turned * 1200 < 0.2, "px"


@pytest.mark.parametrize(("cameras", "recall"), [(2, 0.98), (3, 0.99), (4, 0.99)])
def test_markers_are_found_with_a_calibration_one_pixel_off(cameras, recall):
    rig, xyz = ring(8).select([f"c{i}" for i in range(cameras)]), dance(n=12, frames=60)
    detections, marker = observe(rig, xyz, noise=0.1, cov=False)
    result = track_simultaneously(detections, off(rig, 1.0, np.random.default_rng(2)), Simultaneous())
    seen = np.zeros(xyz.shape[:2], int)
    np.add.at(seen, (marker, detections.frame), 1)
    assert len(result.tracks.cloud) >= recall * (seen >= 2).sum()
    assert len(np.unique(result.tracks.id)) <= 14


def test_the_images_are_given_at_least_the_noise_that_was_learned():
    rig = ring(3)
    detections, _ = observe(rig, dance(n=20, frames=60), noise=0.3, cov=False)
    images = read_images(detections, rig)
    _, noise = learn_noise(images, fundamentals(images.P), 5.0)
    assert np.sqrt(noise.white) == pytest.approx(0.3, rel=0.1)
    assert (noise.lasting < 0.25 * noise.white).all()


def off_by(error, stated, seeds=range(4)):
    """Variances (S, 6) px² that positions are solved with, of scenes of images of 0.1 px and files that are off."""
    out = []
    for seed in seeds:
        optics = Optics(noise=0.1, stated=stated, merge=0.0, marked=True, dropout=0.0, false=0.0)
        drawn = scene(seed)._replace(motion="swarm", markers=20, cameras=6, placement="ring", rate=50.0, seconds=1.0)
        made = make(drawn._replace(optics=optics, calibration=error))
        images = read_images(made.detections, made.rig)
        noise = learn_noise(images, fundamentals(images.P), 5.0)[1]
        out.append(np.maximum(noise.white, 0.01 if stated else 0) + noise.lasting)
    return np.array(out)


@pytest.mark.parametrize("stated", [True, False])
@pytest.mark.parametrize("error", [0.0, 0.3])
def test_positions_are_given_what_a_calibration_that_is_off_really_leaves(error, stated):
    variance = off_by(error, stated)
    true = 0.01 + error**2
    assert 0.7 < variance.mean() / true < 1.8  # more than the truth, as few degrees of freedom show it
    assert (variance > 0.6 * true).all()  # none is taken to be right for want of residuals


def two_cameras(off):
    """Pairs of images of two cameras that lie `off` px from each other's lines, which are level."""
    off = np.ravel(off)
    detection, line = np.tile(np.arange(len(off)), (2, 1)), np.tile([0.0, 1.0], (2, len(off), 1))
    return Residuals(off, np.tile([[0], [1]], len(off)), detection, line)


def elsewhere(rng, shape):
    """px from the lines where two images meet by chance."""
    return rng.uniform(-WINDOW, WINDOW, shape)


def test_cameras_that_share_one_marker_at_a_time_are_partners():
    """So are those of three all round who see 15 markers; one and a half a frame were asked for."""
    rng, frames = np.random.default_rng(0), 30
    shared, chance = rng.normal(0, 0.2, frames), elsewhere(rng, (2, frames))
    assert partners(two_cameras([shared, *chance]), 2, frames)[0, 1]
    assert not partners(two_cameras(chance), 2, frames)[0, 1]


@pytest.mark.parametrize("seed", range(3))
def test_images_that_meet_by_chance_and_stay_make_no_partners(seed):
    """Two such pairs of markers that stand lie within a heap, and four farther off: they were partners."""
    rng, frames = np.random.default_rng(seed), 30
    places = np.append(rng.uniform(-0.3, 0.3, 2), [4.0, 6.5, -5.5, -8.0])
    stay = places[:, None] + rng.normal(0, 0.05, (len(places), frames))
    assert not partners(two_cameras(stay), 2, frames)[0, 1]


def test_pairs_of_cameras_that_disagree_more_than_their_noise_are_known():
    """A camera shifted across the lines of one other alone, as a calibration that is off may leave it."""
    rig, C = ring(8).select(["c0", "c1", "c2"]), 3
    detections, _ = observe(rig, dance(n=20, frames=60), noise=0.3, cov=False)
    images = read_images(detections, rig)
    some = residuals(images, fundamentals(images.P), sampled_frames(images))
    shifted = some._replace(off=some.off + np.where(pair_of(some, C) == 1, 0.5, 0.0))
    for each, expected in ((some, 1.0), (shifted, 2.0)):
        fit = mixture(each.off, pair_of(each, C), C * C, each.window)
        ratio = pair_excess(each, fit, np.full(C, 0.3**2))
        assert ratio[0, 1] == ratio[1, 0] == pytest.approx(expected, rel=0.25)
        assert ratio[[0, 1], [2, 2]] == pytest.approx(1.0, abs=0.25)
