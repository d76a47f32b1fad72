"""The component angle model: connectivity, learning, placing, feeding back, events."""

import numpy as np
import pytest

from kinemark.data import AngleModel, KinemarkError, same
from kinemark.fill import Gap, MarkerArray
from kinemark.fill.methods.angles import (
    KalmanAngles,
    LimbAngles,
    component_angles,
    connect,
    cycle_events,
    directions,
    fill_kalman_angles,
    fill_limb_angles,
    fit_model,
    intervals,
    model_events,
)
from kinemark.fill.methods.angles.limb_angles import _Filling
from kinemark.fill.methods.angles.place import taper
from kinemark.geometry.rigid_pairs import distances, rigid_groups
from kinemark.io.angle_model_csv import read_angle_model, write_angle_model
from kinemark.signal.phase import CyclePhase
from kinemark.synth import circle_over_cylinder, elbow_flexion

LINKS = (("B", "A"), ("C", "B"))


def arm(period=2.2, seed=0, duration=9.0, unsteady=2.0):
    subject = circle_over_cylinder(duration_s=duration, period_s=period, seed=seed, unsteady_mm=unsteady)
    return MarkerArray(subject.xyz, subject.rate, subject.names)


def leg(n=900, rate=100.0, cycle=110.0, phase=0.0, heading=0.0, noise=0.2, seed=0, share=0.03):
    """A bank of four on a thigh and one of four on a shank, walking; rigid but for noise."""
    rng = np.random.default_rng(seed)
    knots = np.arange(0, n + 600, 300)
    speed = (1 + share * np.interp(np.arange(n), knots, rng.normal(size=len(knots)))) / cycle
    turn = 2 * np.pi * (np.cumsum(speed) + phase)
    start = np.stack([20 * np.sin(turn), 12.0 * np.arange(n), 900 + 20 * np.cos(2 * turn)], -1)
    xyz = []
    for bend, length in ((0.4 * np.sin(turn), 400.0), (0.5 * np.sin(turn + 1) - 0.4 + 0.2 * np.sin(2 * turn), 380.0)):
        down = np.stack([0 * turn, np.sin(bend), -np.cos(bend)], -1)
        ahead = np.stack([0 * turn, np.cos(bend), np.sin(bend)], -1)
        side = np.array([1.0, 0, 0])
        for a, b, c in ((0.1, 40, 0), (0.9, 45, 10), (0.5, 10, 60), (0.4, -30, 20)):
            xyz.append(start + a * length * down + b * side + c * ahead)
        start = start + length * down
    c, s = np.cos(heading), np.sin(heading)
    xyz = np.array(xyz) @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])
    return MarkerArray(xyz + noise * rng.normal(size=xyz.shape), rate, tuple("abcdefgh"))


def errors(found, motion, gaps):
    return [
        np.linalg.norm(f.xyz - motion.xyz[g.marker, g.start : g.stop], axis=1) for f, g in zip(found, gaps, strict=True)
    ]


def test_angles_of_a_direction():
    np.testing.assert_allclose(component_angles(np.array([1.0, 0, 0])), [0, 90, 90])
    u = directions(np.array([[[0.0, 0, 0]], [[0, 3.0, 4.0]]]), np.array([[0, 1]]))
    np.testing.assert_allclose(u, [[[0, 0.6, 0.8]]])
    np.testing.assert_allclose((np.cos(np.radians(component_angles(u))) ** 2).sum(-1), 1)


def test_banks_and_joints_are_found_from_distances():
    motion = leg()
    share = distances(motion.xyz).share
    group = rigid_groups(share, most=0.02)
    assert len(set(group[:4])) == len(set(group[4:])) == 1 and group[0] != group[4]
    found = connect(motion.xyz, names=motion.names)
    assert (np.bincount(found.bank)[:2] == 6).all() and len(found.link) == 13
    order = np.random.default_rng(0).permutation(8)
    other = connect(motion.xyz[order], names=[motion.names[i] for i in order])
    sets = [
        {frozenset(names[i] for i in pair) for pair in f.link}
        for f, names in ((found, motion.names), (other, [motion.names[i] for i in order]))
    ]
    assert sets[0] == sets[1]


def test_links_and_banks_given():
    motion = leg()
    found = connect(motion.xyz, names=motion.names, links=[("b", "e")], banks=[("a", "b", "c")])
    assert found.link.tolist() == [[1, 4], [0, 1], [0, 2], [1, 2]] and found.bank.tolist() == [0, 1, 1, 1]
    with pytest.raises(ValueError, match="'z'"):
        connect(motion.xyz, names=motion.names, links=[("a", "z")])
    with pytest.raises(ValueError, match="two different markers"):
        connect(motion.xyz, names=motion.names, links=[("a", "a")])


