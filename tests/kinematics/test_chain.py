"""Chains of segments: angles come back as they went in, whatever the sequence; their SD is what simulation finds."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from kinemark.data import KinemarkError, MarkerTrajectory, Trajectories
from kinemark.io.model_toml import load_model, model_from_toml
from kinemark.kinematics import (
    InverseCosines,
    Joint,
    SignedAngles,
    angular_velocity,
    inverse_cosines,
    joint_angles,
    joint_matrices,
    named_angles,
    outside,
    principal,
    turned,
    with_marker_sd,
)
from kinemark.kinematics.chain import chosen, complete, points_of
from kinemark.kinematics.sequences import followed, read_angles
from kinemark.synth.arm import RANGES, ArmDimensions, arm, skeleton
from support.examples import examples

SEQUENCES = [a + b + c for a in "xyz" for b in "xyz" for c in "xyz" if b not in (a, c)]
UM2AS = load_model("um2as")
NAMES = ("ACR1", "ACR2", "ARM3", "ELB4", "WRU5", "WRR6", "MC37")


def trial_of(xyz, rate=50.0, names=NAMES):
    return Trajectories(tuple(MarkerTrajectory.measured(n, x) for n, x in zip(names, xyz, strict=True)), rate)


def limb(deg):
    """The seven markers of joint angles (3, F, 3) deg."""
    return trial_of(skeleton(np.asarray(deg, float), np.zeros((len(deg[0]), 3)), ArmDimensions(), 17.0)[0])


def posed(*, phi1=0.0, theta1=0.0, psi1=0.0, phi2=60.0, psi2=0.0, phi3=0.0, theta3=0.0):
    parts = np.broadcast_arrays(phi1, theta1, psi1, phi2, 0.0, psi2, phi3, theta3, 0.0)
    return limb(np.array([np.atleast_1d(p) for p in parts], float).reshape(3, 3, -1).transpose(0, 2, 1))


@pytest.mark.parametrize("sequence", SEQUENCES)
def test_a_rotation_is_taken_apart_and_put_together_again(sequence):
    R = Rotation.random(200, random_state=1).as_matrix()
    deg = principal(R, sequence)
    assert np.abs(turned(deg, sequence) - R).max() < 1e-9
    assert (
        np.abs(turned(deg, sequence) - Rotation.from_euler(sequence.upper(), deg, degrees=True).as_matrix()).max()
        < 1e-9
    )
    middle = deg[:, 1]
    if sequence[0] == sequence[2]:
        assert (middle >= 0).all() and (middle <= 180).all()
        other = principal(R, sequence, negative_middle=True)
        assert (other[:, 1] <= 0).all() and np.abs(turned(other, sequence) - R).max() < 1e-9
    else:
        assert (np.abs(middle) <= 90).all()


def test_all_twelve_sequences_are_there():
    assert len(SEQUENCES) == 12


@pytest.mark.parametrize("task", ["feeding", "drinking"])
def test_the_upper_limb_gives_the_angles_that_made_it(task):
    subject = arm(task, duration_s=4, seed=3, unsteady_deg=3.0)
    found = joint_angles(trial_of(subject.xyz), model=UM2AS)
    assert found.joints == ("shoulder", "elbow", "wrist") and set(found.sequence) == {"zxy"}
    assert np.abs(found.deg - subject.angles.deg).max() < 1e-9
    assert not found.locked.any() and np.isnan(found.cov[0]).all()


@settings(max_examples=examples(40))
@given(st.lists(st.floats(-80, 80), min_size=7, max_size=7))
def test_seven_free_angles_come_back_with_their_signs(v):
    trial = posed(
        phi1=v[0], theta1=v[1], psi1=v[2], phi2=65 + v[3] * 0.8, psi2=v[4], phi3=v[5] * 0.8, theta3=v[6] * 0.8
    )
    deg = joint_angles(trial, model=UM2AS).deg[:, 0]
    want = [[v[0], v[1], v[2]], [65 + v[3] * 0.8, 0, v[4]], [v[5] * 0.8, v[6] * 0.8, 0]]
    assert np.abs(deg - want).max() < 1e-6


def test_angles_do_not_depend_on_where_the_laboratory_is():
    xyz = arm(duration_s=1, seed=5).xyz
    moved = xyz @ Rotation.random(random_state=2).as_matrix().T + [100, -2000, 30]
    a, b = (joint_angles(trial_of(x), model=UM2AS).deg for x in (xyz, moved))
    assert np.abs(a - b).max() < 1e-9


def test_a_left_limb_is_a_right_one_in_the_mirror():
    xyz = arm(duration_s=1, seed=6).xyz
    right = joint_angles(trial_of(xyz), model=UM2AS).deg
    left = joint_angles(trial_of(xyz * [1, -1, 1]), model=load_model("um2as", side="left")).deg
    assert np.abs(right - left).max() < 1e-9


def test_inverse_cosines_lose_the_sign_and_nothing_else():
    trial = posed(phi1=np.linspace(-50, 50, 21), psi1=-30.0, theta1=20.0, psi2=np.linspace(40, -40, 21), phi3=-12.0)
    signed = joint_angles(trial, model=UM2AS).deg
    thesis = joint_angles(trial, model=UM2AS, method=InverseCosines()).deg
    assert np.abs(thesis[..., [0, 2]] - np.abs(signed[..., [0, 2]])).max() < 1e-5
    assert np.abs(thesis[..., 1] - signed[..., 1]).max() < 1e-9
    assert (signed[1, :, 2] < -1).any() and (thesis[..., [0, 2]] >= 0).all()  # supination reads as pronation


def test_inverse_cosines_are_the_equations_of_the_thesis():
    trial = posed(phi1=25.0, theta1=-35.0, psi1=15.0, phi2=80.0, psi2=50.0, phi3=10.0, theta3=8.0)
    r = joint_matrices(points_of(trial), UM2AS)[:, 0].transpose(0, 2, 1)  # UM²AS has axes as rows
    theta = np.arcsin(r[:, 1, 2])  # A.29, A.32, A.34
    phi, psi = np.arccos(r[:, 1, 1] / np.cos(theta)), np.arccos(r[:, 2, 2] / np.cos(theta))  # A.30 … A.36
    found = joint_angles(trial, model=UM2AS, method=InverseCosines()).deg[:, 0]
    assert np.allclose(found, np.degrees([phi, theta, psi]).T, atol=1e-5)


def test_inverse_cosines_refuse_sequences_that_end_where_they_began():
    with pytest.raises(ValueError, match="three different axes"):
        inverse_cosines(np.eye(3), "yxy")


@pytest.mark.parametrize("sequence", ["zxy", "yxy", "xyz", "zyz"])
def test_gimbal_lock_is_flagged_near_and_only_near(sequence):
    lock = 90.0 if sequence[0] != sequence[2] else 0.0
    middle = lock + np.array([-30, -11, -9, -1, 0, 1, 9, 11, 30.0])
    deg = np.stack([np.full(9, 20.0), middle, np.full(9, -40.0)], -1)
    found, locked = read_angles(turned(deg, sequence), Joint("j", "a", "b", sequence), SignedAngles(lock_deg=10))
    assert locked.tolist() == [False, False, True, True, True, True, True, False, False]
    assert np.isnan(found[4, [0, 2]]).all() and abs(found[4, 1] - lock) < 1e-6
    assert (
        np.abs(
            turned(found[locked & (middle != lock)], sequence) - turned(deg[locked & (middle != lock)], sequence)
        ).max()
        < 1e-6
    )


def test_curves_do_not_jump_where_principal_values_do():
    t = np.linspace(0, 1, 200)[:, None]
    deg = np.hstack([40 + 500 * t, 30 * np.sin(9 * t), -20 - 400 * t])
    R, joint = turned(deg, "zxy"), Joint("j", "a", "b", "zxy")
    assert np.abs(read_angles(R, joint, SignedAngles())[0] - deg).max() < 1e-9
    jumping = read_angles(R, joint, SignedAngles(continuous=False))[0]
    assert np.abs(jumping).max() <= 180 and np.abs(np.diff(jumping, axis=0)).max() > 300


def test_curves_go_on_after_a_gap_and_through_the_other_triple():
    t = np.linspace(0, 1, 300)[:, None]
    deg = np.hstack([10 + 20 * t, 20 + 140 * t, 30 - 50 * t])  # the middle angle passes 90°
    R = turned(deg, "zxy")
    R[100:130] = np.nan
    found, locked = read_angles(R, Joint("j", "a", "b", "zxy"), SignedAngles())
    known = np.isfinite(found).all(1) & ~locked
    assert np.abs(found[known] - deg[known]).max() < 1e-6 and np.isnan(found[100:130]).all()


def noisy(points, sd, n, seed=0):
    rng = np.random.default_rng(seed)
    return {name: x + sd * rng.normal(size=(n, *x.shape)) for name, x in points.items()}


@pytest.mark.parametrize("method", [SignedAngles(), InverseCosines()])
def test_the_standard_deviation_is_what_simulation_finds(method):
    trial = with_marker_sd(trial_of(arm(duration_s=3, seed=1).xyz[:, ::15]), 1.0)
    found = joint_angles(trial, model=UM2AS, method=method)
    R = joint_matrices(noisy(points_of(trial), 1.0, 4000), UM2AS)
    deg = np.moveaxis(principal(R, "zxy"), 1, 0)
    spread = deg.std(0)
    free = np.array([[1, 1, 1], [1, 0, 1], [1, 1, 0]], bool)[:, None] & np.ones(spread.shape, bool)
    ratio = (found.sd / np.where(free, spread, 1))[free]
    assert abs(ratio.mean() - 1) < 0.02 and ratio.min() > 0.9 and ratio.max() < 1.1
    j = 0  # and how the errors of a joint's angles go together
    want = np.cov(deg[:, j, 0].T)
    sign = np.sign(principal(joint_matrices(points_of(trial), UM2AS)[j, 0], "zxy")) ** (method != SignedAngles())
    sign[1] = 1
    assert np.abs(found.cov[j, 0] - sign[:, None] * want * sign).max() < 0.1 * np.abs(want).max()


def test_the_covariance_follows_the_other_triple():
    """Abduction beyond 90° is read as the other triple, whose middle angle errs the other way."""
    theta = np.linspace(-40, -130, 91)
    trial = with_marker_sd(posed(theta1=theta, phi1=20.0, psi1=10.0), 1.0)
    found = joint_angles(trial, model=UM2AS)
    assert np.abs(found["shoulder"][:, 1] - theta).max() < 1e-6
    last = {name: x[-1:] for name, x in points_of(trial).items()}
    deg = principal(joint_matrices(noisy(last, 1.0, 6000), UM2AS)[0, :, 0], "zxy")
    deg = np.array([180, 180, 180]) + deg * [1, -1, 1]
    deg -= 360 * np.round((deg - found["shoulder"][-1]) / 360)
    assert np.abs(deg.mean(0) - found["shoulder"][-1]).max() < 0.2
    want = np.cov(deg.T)
    assert np.abs(found.cov[0, -1] - want).max() < 0.08 * np.abs(want).max()


def test_the_covariance_of_each_marker_counts_with_its_direction():
    trial = posed(phi2=90.0)
    along = {name: np.zeros((1, 3, 3)) for name in NAMES}
    forearm = trial["ELB4"].xyz[0] - (trial["WRU5"].xyz[0] + trial["WRR6"].xyz[0]) / 2
    u = forearm / np.linalg.norm(forearm)
    along["WRU5"] = along["WRR6"] = np.outer(u, u)[None]
    stated = replace(trial, paths=tuple(replace(p, cov=along[p.name]) for p in trial))
    assert joint_angles(stated, model=UM2AS).sd[1, 0, 0] < 1e-3  # along the forearm nothing of flexion is lost
    across = np.eye(3)[None] - along["WRU5"]
    stated = replace(trial, paths=tuple(replace(p, cov=across if p.name[:2] == "WR" else 0 * across) for p in trial))
    want = np.degrees(np.sqrt(0.5) / np.linalg.norm(forearm))  # of the mean of two markers, seen from the elbow
    assert abs(joint_angles(stated, model=UM2AS).sd[1, 0, 0] / want - 1) < 0.05


def test_an_unknown_covariance_spoils_only_the_joints_that_see_it():
    trial = with_marker_sd(posed(), 1.0)
    paths = [replace(p, cov=np.full_like(p.cov, np.nan)) if p.name == "MC37" else p for p in trial]
    sd = joint_angles(replace(trial, paths=tuple(paths)), model=UM2AS).sd
    assert np.isfinite(sd[:2]).all() and np.isnan(sd[2]).all()


def test_missing_and_degenerate_markers_give_no_angles_and_no_warnings():
    xyz = posed(phi2=np.full(5, 70.0)).xyz.copy()
    xyz[6, 1] = np.nan  # the hand's marker is missing
    xyz[2, 2] = xyz[1, 2]  # markers 2 and 3 in one place: the girdle has no normal
    xyz[3, 3] = np.inf
    straight = posed(phi2=0.0).xyz[:, 0]  # arm and forearm on a line: A.13 has no normal
    xyz[:, 4] = straight
    deg = joint_angles(with_marker_sd(trial_of(xyz), 1.0), model=UM2AS).deg
    known = np.isfinite(deg).all(-1)
    assert known.tolist() == [
        [True, True, False, False, False],
        [True, True, True, False, False],
        [True, False, True, False, True],
    ]


def test_the_elbow_of_the_thesis_is_unsure_near_extension():
    bent, nearly = (with_marker_sd(posed(phi2=phi), 1.0) for phi in (90.0, 3.0))
    a, b = (joint_angles(t, model=UM2AS).sd for t in (bent, nearly))
    assert b[1, 0, 2] > 4 * a[1, 0, 2] and b[0, 0, 2] > 4 * a[0, 0, 2]


def test_ranges_mark_and_do_not_hide():
    assert {m.positive for _, _, m in named_angles(UM2AS)} >= {"flexion", "adduction", "pronation", "ulnar deviation"}
    for j, t, motion in named_angles(UM2AS):
        low, high = list(RANGES.values())[j][t]
        assert motion.normal == ((low, high) if low < high else (-5.0, 5.0))
    trial = posed(phi1=np.array([0.0, -65.0]), phi2=np.array([140.0, 155.0]), phi3=np.array([0.0, 81.0]))
    angles = joint_angles(trial, model=UM2AS)
    out = outside(angles, UM2AS)
    assert not out[:, 0].any() and out[[0, 1, 2], 1, 0].all() and np.isfinite(angles.deg).all()


def test_absent_and_doubtful_markers_are_named():
    trial = trial_of(arm(duration_s=0.1).xyz)
    with pytest.raises(KinemarkError, match=r"wants the markers ELB4, MC37.*there are ACR1"):
        joint_angles(replace(trial, paths=tuple(p for p in trial if p.name not in ("ELB4", "MC37"))), model=UM2AS)
    two = replace(
        trial, paths=(*(replace(p, name=f"Ann:{p.name}") for p in trial), replace(trial["ELB4"], name="Bob:ELB4"))
    )
    with pytest.raises(KinemarkError, match="ELB4 fits several markers: Ann:ELB4, Bob:ELB4"):
        joint_angles(two, model=UM2AS)
    ann = replace(two, paths=two.paths[:-1])
    numbers = replace(trial, paths=tuple(replace(p, name=str(k)) for k, p in enumerate(trial, 1)))
    for other in (ann, numbers):
        assert np.array_equal(joint_angles(other, model=UM2AS).deg, joint_angles(trial, model=UM2AS).deg)
        assert chosen(other, UM2AS).names == chosen(trial, UM2AS).names


PLACE = {
    "C7": (-60, 0, 1500), "T8": (-80, 0, 1300), "IJ": (40, 0, 1450), "PX": (60, 0, 1250), "GH": (0, -200, 1400),
    "EL": (0, -240, 1100), "EM": (0, -160, 1100), "RS": (0, -225, 850), "US": (0, -200, 850),
    "MC3": (0, -212, 840), "MCP2": (0, -230, 770), "MCP3": (0, -212, 765), "MCP5": (0, -180, 775),
}  # fmt: skip


@pytest.mark.parametrize("side", ["right", "left"])
@pytest.mark.parametrize("axes", ["+x+y+z", "+y-x+z", "-x-y+z", "-y+x+z", "+x-z+y", "+z+x+y", "+z+y-x", "-y-z+x"])
def test_the_thorax_bends_alike_whichever_axis_is_up_and_whichever_way_the_subject_faces(axes, side):
    leaning = Rotation.from_euler("ZYX", [12, 25, -8], degrees=True).as_matrix()  # 25 forward
    points = np.array([leaning @ xyz for xyz in PLACE.values()], float)
    points[:, 1] *= -1 if side == "left" else 1
    signs, letters = axes[::2], axes[1::2]
    columns = [(-1 if s == "-" else 1) * np.eye(3)["xyz".index(one)] for s, one in zip(signs, letters, strict=True)]
    turn = np.array(columns)
    assert np.isclose(np.linalg.det(turn), 1)
    model = load_model("isb_upper_limb", side=side)
    here, there = (
        joint_angles(trial_of(xyz[:, None], names=tuple(PLACE)), model=model)["thorax"][0]
        for xyz in (points, points @ turn)
    )
    assert -45 < here[0] < -15  # flexion
    np.testing.assert_allclose(there, here, atol=1e-9)


def test_isb_axes_of_the_anatomical_position():
    """Upright, arms hanging, palms forward: all axes are the laboratory's; flexion and elevation as Wu has them."""
    model = load_model("isb_upper_limb")
    points = {name: np.array(xyz, float) for name, xyz in PLACE.items()}
    arm_, forearm = (
        ("GH", "EL", "EM", "RS", "US", "MC3", "MCP2", "MCP3", "MCP5"),
        ("RS", "US", "MC3", "MCP2", "MCP3", "MCP5"),
    )

    def at(R, names, about):
        moved = {n: (R @ (x - about) + about if n in names else x)[None] for n, x in points.items()}
        return joint_angles(trial_of(np.array(list(moved.values())), names=tuple(moved)), model=model)

    rest = at(np.eye(3), (), np.zeros(3))
    assert np.abs(rest["thorax"][0]).max() < 12 and abs(rest["elbow"][0, 0]) < 1e-6
    elbow = at(Rotation.from_euler("y", -90, degrees=True).as_matrix(), forearm, np.array([0, -200, 1100.0]))
    assert abs(elbow["elbow"][0, 0] - 90) < 1e-6  # the forearm comes forward: flexion
    lateral = at(Rotation.from_euler("x", -80, degrees=True).as_matrix(), arm_, points["GH"])
    front = at(Rotation.from_euler("y", -80, degrees=True).as_matrix(), arm_, points["GH"])
    assert abs(lateral["shoulder"][0, 0]) < 12 and abs(lateral["shoulder"][0, 1] + 80) < 8
    assert abs(front["shoulder"][0, 0] - 90) < 12 and abs(front["shoulder"][0, 1] + 80) < 8
    fist = at(Rotation.from_euler("y", -40, degrees=True).as_matrix(), ("MCP2", "MCP3", "MCP5"), points["MC3"])
    assert 35 < fist["wrist"][0, 0] - rest["wrist"][0, 0] < 45


