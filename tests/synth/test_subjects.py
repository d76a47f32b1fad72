"""Moving subjects: rigid where they must be, on the floor, in the volume, on the skin, and true to their angles."""

import numpy as np
import pytest

from kinemark.data import MarkerTrajectory, Trajectories, same
from kinemark.synth import (
    VOLUME,
    arm,
    circle_over_cylinder,
    elbow_flexion,
    from_trajectories,
    ring,
    thrown_ball,
    tilted_rectangle,
    truth,
    walking,
    wand,
)
from kinemark.synth.arm import RANGES
from kinemark.synth.gait import ANKLE, HIP, KNEE, curve
from kinemark.synth.occlusion import line_distance

RIGID = [
    ("SACR", "LASI", "RASI"),
    *((side + a, side + b, side + c) for side in "LR" for a, b, c in (("THI", "KNE", "KNE"), ("ANK", "HEE", "TOE"))),
    *((side + a, side + b, side + c) for side in "LR" for a, b, c in (("KNE", "TIB", "ANK"),)),
]


def spans(subject, names):
    points = np.array([subject[name] for name in names])
    return np.linalg.norm(points[:, None] - points[None], axis=-1)


def clearance(subject):
    """(M, L, F) mm between every marker's surface and every limb's."""
    limbs = subject.capsules
    gap = line_distance(subject.xyz[:, None], np.zeros(3), limbs.a, limbs.b)
    return gap - limbs.radius[:, None] - subject.radius_mm[:, None, None]


def test_walker_keeps_segment_lengths():
    subject = walking(duration_s=2.0)
    for names in RIGID:
        assert np.ptp(spans(subject, names), axis=-1).max() < 1e-9, names


def test_walker_has_fifteen_markers_above_the_floor_and_in_the_volume():
    subject = walking()
    assert len(subject) == 15 and subject.n_frames == 80
    bottom = subject.xyz - subject.radius_mm[:, None, None]
    assert (bottom[..., 2] > 0).all()
    assert (bottom > VOLUME[0]).all() and (subject.xyz + 12.5 < VOLUME[1]).all()


def test_six_cameras_see_every_marker_of_the_walker_thrice():
    assert ((truth(ring(6), walking()).visible >= 0.5).sum(0) >= 3).all()


@pytest.mark.parametrize("speed", [700.0, 1100.0, 1500.0])
def test_walker_goes_at_the_asked_speed(speed):
    subject = walking(duration_s=8.0, speed_mm_s=speed)
    advance = np.polyfit(np.arange(subject.n_frames) / subject.rate, subject["SACR"][:, 0], 1)[0]
    assert advance == pytest.approx(speed, rel=0.005)


def test_pelvis_stays_in_the_volume_for_two_seconds():
    subject = walking(duration_s=2.0)
    for name in ("SACR", "LASI", "RASI"):
        assert (subject[name] > VOLUME[0]).all() and (subject[name] < VOLUME[1] + [20, 0, 0]).all()


def test_limbs_reach_from_the_floor_to_the_head_of_a_person():
    limbs = walking(duration_s=0.1).capsules
    low = np.minimum(limbs.a, limbs.b)[..., 2] - limbs.radius[:, None]
    high = np.maximum(limbs.a, limbs.b)[..., 2] + limbs.radius[:, None]
    assert -10 < low.min() < 10 and high.max() == pytest.approx(1730, abs=40)
    trunk = [k for k, name in enumerate(limbs.names) if "trunk" in name]
    assert (np.linalg.norm(limbs.a - limbs.b, axis=-1)[trunk] > 200).all()


def test_a_standing_foot_neither_slides_nor_lifts_much():
    subject = walking(duration_s=3.0, rate=200.0)
    strike = subject.events.time[[e == ("Foot Strike", "Left") for e in zip(*labels(subject), strict=True)]]
    for t in strike[:-1]:
        flat = slice(round((t + 0.13) * 200), round((t + 0.38) * 200))
        for name in ("LHEE", "LTOE"):
            assert (np.ptp(subject[name][flat], axis=0) < [12, 8, 15]).all(), name


def labels(subject):
    return subject.events.label, subject.events.side


def test_foot_strike_is_heel_first_and_foot_off_is_where_the_toe_leaves():
    subject = walking(duration_s=4.0, rate=200.0)
    for time, label, side in zip(subject.events.time, *labels(subject), strict=True):
        i = round(time * 200)
        heel, toe = subject[f"{side[0]}HEE"], subject[f"{side[0]}TOE"]
        if label == "Foot Strike" and 80 < i < 720:
            assert heel[i, 2] < heel[:, 2].min() + 15 and toe[i, 2] > toe[:, 2].min() + 40  # heel first
            assert heel[i + 10, 0] - heel[i, 0] < 15 < 0.1 * (heel[i, 0] - heel[i - 40, 0])  # it comes to rest
        if label == "Foot Off" and 80 < i < 720:
            assert toe[i + 20, 0] - toe[i, 0] > 4 * abs(toe[i - 5, 0] - toe[i - 25, 0])  # it leaves