def test_a_periodic_motion_is_reproduced():
    subject = elbow_flexion(duration_s=8, period_s=1.0)  # its directions repeat exactly
    motion = MarkerArray(subject.xyz, subject.rate, subject.names)
    fitted = fit_model(motion, method=LimbAngles(links=(("B", "D"), ("C", "B"))))
    assert fitted.model.period == pytest.approx(1.0, rel=2e-3)
    np.testing.assert_allclose(fitted.model.length, [45, 290], rtol=1e-9)
    u = directions(subject.xyz, fitted.model.links)
    at = np.stack(
        [
            np.interp(fitted.phase.cycles % 1 * 100, np.arange(101), np.append(d, d[0]))
            for d in fitted.model.direction[0].T
        ]
    )
    np.testing.assert_allclose(at.T, u[0], atol=5e-3)
    assert np.nanmax(fitted.model.deviation) < 1.0


@pytest.mark.parametrize("hidden", [(0,), (1,), (0, 1), (1, 2), (0, 2)])
def test_one_marker_places_all_that_hang_on_it(hidden):
    motion, model = arm(seed=3), fit_model(arm(seed=7), method=LimbAngles(links=LINKS)).model
    gaps = [Gap(m, 100, 160) for m in hidden]
    found = fill_limb_angles(motion.hidden(gaps), gaps, method=LimbAngles(model=model))
    for off in errors(found, motion, gaps):
        assert off.mean() < 5
    cold = fill_limb_angles(motion.hidden(gaps), gaps, method=LimbAngles(model=model, edge_samples=0))
    assert np.mean([off[0] for off in errors(cold, motion, gaps)]) > np.mean(
        [off[0] for off in errors(found, motion, gaps)]
    )


def test_the_model_of_the_trial_itself_uses_what_is_left_of_it():
    motion = arm(seed=3)
    gaps = [Gap(0, 20, 60), Gap(1, 120, 170)]
    found = fill_limb_angles(motion.hidden(gaps), gaps, method=LimbAngles(links=LINKS))
    assert max(off.mean() for off in errors(found, motion, gaps)) < 5


def test_a_bank_places_its_marker_as_a_rigid_body_would():
    motion = leg()
    gaps = [Gap(2, 300, 500)]
    found = fill_limb_angles(motion.hidden(gaps), gaps)
    assert errors(found, motion, gaps)[0].mean() < 0.8  # noise is 0.2 mm an axis
    both = [Gap(m, 300, 400) for m in (0, 1, 2, 3)]
    found = fill_limb_angles(motion.hidden(both), both)
    assert max(off.mean() for off in errors(found, motion, both)) < 12


def test_a_long_trial_is_filled_as_well_as_a_short_one():
    motion = leg(n=6000)
    gaps = [Gap(k % 8, 300 + 700 * k, 400 + 700 * k) for k in range(8)]
    found = fill_limb_angles(motion.hidden(gaps), gaps)
    off = np.concatenate(errors(found, motion, gaps))
    assert off.mean() < 0.8  # as in 900 frames, which are not thinned
    sd = np.concatenate([np.sqrt(np.trace(f.cov, axis1=1, axis2=2)) for f in found])
    assert np.sqrt((off**2).mean()) < np.sqrt((sd**2).mean()) < 3.0  # it does not claim too much


def test_intervals_of_the_model_hold():
    inside, n = 0, 0
    for seed in range(3):
        motion = arm(seed=seed, duration=20, unsteady=4.0)
        gaps = [Gap(k % 3, 60 + 80 * k, 60 + 80 * k + 30) for k in range(6)]
        for f, g in zip(fill_limb_angles(motion.hidden(gaps), gaps, method=LimbAngles(links=LINKS)), gaps, strict=True):
            off = f.xyz - motion.xyz[g.marker, g.start : g.stop]
            inside += (np.einsum("li,lij,lj->l", off, np.linalg.inv(f.cov), off) < 7.81).sum()
            n += len(off)
    assert 0.85 < inside / n <= 1.0


@pytest.mark.parametrize("heading", [0.0, 1.0, np.pi])
def test_another_trials_model_fits_from_any_phase_heading_and_cadence(heading):
    model = fit_model(leg(phase=0.1, seed=1)).model
    motion = leg(n=500, cycle=95, phase=0.63, heading=heading, seed=2)
    fitted = fit_model(motion, method=LimbAngles(model=model))
    assert 1 / np.diff(fitted.phase.cycles).mean() == pytest.approx(95, rel=0.05)
    gaps = [Gap(6, 200, 300), Gap(1, 50, 150)]
    found = fill_limb_angles(motion.hidden(gaps), gaps, method=LimbAngles(model=model))
    assert max(off.mean() for off in errors(found, motion, gaps)) < 2