def test_angular_velocity_of_a_steady_turn_is_exact():
    axis = np.array([0.6, -0.48, 0.64])
    t = np.arange(50) / 100
    R = (
        Rotation.from_rotvec(np.radians(400) * t[:, None] * axis).as_matrix()
        @ Rotation.random(random_state=4).as_matrix()
    )
    R[20] = np.nan
    omega = angular_velocity(R, rate=100.0)
    known = np.isfinite(omega).all(1)
    assert known.sum() == 50 - 2 - 2 and np.abs(omega[known] - 400 * axis).max() < 1e-6
    with pytest.raises(ValueError, match="wanted"):
        angular_velocity(R[0], rate=100.0)


def test_angular_velocity_of_the_limb_is_the_derivative_of_its_motion():
    t = np.arange(200) / 200
    trial = posed(phi1=40 * np.sin(2 * np.pi * t), theta1=20 * np.cos(3 * t), psi1=30 * t)
    R = joint_matrices(complete(points_of(trial), UM2AS), UM2AS)[0]
    omega = angular_velocity(R, rate=200.0)[1:-1]
    spin = np.gradient(R, 1 / 200, axis=0)[1:-1] @ R[1:-1].transpose(0, 2, 1)
    want = np.degrees(np.stack([spin[:, 2, 1], spin[:, 0, 2], spin[:, 1, 0]], -1))
    assert np.abs(omega - want).max() < 0.005 * np.abs(want).max()


