"""The aspect ratio of pixels from a bar that is turned (UM²AS 4.1)."""

import numpy as np
import pytest

from kinemark.calibrate import aspect_ratio
from kinemark.data import KinemarkError
from support.studies import figures, printed

HALF = np.array([40.0, 70.0, 100.0, 130.0])
STEPS = np.arange(0, 361, 36.0)


def bar(factor, *, angles=STEPS, noise=0.0, rng=None, eccentric=(0.0, 0.0)):
    """Eight markers (S, 8, 2) px of a bar at angles (S) deg, V divided by `factor`."""
    a = np.radians(angles)[:, None]
    along = np.concatenate([-HALF[::-1], HALF]) + eccentric[0]
    x, y = np.cos(a) * along - np.sin(a) * eccentric[1], np.sin(a) * along + np.cos(a) * eccentric[1]
    uv = np.stack([300 + x, (250 + y) / factor], -1)
    return uv + (noise * rng.normal(size=uv.shape) if noise else 0.0)


@pytest.mark.parametrize("factor", [0.5, 0.8407, 1.0, 1.3])
def test_the_factor_comes_back_and_makes_all_distances_equal(factor):
    a = aspect_ratio(bar(factor, eccentric=(5.0, -3.0)))
    assert a.factor == pytest.approx(factor, rel=1e-9)
    assert a.after == pytest.approx(np.tile(2 * HALF[::-1], (11, 1)), rel=1e-9)
    assert a.spread[1] < 1e-6
    turn = np.radians(36.0 * np.arange(11))
    assert a.spread[0] == pytest.approx(260 * np.ptp(np.hypot(np.cos(turn), np.sin(turn) / factor)), rel=0.05, abs=1e-6)


def test_the_thesiss_equations_need_a_root():
    """With eq. 4.3 and 4.5, CF is the factor if eq. 4.4 gives CF², and its square as printed."""
    a = aspect_ratio(bar(0.8407))
    assert a.cf == pytest.approx(0.8407, rel=1e-9)
    assert a.cf_printed == pytest.approx(0.8407**2, rel=1e-9)


def test_no_step_need_be_level_and_markers_may_be_hidden():
    uv = bar(0.85, angles=np.arange(13.0, 170.0, 20.0))
    uv[2, 3], uv[5, 0], uv[5, 7] = np.nan, np.nan, np.nan
    a = aspect_ratio(uv)
    assert a.factor == pytest.approx(0.85, rel=1e-9)
    assert np.isnan(a.cf)
    assert np.isnan(a.after).sum() == 2
    assert np.isfinite(a.spread).all()


def test_a_pair_that_is_never_seen_does_no_harm():
    uv = bar(0.85)
    uv[:, 0] = np.nan
    a = aspect_ratio(uv)
    assert a.factor == pytest.approx(0.85, rel=1e-9)
    assert a.spread[0] > 1 > 1e-6 > a.spread[1]


def test_the_standard_deviation_is_true():
    rng, z = np.random.default_rng(0), []
    for _ in range(200):
        a = aspect_ratio(bar(0.8407, angles=rng.uniform(0, 360, 8), noise=0.3, rng=rng))
        z.append((a.factor - 0.8407) / a.sd)
    assert abs(np.mean(z)) < 0.25
    assert 0.85 < np.std(z) < 1.15


def test_all_distances_together_are_better_than_the_mean_of_the_roots():
    rng, off = np.random.default_rng(1), []
    for _ in range(100):
        a = aspect_ratio(bar(0.8407, noise=0.3, rng=rng))
        off.append((a.factor - 0.8407, a.cf - 0.8407))
    together, roots = np.sqrt((np.array(off) ** 2).mean(0))
    assert together < 0.7 * roots


REFUSED = {
    "not turned": bar(0.85, angles=np.zeros(11)),
    "turned by half": bar(0.85, angles=np.arange(11) * 180.0),
    "one step": bar(0.85, angles=np.array([20.0])),
    "not seen": np.full((11, 8, 2), np.nan),
}


@pytest.mark.parametrize("case", REFUSED)
def test_a_bar_that_tells_nothing_is_refused(case):
    with pytest.raises(KinemarkError, match=r"Turn (it|the bar)"):
        aspect_ratio(REFUSED[case])


def test_noise_alone_tells_nothing():
    for seed in range(8):
        with pytest.raises(KinemarkError, match="so the aspect ratio is unknown"):
            aspect_ratio(bar(0.85, angles=np.zeros(11), noise=0.3, rng=np.random.default_rng(seed)))


@pytest.mark.parametrize("shape", [(11, 7, 2), (11, 8, 3), (11, 8), (11, 0, 2)])
def test_wrong_calls_are_refused(shape):
    with pytest.raises(ValueError, match="an even number of markers"):
        aspect_ratio(np.zeros(shape))


def test_the_study_prints_the_figures_of_the_documentation():
    text = printed("aspect_ratio")
    before, after, factor, sd, root, _, as_printed, left = figures(text, "centroids")
    assert before == pytest.approx(71.8, abs=0.3)
    assert after < 0.1
    assert factor == pytest.approx(0.8407, abs=4 * sd + 1e-5)
    assert root == pytest.approx(0.8407, abs=2e-4)
    assert as_printed == pytest.approx(0.8407**2, abs=1e-3)
    assert left > 50
    assert figures(text, "whole pixels")[1] < 2
    _, sd, stated = figures(text, "mean error")
    assert stated == pytest.approx(sd, rel=0.25)