def test_another_motion_is_refused():
    model = fit_model(arm(), method=LimbAngles(links=LINKS)).model
    rng = np.random.default_rng(0)
    other = MarkerArray(rng.normal(size=(3, 300, 3)).cumsum(1) * 30, 30.0, ("A", "B", "C"))
    found = fill_limb_angles(other.hidden([Gap(0, 100, 110)]), [Gap(0, 100, 110)], method=LimbAngles(model=model))
    assert "not that of the model" in found[0].reason
    strangers = fill_limb_angles(leg(), [Gap(0, 5, 9)], method=LimbAngles(model=model))
    assert "Check the names" in strangers[0].reason


def test_a_model_goes_through_a_file(tmp_path):
    model = fit_model(leg(), method=LimbAngles()).model
    write_angle_model(tmp_path / "leg.csv", model)
    back = read_angle_model(tmp_path / "leg.csv")
    pairs = [[tuple(m.names[i] for i in pair) for pair in m.links] for m in (model, back)]
    assert pairs[0] == pairs[1]
    assert back.period == model.period and (back.cycles == model.cycles).all() and (back.bank == model.bank).all()
    np.testing.assert_allclose(back.direction, model.direction, atol=1e-9)
    np.testing.assert_allclose(back.cov, model.cov, atol=1e-12)
    write_angle_model(tmp_path / "again.csv", back)
    np.testing.assert_allclose(read_angle_model(tmp_path / "again.csv").angles, back.angles, atol=1e-6)
    motion, gaps = leg(seed=4), [Gap(2, 300, 400)]
    one, other = (fill_limb_angles(motion.hidden(gaps), gaps, method=LimbAngles(model=m)) for m in (model, back))
    np.testing.assert_allclose(one[0].xyz, other[0].xyz, atol=1e-4)


def test_broken_model_files_are_named(tmp_path):
    path = tmp_path / "m.csv"
    write_angle_model(path, fit_model(arm(), method=LimbAngles(links=LINKS)).model)
    text = path.read_text()
    for old, new, what in (
        ("kinemark angle model", "angles", "no angle model"),
        ("segment,percent", "percent,segment", "holds no angles"),
        ("\n1,99.0,", "\n2,99.0,", "same number of rows"),
        ("\n1,99.0,", "\n1,99.0,x", "is no number"),
        ("period_s,", "period_s,-", "period"),
    ):
        path.write_text(text.replace(old, new))
        with pytest.raises(KinemarkError, match=what):
            read_angle_model(path)
    lines = text.split("\n")
    k = next(i for i, line in enumerate(lines) if line.startswith("1,0.0,"))
    lines[k] = "1,0.0,10,10,10,3,0,0,0,0,0,0"
    path.write_text("\n".join(lines))
    with pytest.raises(KinemarkError, match=rf"line {k + 1}: these three angles"):
        read_angle_model(path)


def test_turned_about_the_vertical_and_back():
    model = fit_model(arm(), method=LimbAngles(links=LINKS)).model
    quarter = model.turned(90.0)
    np.testing.assert_allclose(quarter.direction[..., 1], model.direction[..., 0], atol=1e-12)
    np.testing.assert_allclose(quarter.turned(-90.0).cov, model.cov, atol=1e-12)
    assert same(model, model)
    with pytest.raises(ValueError, match="unit vectors"):
        AngleModel(
            model.names,
            model.links,
            model.bank,
            model.length,
            model.spread,
            2 * model.direction,
            model.cov,
            model.cycles,
            1.0,
        )


def test_feedback_of_positions_oscillates_and_measured_places_do_not():
    motion, model = arm(seed=3), fit_model(arm(seed=7), method=LimbAngles(links=LINKS)).model
    gaps = [Gap(0, 30, 90), Gap(2, 120, 180)]
    rough, off = {}, {}
    for feedback in ("position", "path", "measured", "none"):
        method = KalmanAngles(
            feedback, measurement_sd=2.54, jerk=10_000.0, limbs=LimbAngles(model=model, rotate_model=False)
        )
        found = fill_kalman_angles(motion.hidden(gaps), gaps, method=method)
        wrong = [f.xyz - motion.xyz[g.marker, g.start : g.stop] for f, g in zip(found, gaps, strict=True)]
        rough[feedback] = np.sqrt(np.mean([np.diff(w, 2, axis=0) ** 2 for w in wrong]))
        off[feedback] = np.mean([np.linalg.norm(w, axis=1).mean() for w in wrong])
    assert rough["measured"] < rough["position"] / 8
    assert off["measured"] < off["position"] < 20
    assert off["none"] < 20
    stiff = KalmanAngles(
        "none",
        segment_tolerance=0.05,
        measurement_sd=2.54,
        jerk=10_000.0,
        limbs=LimbAngles(model=model, rotate_model=False),
    )
    hand = fill_kalman_angles(motion.hidden(gaps), gaps, method=stiff)[0].xyz
    assert np.abs(np.linalg.norm(hand - motion.xyz[1, 30:90], axis=1) / 260 - 1).max() < 0.051
    wide = KalmanAngles(
        phase_tolerance=0.49, measurement_sd=2.54, jerk=10_000.0, limbs=LimbAngles(model=model, rotate_model=False)
    )
    alone = fill_kalman_angles(motion.hidden(gaps), gaps, method=wide)
    assert np.mean([o.mean() for o in errors(alone, motion, gaps)]) > 2 * off["position"]