@pytest.mark.parametrize("bad", [dict(lock_deg=90), dict(lock_deg=-1)])
def test_methods_refuse_what_they_cannot_mean(bad):
    for method in (SignedAngles, InverseCosines):
        with pytest.raises(ValueError, match="lock_deg"):
            method(**bad)


def test_a_locked_frame_decides_nothing():
    """Its first and third angle mean nothing, so that the next frame follows the one before it."""
    deg = np.array([[0.0, 0, 0], [60, 84, -60], [120, 84, -120], [179, 84, -179], [0, 0, 0]])
    np.testing.assert_allclose(followed(deg, np.array([False, True, True, True, False]), "zxy")[4], 0, atol=1e-9)
    assert np.abs(followed(deg, np.zeros(5, bool), "zxy")[4]).max() > 100


def arm_raised_after_hanging(hanging, plane, *, seed, n=240):
    """R (n, 3, 3) of an arm that hangs, trembling, is raised in a plane, and hangs and is raised again in another."""
    rng, t = np.random.default_rng(seed), np.linspace(0, 1, n)[:, None]
    lift = np.clip(np.sin(2 * np.pi * (2 * t - hanging)), 0, None)
    deg = np.hstack([np.where(t < 0.5, plane, plane - 110), -2 - 70 * lift, np.where(t < 0.5, -50 - plane, 20 - plane)])
    trembling = Rotation.from_rotvec(rng.normal(0, 3, (n, 3)) * (lift < 0.05), degrees=True).as_matrix()
    return turned(deg, "yxy") @ trembling


