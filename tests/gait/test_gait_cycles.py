"""Gait curves of known strides."""

import numpy as np
import pytest

from kinemark.data import Signal, Signals
from kinemark.data.gait_curves import GaitCurves
from kinemark.data.strides import Stride
from kinemark.gait.emg import emg
from kinemark.gait.gait_cycles import (
    PROFILE,
    dynamic_peaks,
    emg_curves,
    gait_curves,
    most_typical,
    movement_analysis_profile,
    muscle_sides,
    overall_score,
    reference_of,
    scaled_score,
)

RATE, T = 100.0, 1.1
STRIDES = tuple(
    Stride(side, k * T + off, (k + 1) * T + off, {"foot_off": 62.0}, {}) for k in range(4) for side, off in
    (("left", 0.13), ("right", 0.68))
)  # fmt: skip


def curve(share, offset=0.0):
    return 30 + 30 * np.cos(2 * np.pi * share) + offset


def signals(noise=0.0, offset=0.0, seed=0):
    rng = np.random.default_rng(seed)
    t = np.arange(600) / RATE
    out = []
    for letter, start in (("L", 0.13), ("R", 0.68)):
        for name in ("PelvisAngles", "HipAngles", "KneeAngles", "AnkleAngles", "FootProgressAngles"):
            y = np.stack([curve((t - start) / T, offset)] * 3, -1) + rng.normal(0, noise, (600, 3))
            out.append(Signal.of(letter + name, "angle", "deg", y, rate=RATE))
    return Signals(tuple(out))


def test_each_side_is_cut_at_its_own_strikes():
    for one in gait_curves(signals(), STRIDES):
        np.testing.assert_allclose(one.mean[:, 0], curve(np.linspace(0, 1, 101)), atol=0.15)
        assert one.values.shape == (4, 101, 3) and (one.consistency > 0.999).all()


def test_spread_is_between_strides():
    one = gait_curves(signals(noise=2.0), STRIDES)[0]
    assert np.sqrt(np.nanmean(one.spread**2)) == pytest.approx(2.0 * np.sqrt(2 / 3), rel=0.15)  # lines between frames


def test_a_stride_beyond_the_recording_is_missing_and_the_rest_counts():
    beyond = (*STRIDES, Stride("left", 5.5, 6.6, {"foot_off": 60.0}, {}))
    one = gait_curves(signals(), beyond)[0]
    assert np.isnan(one.values[-1]).all() and np.isfinite(one.mean).all()


def test_the_most_typical_stride_is_none_that_differs():
    found = gait_curves(signals(noise=0.5), STRIDES)
    odd = [c._replace(values=c.values + np.array([9.0, 0, 0, 0])[:, None, None]) for c in found]
    assert most_typical(odd, "left") != 0


def means(curves):
    return {one.name: one.mean for one in curves}


def test_the_profile_is_the_distance_from_the_reference():
    reference = reference_of([means(gait_curves(signals(seed=k), STRIDES)) for k in range(3)], "simulated controls")
    own, score = movement_analysis_profile(gait_curves(signals(offset=4.0), STRIDES), reference, "left")
    assert score == pytest.approx(4.0, abs=1e-6) and len(own) == 9
    assert reference.subjects == 3


def test_the_overall_score_counts_the_pelvis_once():
    """Baker et al. (2009): nine variables of the left and six of the right."""
    names = list(PROFILE)
    left, right = dict.fromkeys(names, 3.0), dict.fromkeys(names, 6.0)
    assert overall_score(left, right) == pytest.approx(np.sqrt((9 * 9 + 6 * 36) / 15))
    assert overall_score(left, right | {"pelvic tilt": 90.0}) == overall_score(left, right)
    assert np.isnan(overall_score(left, right | {"hip flexion": np.nan}))


def controls(rng, n, spread):
    """Curves of n subjects that lie about common ones by chance."""
    names = sorted({name for name, _ in PROFILE.values()})
    return [{"L" + name: spread * rng.normal() + rng.normal(0, 0.2, (101, 3)) for name in names} for _ in range(n)]


def test_the_controls_own_scores_are_100_and_10_apart():
    rng = np.random.default_rng(4)
    own = controls(rng, 30, 4.0)
    band = reference_of(own, "ours")
    scaled = []
    for one in own:  # each by all others
        others = reference_of([c for c in own if c is not one], "others")
        curves = [GaitCurves(n, "left", "deg", ("a", "b", "c"), y[None], y[None], np.ones(1)) for n, y in one.items()]
        _, score = movement_analysis_profile(curves, others, "left")
        scaled.append(scaled_score(score, band))
    assert np.mean(scaled) == pytest.approx(100, abs=1e-6) and np.std(scaled, ddof=1) == pytest.approx(10, abs=1e-6)
    assert scaled_score(40.0, band) < 70 < scaled_score(4.0, band)
    assert np.isnan(scaled_score(5.0, reference_of(own[:3], "few"))), "of three controls nothing is said"


def test_a_foot_that_turns_through_180_does_not_jump():
    t = np.arange(600) / RATE
    y = np.remainder(np.stack([170 + 30 * np.sin(2 * np.pi * t / T)] * 3, -1) + 180, 360) - 180
    one = gait_curves(Signals((Signal.of("LFootProgressAngles", "angle", "deg", y, rate=RATE),)), STRIDES)[0]
    assert np.ptp(one.mean) < 65 and np.abs(np.diff(one.mean, axis=0)).max() < 5