def test_left_and_right_mirror_each_other_half_a_stride_later():
    subject = walking(duration_s=6.0, rate=1000.0)
    strikes = subject.events.time[[label == "Foot Strike" for label in subject.events.label]]
    half = np.diff(strikes).mean()
    i, j = 500, 500 + round(half * 1000)
    for name in ("THI", "KNE", "TIB", "ANK", "HEE", "TOE"):
        left = subject["L" + name][i] - subject["SACR"][i]
        right = subject["R" + name][j] - subject["SACR"][j]
        assert np.allclose(left, right * [1, -1, 1], atol=2.0)


def test_knee_angle_of_the_record_is_that_of_the_markers():
    subject = walking(duration_s=1.0)
    flexion = subject.angles.deg[subject.angles.joints.index("left knee"), :, 0]
    # The wands stand square to the hinge, so the chord from thigh wand to shank wand grows shorter as the knee bends.
    chord = np.linalg.norm(subject["LTHI"] - subject["LTIB"], axis=-1)
    order = np.argsort(flexion)
    assert (np.diff(chord[order]) < 1e-9).all()
    assert 50 < flexion.max() < 70


def test_curves_pass_through_their_samples():
    turns = np.arange(20) / 20
    for samples in (HIP, KNEE, ANKLE):
        assert np.abs(curve(samples, turns) - samples).max() < 1.0  # the sine of the last harmonic is unknown
        assert np.allclose(curve(samples, turns + 3), curve(samples, turns))


@pytest.mark.parametrize(
    "subject", [walking(duration_s=1.2), arm("feeding"), arm("drinking")], ids=["gait", "eat", "drink"]
)
def test_markers_sit_outside_all_limbs(subject):
    assert clearance(subject).min() > 0


def test_proportions_scale_with_height():
    tall, small = walking(height_mm=1900.0), walking(height_mm=950.0, marker_radius_mm=6.25)
    assert spans(tall, ("LKNE", "LANK"))[0, 1].mean() == pytest.approx(
        2 * spans(small, ("LKNE", "LANK"))[0, 1].mean(), rel=0.01
    )


def test_wobble_has_its_size_and_its_seed():
    still, soft = walking(duration_s=20.0), walking(duration_s=20.0, wobble_mm=3.0, seed=4)
    off = soft.xyz - still.xyz
    assert np.sqrt((off**2).mean()) == pytest.approx(3.0, rel=0.15)
    assert same(soft.xyz, walking(duration_s=20.0, wobble_mm=3.0, seed=4).xyz)
    assert not same(soft.xyz, walking(duration_s=20.0, wobble_mm=3.0, seed=5).xyz)
    jumps = np.abs(np.diff(off, axis=1)).max()
    assert jumps < 3.0 * 4 * 2 * np.pi * 6 / 50  # nothing faster than 6 Hz


def axes_of_markers(xyz):
    """The axes of UM²AS A.9–A.20 as rows (F, 3, 3): shoulder, arm, forearm, hand."""
    m1, m2, m3, m4, m5, m6, m7 = xyz
    M = (m5 + m6) / 2
    pairs = [
        (m1 - m2, np.cross(m1 - m2, m3 - m2), None),
        (m3 - m4, None, np.cross(M - m4, m3 - m4)),
        (m4 - M, np.cross(m6 - m4, m5 - m4), None),
        (M - m7, np.cross(m5 - m7, m6 - m7), None),
    ]
    found = []
    for y, x, z in pairs:
        y = y / np.linalg.norm(y, axis=-1, keepdims=True)
        x = np.cross(y, z) if x is None else x
        x = x / np.linalg.norm(x, axis=-1, keepdims=True)
        found.append(np.stack([x, y, np.cross(x, y)], 1))
    return found


@pytest.mark.parametrize("task", ["feeding", "drinking"])
def test_arm_angles_return_from_the_axes_of_its_markers(task):
    subject = arm(task, seed=3)
    axes = axes_of_markers(subject.xyz)
    for j in range(3):
        R = axes[j + 1] @ axes[j].transpose(0, 2, 1)
        theta = np.degrees(np.arcsin(np.clip(R[:, 1, 2], -1, 1)))  # (A.29)
        phi = np.degrees(np.arctan2(-R[:, 1, 0], R[:, 1, 1]))
        psi = np.degrees(np.arctan2(-R[:, 0, 2], R[:, 2, 2]))
        assert np.allclose(np.stack([phi, theta, psi], -1), subject.angles.deg[j], atol=1e-8)