def test_events_come_where_the_cycle_has_them():
    motion = leg(noise=0.0, share=0.1)
    fitted = fit_model(motion)
    percents = model_events(fitted.model)
    label = next(name for name in percents if name.endswith("y greatest"))
    pair = label.split(" ")[0].split("-")
    u = directions(motion.xyz, np.array([[motion.names.index(name) for name in pair]]))[0]
    events = cycle_events(fitted.phase, {label: percents[label]}, rate=motion.rate)
    angle = component_angles(u)[:, 1]
    for time in events.time[1:-1]:
        near = np.arange(int(time * 100) - 30, int(time * 100) + 31)
        near = near[(near >= 0) & (near < len(angle))]
        assert abs(near[angle[near].argmax()] / 100 - time) < 0.03
    lengths = intervals(events, label, label)
    np.testing.assert_allclose(lengths, np.diff(events.time))
    both = cycle_events(CyclePhase(np.arange(300) / 100, 0.0), {"on": 10.0, "off": 70.0}, rate=100.0)
    np.testing.assert_allclose(intervals(both, "on", "off"), 0.6)
    np.testing.assert_allclose(intervals(both, "off", "on"), 0.4)


@pytest.mark.parametrize(("fill", "method"), [(fill_limb_angles, LimbAngles()), (fill_kalman_angles, KalmanAngles())])
def test_degenerate_input_has_reasons(fill, method):
    gap = [Gap(0, 2, 4)]
    shapes = {
        "one marker": np.random.default_rng(0).normal(size=(1, 50, 3)),
        "one frame": np.zeros((3, 1, 3)),
        "nothing seen": np.full((3, 50, 3), np.nan),
        "constant": np.ones((3, 200, 3)) * np.arange(3)[:, None, None] * 100,
        "noise": np.random.default_rng(1).normal(size=(4, 200, 3)) + 500 * np.arange(4)[:, None, None],
        "far": np.random.default_rng(2).choice([-1e9, 1e9], (3, 100, 3)),
    }
    for what, xyz in shapes.items():
        own = [Gap(0, 0, 1)] if what == "one frame" else gap
        found = fill(MarkerArray(xyz, 100.0, tuple("abcd"[: len(xyz)])).hidden(own), own, method=method)
        assert found[0].reason and np.isnan(found[0].xyz).all(), what
    assert fill(arm(), [], method=method) == []


def test_wrong_parameters_are_named():
    with pytest.raises(ValueError, match="feedback is 'x', wanted position"):
        KalmanAngles("x")
    with pytest.raises(ValueError, match=r"phase_tolerance is 0\.7"):
        KalmanAngles(phase_tolerance=0.7)
    with pytest.raises(ValueError, match="shortest_period is 3 "):
        LimbAngles(shortest_period=3, longest_period=1)
    with pytest.raises(ValueError, match="edge_samples is -1"):
        LimbAngles(edge_samples=-1)


def test_weights_fall_towards_what_is_missing_and_the_ends():
    there = np.ones((2, 60), bool)
    there[0, 20:24] = False
    w = taper(there, 8.0)
    for row, seen in zip(w, there, strict=True):
        away = [-1, 60, *np.flatnonzero(~seen)]
        near = np.array([min(abs(f - k) for k in away) for f in range(60)])
        np.testing.assert_allclose(row, np.minimum(near / 8, 1))


def test_neighbours_at_once_carry_errors_as_each_by_itself():
    """Though near the gap other frames are missing of each."""
    whole = leg()
    gap = Gap(0, 400, 440)
    motion = whole.hidden([gap, Gap(1, 396, 399), Gap(2, 441, 470), Gap(3, 370, 400)])
    filling = _Filling(motion, [gap], fit_model(motion), LimbAngles())
    near, frames = filling._placings(0), np.arange(gap.start, gap.stop)
    every = np.arange(len(near.source))
    mean, share = filling._carried(near, every, frames)
    known = ~np.isnan(near.errors.r[..., 0])
    assert len(every) >= 3 and len(np.unique(known, axis=0)) >= 3
    for k in every:
        alone, alone_share = filling._carried(near, every[k : k + 1], frames)
        np.testing.assert_allclose(mean[k], alone[0], rtol=1e-9, atol=1e-9)
        np.testing.assert_allclose(share[k], alone_share[0], rtol=1e-9, atol=1e-9)
