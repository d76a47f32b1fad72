"""What an image is worth to a point: its noise, what the model leaves out, its tails, its size beside the others'."""

from dataclasses import replace

import numpy as np
import pytest

from kinemark.geometry.hidden_images import hidden_variance
from kinemark.match import match
from kinemark.reconstruct import LeastSquares, reconstruct
from kinemark.reconstruct.camera_pairs import agreeing
from support.laboratory import observe, ring
from support.motions import swarm

RIG = ring(6)
POINTS = swarm(n=5, frames=6)


def traces(cloud):
    return np.trace(cloud.cov, axis1=1, axis2=2)


def test_where_images_are_perfect_what_the_model_leaves_out_remains():
    detections, _ = observe(RIG, POINTS, noise=0.0)
    sharp = replace(detections, cov=detections.cov * 1e-8)
    matches = match(sharp, RIG)
    one, two = (reconstruct(matches, sharp, RIG, method=LeastSquares(model_sd=sd)) for sd in (0.05, 0.1))
    assert traces(two) == pytest.approx(4 * traces(one), rel=1e-3)


def test_a_wild_image_never_makes_a_point_surer():
    """Those that agree with one another keep their covariance; the wild one loses its weight."""
    detections, _ = observe(RIG, POINTS, noise=0.1)
    matches = match(detections, RIG)
    wild = replace(detections, uv=detections.uv + 20.0 * (detections.camera == 2)[:, None])
    plain, robust = (
        reconstruct(matches, wild, RIG, method=LeastSquares(degrees_of_freedom=tails)) for tails in (0.0, 4.0)
    )
    others = reconstruct(
        replace(matches, detection=np.where(np.arange(6) == 2, -1, matches.detection)), detections, RIG
    )
    assert len(plain) == len(robust) == len(others)
    assert (traces(robust) > 0.95 * traces(plain)).all()
    assert (traces(robust) > 0.95 * traces(others)).all() and (traces(robust) < 1.3 * traces(others)).all()


@pytest.mark.parametrize("share", [0.5, 2.0])
def test_only_the_image_of_another_size_is_doubted(share):
    """Half hidden or two markers in one: it is that image which is worth less, and none of the others."""
    xyz = POINTS[:, 0]
    scale = np.stack([c.K[0, 0] / (xyz @ c.R.T + c.t)[:, 2] for c in RIG], 1)
    area = np.pi * (12.5 * scale) ** 2
    area[:, 4] *= share
    variance = hidden_variance(RIG, xyz, area)
    radius = 12.5 * scale[:, 4]
    assert (np.delete(variance, 4, axis=1) < 0.01).all()
    assert variance[:, 4] == pytest.approx((1 - share) ** 2 * radius**2 / 2, rel=0.1)


@pytest.mark.parametrize(("third", "kept"), [(2.9, [True, True, True]), (3.0, [True, True, False])])
def test_a_solution_exactly_twice_as_far_is_left_out_as_in_the_document(third, kept):
    """Three solutions in a row: d₃ = 1, d₁ = third, d₂ = third − 1; out if both are 2 d₃ or more (UM²AS, 2.4)."""
    each = np.array([[[0.0, 0, 0], [1.0, 0, 0], [third, 0, 0]]])
    assert agreeing(each, np.array([3])).tolist() == [kept]


def test_solutions_equally_far_from_each_other_are_all_kept():
    """However small the excess: "use all three if they are an equal distance from each other"."""
    each = np.eye(3)[None] * 100.0
    assert agreeing(each, np.array([3]), outlier_ratio=1.0).all()