@pytest.mark.parametrize("task", ["feeding", "drinking"])
def test_arm_stays_in_its_ranges_and_its_segments_rigid(task):
    subject = arm(task, duration_s=12.0, unsteady_deg=2.0)
    for joint, deg in zip(subject.angles.joints, subject.angles.deg, strict=True):
        low, high = np.array(RANGES[joint]).T
        assert (deg >= low).all() and (deg <= high).all()
    assert np.ptp(subject.angles.deg[1, :, 0]) > 25  # the elbow works
    for names in (("ACR1", "ACR2", "ARM3"), ("ARM3", "ELB4"), ("ELB4", "WRU5", "WRR6"), ("WRU5", "WRR6")):
        assert np.ptp(spans(subject, names), axis=-1).max() < 1e-9
    assert (subject.xyz > 0).all() and (subject.xyz < 1000).all()


def test_hand_comes_to_the_mouth_and_goes_back():
    subject = arm("drinking", unsteady_deg=0.0, sway_mm=0.0)
    head = (subject.capsules.a + subject.capsules.b)[subject.capsules.names.index("head")] / 2
    away = np.linalg.norm(subject["MC37"] - head, axis=-1)
    assert away.min() < 280 and away.max() > 450


@pytest.mark.parametrize("motion", [circle_over_cylinder, tilted_rectangle, elbow_flexion])
def test_recorded_motions_are_rigid_and_within_three_feet(motion):
    subject = motion(seed=2)
    assert subject.rate == 30.0 and len(subject) == 3
    assert np.linalg.norm(subject.xyz, axis=-1).max() < 914
    assert subject.marker_set.spread.max() < 1e-9
    assert same(subject.xyz, motion(seed=2).xyz) and not same(subject.xyz, motion(seed=3).xyz)


def test_circle_moves_level_and_rectangle_stands_at_45_degrees():
    circle = np.ptp(circle_over_cylinder()["A"], axis=0)
    assert circle[0] > 220 and circle[1] > 220 and circle[2] < 50
    x, y, z = (tilted_rectangle(unsteady_mm=0.0)["A"] - [290, -130, 180]).T
    assert np.allclose(x, y) and np.ptp(z) > 150
    corner = np.hypot(np.hypot(x, y) / 130, z / 90).max()
    assert 1.0 < corner < np.sqrt(2) - 0.05  # round


def test_third_run_brings_two_markers_close():
    subject = elbow_flexion()
    assert subject.names == ("D", "B", "C")
    assert np.linalg.norm(subject["D"] - subject["B"], axis=-1).max() < 50


def test_wand_is_rigid_in_the_volume_and_goes_all_over():
    subject = wand((0.0, 200.0, 502.5), duration_s=30.0, seed=1)
    first, middle, last = subject.xyz
    assert np.allclose(np.linalg.norm(last - first, axis=-1), 502.5)
    assert np.allclose(middle, first + (last - first) * 200 / 502.5)
    assert (subject.xyz > VOLUME[0]).all() and (subject.xyz < VOLUME[1]).all()
    assert (np.ptp(first, axis=0) > 0.6 * VOLUME[1]).all()
    speed = np.linalg.norm(np.diff(subject.xyz, axis=1), axis=-1) * subject.rate
    assert speed.max() < 5000
    direction = (last - first) / 502.5
    assert (np.ptp(direction, axis=0) > 1.2).all()
    with pytest.raises(ValueError, match="cannot turn"):
        wand((0.0, 1500.0))


def test_thrown_ball_falls_as_it_should():
    path = thrown_ball()["ball"]
    assert np.allclose(np.diff(path, 2, axis=0) * 50**2, [0, 0, -9806.65])


def test_gaps_of_a_recording_are_markers_that_are_not_there():
    xyz = np.arange(12.0).reshape(4, 3)
    xyz[2] = np.nan
    paths = Trajectories((MarkerTrajectory.measured("a", xyz), MarkerTrajectory.measured("b", xyz[::-1])), 100.0)
    subject = from_trajectories(paths)
    assert same(subject.trajectories, paths)
    assert np.isnan(subject["a"][2]).all() and len(subject.capsules) == 0


def test_mistakes_are_named():
    with pytest.raises(ValueError, match="speed_mm_s"):
        walking(speed_mm_s=0)
    with pytest.raises(ValueError, match="feeding"):
        arm("knitting")
    with pytest.raises(KeyError, match="no marker"):
        walking(duration_s=0.1)["NOSE"]