@pytest.mark.parametrize("seed", range(6))
def test_an_arm_that_hangs_at_first_is_raised_with_the_sign_of_the_convention(seed):
    rng = np.random.default_rng(100 + seed)
    R = arm_raised_after_hanging(rng.uniform(0.02, 0.2), rng.uniform(-80, 100), seed=seed)
    joint = Joint("shoulder", "a", "b", "yxy", middle="negative")
    found, locked = read_angles(R, joint, SignedAngles())
    assert locked[0] and (found[~locked, 1] < 0).all()
    known = np.isfinite(found).all(1)
    assert np.abs(turned(found[known], "yxy") - R[known]).max() < 1e-9


@pytest.mark.parametrize("middle", ["positive", "negative"])
def test_most_frames_decide_the_sign_of_elevation(middle):
    """The arm swings to the back for a moment, through the hanging posture, and then forward for long."""
    t = np.linspace(0, 1, 300)
    swing = np.where(t < 0.2, 20 * np.sin(np.pi * t / 0.2), -60 * np.sin(np.pi * (t - 0.2) / 0.8))
    deg = np.stack([np.full(300, 70.0), swing, np.full(300, -60.0)], -1)
    found, locked = read_angles(turned(deg, "yxy"), Joint("s", "a", "b", "yxy", middle=middle), SignedAngles())
    forward = ~locked & (t > 0.2)
    assert ((found[forward, 1] < 0) == (middle == "negative")).all()
    assert np.abs(np.diff(found[~locked], axis=0)).max() < 30  # and no curve jumps


