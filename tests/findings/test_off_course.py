"""Whether the frame rate tells markers apart: by how far they leave their course, against how near they are."""

import numpy as np
import pytest

from kinemark.findings.off_course import off_course_share
from support.captures import capture, judge, ring
from support.findings import found

SECONDS, APART = 2.0, 45.0


def swinging(rate, swing=150.0, markers=4):
    """(M, F, 3) mm: markers 45 mm apart that swing twice a second, as on a foot."""
    t = np.arange(0, SECONDS, 1 / rate)
    path = np.stack([swing * np.sin(4 * np.pi * t), 0 * t, 1000 + 0 * t], -1)
    return path + APART * np.arange(markers)[:, None, None] * np.array([0, 1.0, 0])


def share(xyz, sd=0.5):
    return off_course_share(capture(ring(), xyz, sd=sd)["tracks"])


@pytest.mark.parametrize(("rate", "told"), [(25.0, True), (100.0, False)])
def test_markers_that_swing_by_half_their_distance_need_a_higher_rate(rate, told):
    """The most of (4π)² 150 mm / rate² is 38 mm at 25 Hz, and 2 at 100."""
    rig = ring()
    figures = judge(rig, capture(rig, swinging(rate)))
    most = (4 * np.pi / rate) ** 2 * 150 * np.abs(np.sin(4 * np.pi * np.arange(1, SECONDS * rate - 1) / rate))
    assert figures["tracks"]["off_course_share"] == pytest.approx((most > APART / 2).mean(), abs=0.05)
    assert [one.severity for one in found(figures, "rate_too_low")] == ["amber"] * told


def test_noise_of_the_points_and_the_way_that_all_go_do_not_count():
    still = swinging(25.0, swing=0.0)
    noisy = still + np.random.default_rng(0).normal(0, 8, still.shape)
    assert share(noisy, sd=8.0) == 0
    assert share(noisy, sd=0.5) > 0.2
    assert share(still + 200.0 * np.arange(still.shape[1])[:, None] * np.array([1, 0, 0])) == 0
    assert share(swinging(25.0, markers=1)) == 0
    assert np.isnan(share(still[:, :2]))
