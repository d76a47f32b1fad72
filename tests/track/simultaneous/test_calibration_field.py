"""What a calibration that is off and does not say so leaves: found, carried into σ, and not filtered away."""

from dataclasses import replace

import numpy as np
import pytest

from kinemark.data import Rig
from kinemark.geometry import parameter_jacobian
from kinemark.track.simultaneous import Simultaneous, track_simultaneously
from kinemark.track.simultaneous.detection_index import read_images
from kinemark.track.simultaneous.following.candidate_points import fundamentals
from kinemark.track.simultaneous.noise.calibration_field import LOG_VARIANCES, CalibrationField
from kinemark.track.simultaneous.noise.epipolar_noise import Mixture
from kinemark.track.simultaneous.noise.measurement_noise import learn_noise
from support.laboratory import observe, ring
from support.motions import dance
from support.scenes import make, scene
from support.scenes.tally import owners

WITHIN = 7.815  # 95 % of χ² with three degrees of freedom


def share_in_ellipsoids(seed, **change):
    """Of the points of a scene of the second generator, those whose 95 % ellipsoid holds the truth."""
    drawn = scene(seed)
    optics = drawn.optics._replace(stated=change.pop("stated"))
    made = make(drawn._replace(optics=optics, markers=15, seconds=min(drawn.seconds, 30 / drawn.rate), **change))
    tracks = track_simultaneously(made.detections, made.rig, Simultaneous()).tracks
    owner, _ = owners(made, tracks)
    own, cloud = owner >= 0, tracks.cloud
    error = cloud.xyz[own] - made.xyz[owner[own], cloud.frame[own]]
    return (np.einsum("ni,nij,nj->n", error, np.linalg.inv(cloud.cov[own]), error) < WITHIN).mean()


def test_ellipsoids_hold_the_truth_with_a_calibration_that_does_not_say_that_it_is_off():
    seeds = (31, 32, 33, 34)
    held = [share_in_ellipsoids(k, cameras=3 + k % 4, calibration=1.0, stated=k % 2 == 0) for k in seeds]
    assert np.mean(held) > 0.9


def off_as_stated(sd_px, said, cameras=6):
    """What is learned (6) px² of cameras that were moved so much, and say that they were, times a factor."""
    rig, rng = ring(6).select(ring(6).names[:cameras]), np.random.default_rng(0)
    detections, _ = observe(rig, dance(n=20, frames=60), noise=0.1)
    cameras = []
    for camera in rig:
        J = parameter_jacobian(camera, np.array([[0.0, 0.0, 1000.0]]))[0, :, 12:14]
        sd = sd_px / np.linalg.norm(J, axis=0)
        cov = np.zeros((15, 15))
        cov[[12, 13], [12, 13]] = (said * sd) ** 2
        cameras.append(replace(camera, t=camera.t + np.append(sd * rng.normal(size=2), 0.0), cov=cov))
    images = read_images(detections, Rig(tuple(cameras)))
    return learn_noise(images, fundamentals(images.P), 5.0)[1].lasting


def test_a_calibration_that_states_its_error_is_believed():
    assert (off_as_stated(0.5, said=1.0) == 0).all()


@pytest.mark.parametrize("cameras", [2, 3])
def test_few_cameras_that_state_a_small_error_rightly_are_believed(cameras):
    """Images of two cameras hardly tell how good their calibration is, and nothing says that it is worse."""
    assert (off_as_stated(0.005, said=1.0, cameras=cameras) == 0).all()


def test_a_calibration_that_states_too_little_is_not_believed():
    assert off_as_stated(0.5, said=0.1) == pytest.approx(0.25, rel=0.8)


@pytest.mark.parametrize("white", [0.0, 0.04, 1.0])
def test_what_is_hardly_known_is_given_more_variance_and_what_is_known_is_given_as_it_is(white):
    posterior = np.exp(-0.5 * ((LOG_VARIANCES - np.log(0.09)) / np.array([[0.05], [1.0]])) ** 2)
    none = Mixture(*np.zeros((4, 0)))
    known, hardly = (CalibrationField(p / p.sum(), none, 0.0).variance(white) for p in posterior)
    assert known == pytest.approx(0.09, rel=0.2)
    assert hardly > 1.4 * known
    true = np.exp(np.random.default_rng(0).normal(np.log(0.09), 1.0, 100_000))
    squared = np.random.default_rng(1).chisquare(3, 100_000) * (white + true) / (white + hardly)
    assert (squared < WITHIN).mean() == pytest.approx(0.95, abs=0.01)