SIGNED = """
base = "isb_shoulder"
name = "signed"
[signs]
shoulder = [1, -1, 1]
"""


def test_signs_turn_angles_words_and_ranges_round():
    plain, signed = load_model("isb_shoulder"), model_from_toml(SIGNED)
    rng = np.random.default_rng(3)
    names = plain.markers
    walk = rng.normal(0, 300, (len(names), 1, 3)) + np.cumsum(rng.normal(0, 4, (len(names), 30, 3)), 1)
    trial = with_marker_sd(Trajectories(tuple(map(MarkerTrajectory.measured, names, walk)), 50.0), 1.0)
    before, after = (joint_angles(trial, model=model) for model in (plain, signed))
    j = before.joints.index("shoulder")
    assert np.allclose(after.deg[j], before.deg[j] * [1, -1, 1], equal_nan=True)
    assert np.allclose(after.cov[j, :, 0, 1], -before.cov[j, :, 0, 1], equal_nan=True)
    assert np.allclose(after.cov[j, :, 1, 1], before.cov[j, :, 1, 1], equal_nan=True)
    assert np.allclose(after.deg[:j], before.deg[:j], equal_nan=True)
    motion = signed.joints[j].motions[1]
    assert (motion.positive, motion.normal) == ("elevation", (0.0, 180.0))
    with pytest.raises(KinemarkError, match="there are the joints"):
        model_from_toml(SIGNED.replace("shoulder = [", "hip = ["))
    with pytest.raises(KinemarkError, match="three of 1 and -1"):
        model_from_toml(SIGNED.replace("[1, -1, 1]", "[1, 2, 1]"))