def test_consistency_is_of_whole_strides_where_all_are_known():
    one = gait_curves(signals(noise=0.5), STRIDES)[0]
    values = one.values.copy()
    values[0, -3:], values[1, :60] = np.nan, np.nan  # the next step is on no plate; half a stride is missing
    held = one._replace(values=values)
    assert held.whole.tolist() == [True, False, True, True]
    whole = one._replace(values=one.values[[0, 2, 3], :98])
    np.testing.assert_allclose(held.consistency, whole.consistency)


def test_a_muscle_is_drawn_over_the_strides_of_its_side():
    rate = 1000.0
    t = np.arange(6000) / rate
    share = np.remainder((t - 0.68) / T, 1)
    raw = np.random.default_rng(0).normal(0, 1e-4, len(t)) * np.where(share < 0.3, 10, 1)
    (one,) = emg_curves({"EMG.R Soleus": emg(raw, rate=rate)}, STRIDES)
    assert (one.side, one.axes, one.unit) == ("right", ("envelope", "on"), "%")
    envelope, on = one.mean.T
    assert on[5:28].min() > 90 and on[40:90].mean() < 10
    assert envelope[10:25].mean() > 5 * envelope[45:90].mean()
    later = emg_curves({"R": emg(raw[500:], rate=rate, start=0.5)}, STRIDES[2:])[0]
    np.testing.assert_allclose(later.mean[:, 1], emg_curves({"R": emg(raw, rate=rate)}, STRIDES[2:])[0].mean[:, 1])


def test_a_hundred_per_cent_is_what_is_said():
    t = np.arange(6000) / 1000.0
    burst = np.random.default_rng(0).normal(0, 1, 6000) * (0.05 + (np.mod((t - 0.13) / T, 1) < 0.3))
    channels = {"L VAS": emg(burst, rate=1000.0)}
    peaks = dynamic_peaks([(channels, STRIDES)])
    (own,), (of_strides,), (of_mvc,) = (
        emg_curves(channels, STRIDES, whole=whole) for whole in (None, peaks, {"L VAS": 4 * peaks["L VAS"]})
    )
    tops = of_strides.values[..., 0].max(1)
    assert np.mean(tops) == pytest.approx(100, abs=2) and own.values[..., 0].max() <= 100 + 1e-9 < tops.max()
    np.testing.assert_allclose(of_mvc.values[..., 0], of_strides.values[..., 0] / 4)
    np.testing.assert_array_equal(of_mvc.values[..., 1], own.values[..., 1])


@pytest.mark.parametrize("off", [-0.9, -0.3, 0.3, 0.9])
def test_an_event_between_the_last_frame_and_the_next_ends_a_stride(off):
    """Plates have samples after the last frame, and before the first where analog begins earlier."""
    t = np.arange(600) / RATE
    knee = Signal.of("LKneeAngles", "angle", "deg", curve(t)[:, None] * np.ones(3), rate=RATE)
    spans = (off / RATE, 1.0) if off < 0 else (4.99, 5.99 + off / RATE)
    (one,) = gait_curves(Signals((knee,)), [Stride("left", *spans, {"foot_off": 60.0}, {})])
    np.testing.assert_allclose(one.mean[:, 0], curve(np.linspace(*spans, 101)), atol=2.0)
    (beyond,) = gait_curves(Signals((knee,)), [Stride("left", 4.99, 5.99 + 1.1 / RATE, {"foot_off": 60.0}, {})])
    assert np.isnan(beyond.values).all()


def test_a_control_with_a_gap_makes_no_step_in_the_band():
    whole = [
        {"LThoraxAngles": np.full((101, 3), float(k)), "RThoraxAngles": np.full((101, 3), float(k))} for k in (1, 2)
    ]
    half = np.full((101, 3), 30.0)
    half[50:] = np.nan
    one_side = {"LThoraxAngles": half, "RThoraxAngles": np.full((101, 3), 3.0)}
    found = reference_of([*whole, {"LThoraxAngles": half, "RThoraxAngles": half}, one_side], "")
    np.testing.assert_allclose(found.mean["ThoraxAngles"], 2.0)
    np.testing.assert_allclose(found.sd["ThoraxAngles"], 1.0)


def test_the_side_of_a_muscle_is_in_its_name():
    right = ("R Rect", "EMG_right_soleus", "Voltage.R Tib Ant", "Right.Gast", "RT SOL", "r_gast")
    left = ("L Rect", "Rectus left", "LT SOL", "l_gast")
    assert set(muscle_sides(right).values()) == {"right"}
    assert set(muscle_sides(left).values()) == {"left"}


def test_a_glued_letter_is_a_side_where_its_twin_is_there():
    sides = muscle_sides(["RTA", "LTA", "EMG.RGastroc", "EMG.LGastroc"])
    assert list(sides.values()) == ["right", "left", "right", "left"]
    assert list(muscle_sides(["TAL", "TAR", "EMG.SolL", "EMG.SolR"]).values()) == ["left", "right"] * 2
    assert set(muscle_sides(["RF", "LatGast", "EMG1", "Soleus", "GL", "GR", "BFL"]).values()) == {None}


def test_a_channel_without_bursts_has_no_time_that_it_is_on():
    noise = np.random.default_rng(0).normal(size=6000)
    (one,) = emg_curves({"L VAS": emg(noise, rate=1000.0)}, STRIDES)
    assert np.isnan(one.values[..., 1]).all()
    assert np.isfinite(one.values[..., 0]).all()
