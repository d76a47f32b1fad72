"""Newton and Euler on moving legs: the whole obeys the laws that the parts were made from."""

import numpy as np
import pytest

from kinemark.data import KinemarkError
from kinemark.data.subject_measures import LegMeasures, SubjectMeasures
from kinemark.gait import (
    INERTIAS,
    GroundContact,
    Leg,
    LowerLimbs,
    Segment,
    five_point,
    five_point_slope,
    joint_loads,
    lower_limbs,
)
from kinemark.gait.inverse_dynamics import angular_velocity, spline_acceleration, twice_five_point
from kinemark.kinematics import turned
from support.standing import walker

LEG = LegMeasures(leg_mm=900.0, knee_mm=100.0, ankle_mm=70.0)
MEASURES = SubjectMeasures(LEG, LEG, mass_kg=70.0)
RATE, N = 100.0, 200
FOOT = 200.0
UP = np.array([0.0, 0.0, 1.0])


def swinging(seed=0):
    """A leg of rigid segments below a pelvis that moves, all joints turning in all directions."""
    rng = np.random.default_rng(seed)
    t = np.arange(N) / RATE

    def smooth(size):
        phase = rng.uniform(0, 6, (2, 3))
        return size * sum(
            rng.normal(0, 1, 3) * np.sin(2 * np.pi * f * t[:, None] + p) for f, p in zip((1, 2), phase, strict=True)
        )

    def below(parent, size, length):
        R = parent.R @ turned(smooth(size), "yxz")
        return R, parent.origin - length * R[..., 2]

    pelvis = Segment(turned(smooth(5.0), "xyz"), smooth(60.0) + np.array([0, 0, 900.0]))
    thigh_R, knee = below(pelvis, 12.0, 420.0)
    shank_R, ankle = below(Segment(thigh_R, knee), 12.0, 400.0)
    foot_R, toe = below(Segment(shank_R @ turned(np.array([-90.0, 0, 0]), "yxz"), ankle), 8.0, 160.0)
    thigh, shank, foot = Segment(thigh_R, knee), Segment(shank_R, ankle), Segment(foot_R, toe)
    leg = Leg(pelvis.origin, thigh, shank, shank, foot, foot)
    return LowerLimbs(pelvis, leg, leg)


def air(n=N):
    return GroundContact(np.zeros((n, 3)), np.full((n, 3), np.nan), np.zeros((n, 3)))


def loads(limbs, contact, **options):
    settings = {"mass_kg": 70.0, "foot_mm": FOOT, "rate": RATE, "inertia": INERTIAS["winter"]} | options
    return joint_loads(limbs.left, limbs.pelvis, contact, **settings)


def parts(limbs):
    """(segment, mass kg, centre (N, 3) mm, inertia (N, 3, 3) kg m²) of foot, shank and thigh."""
    leg, shares = limbs.left, INERTIAS["winter"]
    toe = leg.ankle - FOOT * leg.foot.R[..., 2]
    for name, segment, top, bottom in (
        ("foot", leg.foot, leg.ankle, toe), ("shank", leg.shank, leg.knee, leg.ankle),
        ("thigh", leg.thigh, leg.hip, leg.knee),
    ):  # fmt: skip
        share = shares[name]
        length = FOOT if name == "foot" else np.linalg.norm(top - bottom, axis=1).mean()
        diagonal = share.mass * 70.0 * np.diag((np.array(share.radius) * length / 1000) ** 2)
        inertia = segment.R @ diagonal @ np.swapaxes(segment.R, -1, -2)
        yield segment, share.mass * 70.0, top + share.centre * (bottom - top), inertia


def test_the_hip_carries_the_whole_leg():
    """Force and moment on the hip are what changes the momenta of all three segments, taken about the origin."""
    limbs = swinging()
    force = np.tile([20.0, -10.0, 600.0], (N, 1))
    centre = limbs.left.foot.origin * (1, 1, 0)
    contact = GroundContact(force, centre, np.tile([0.0, 0.0, 3.0], (N, 1)))
    hip = loads(limbs, contact)["Hip"]
    momentum, spin = np.zeros((N, 3)), np.zeros((N, 3))
    weight, torque = np.zeros((N, 3)), np.zeros((N, 3))
    for segment, m, c, inertia in parts(limbs):
        v = five_point(c, 1 / RATE) / 1000
        omega = angular_velocity(segment.R, 1 / RATE, five_point)
        momentum += m * v
        spin += np.cross(c / 1000, m * v) + np.einsum("fij,fj->fi", inertia, omega)
        weight += -m * 9.81 * UP
        torque += np.cross(c / 1000, -m * 9.81 * UP)
    change = five_point(momentum, 1 / RATE)
    np.testing.assert_allclose((change - weight - force)[4:-4], hip.force[4:-4], atol=1e-9)
    outside = torque + np.cross(centre / 1000, force) + contact.free_moment
    about = np.cross(limbs.left.hip / 1000, hip.force) + hip.moment
    off = (five_point(spin, 1 / RATE) - outside - about)[4:-4]
    assert np.abs(off).max() < 2e-3 * np.abs(about[4:-4]).max()  # of the derivative of a product, O(Δt⁴)


def test_a_standing_leg_holds_weights_on_levers():
    one = lower_limbs({name: np.repeat(x, 30, 0) for name, x in walker(1, n=1).items()}, MEASURES)
    ankle = one.left.ankle
    force = np.tile([0.0, 0.0, 350.0], (30, 1))
    contact = GroundContact(force, ankle * (1, 1, 0) + (60.0, 0, 0), np.zeros((30, 3)))
    found = loads(one, contact)
    m = INERTIAS["winter"]["foot"].mass * 70.0
    foot_centre = ankle - 0.5 * FOOT * one.left.foot.R[..., 2]
    lever = (contact.centre - ankle) / 1000
    expected = -np.cross(lever, force) - np.cross((foot_centre - ankle) / 1000, -m * 9.81 * UP)
    np.testing.assert_allclose(found["Ankle"].moment[4:-4], expected[4:-4], atol=1e-9)
    assert found["Ankle"].moment[5, 1] > 15  # plantar flexors hold a body that leans on the forefoot
    np.testing.assert_allclose(found["Hip"].power[4:-4], 0, atol=1e-9)


def test_powers_are_the_work_that_changes_the_energy():
    """In the air, with the pelvis moving, power at the joints and of the hip's force is the change of energy."""
    limbs = swinging(2)
    found = loads(limbs, air())
    energy = np.zeros(N)
    for segment, m, c, inertia in parts(limbs):
        v = five_point(c, 1 / RATE) / 1000
        omega = angular_velocity(segment.R, 1 / RATE, five_point)
        energy += (
            0.5 * m * (v**2).sum(1) + 0.5 * np.einsum("fi,fij,fj->f", omega, inertia, omega) + m * 9.81 * c[:, 2] / 1000
        )
    pelvis = angular_velocity(limbs.pelvis.R, 1 / RATE, five_point)
    joints = sum(load.power for load in found.values())
    at_hip = (found["Hip"].force * five_point(limbs.left.hip, 1 / RATE)).sum(1) / 1000
    expected = joints + at_hip + (found["Hip"].moment * pelvis).sum(1)
    change = five_point(energy[:, None], 1 / RATE)[:, 0]
    off = np.abs(change - expected)[6:-6]
    assert off.max() < 1e-3 * np.nanmax(np.abs(change))  # of derivatives of products, O(Δt⁴)


@pytest.mark.parametrize(("derivative", "order"), [(five_point, 4), (five_point_slope, 2)])
def test_derivatives_converge_as_they_should(derivative, order):
    errors = []
    for n in (40, 80):
        t = np.arange(n) / n
        off = derivative(np.sin(2 * np.pi * t)[:, None], 1 / n)[:, 0] - 2 * np.pi * np.cos(2 * np.pi * t)
        errors.append(np.nanmax(np.abs(off)))
    assert np.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.1)


def test_without_a_mass_there_are_no_moments():
    with pytest.raises(KinemarkError, match="mass"):
        loads(swinging(), air(), mass_kg=np.nan)


def test_the_acceleration_by_a_spline_is_exact_for_quintics_and_better_than_differences_where_it_shakes():
    t = np.arange(60) / 100.0
    cubic = np.stack([3 * t**2 - 2 * t**3, t, 5 + 0 * t], -1) * 1000
    found = spline_acceleration(cubic, 0.01)
    np.testing.assert_allclose(found[12:-12], np.stack([6 - 12 * t, 0 * t, 0 * t], -1)[12:-12] * 1000, atol=2.0)
    assert np.isnan(found[:4]).all() and np.isnan(found[-4:]).all() and np.isfinite(found[4:-4]).all()
    shaking = np.sin(2 * np.pi * 20.0 * t)[:, None]
    true = -((2 * np.pi * 20.0) ** 2) * shaking
    off = [np.abs(d(shaking, 0.01) - true)[20:-20].max() for d in (spline_acceleration, twice_five_point)]
    assert off[0] < off[1] / 3
    holed = cubic.copy()
    holed[30] = np.nan
    there = np.isfinite(spline_acceleration(holed, 0.01)).all(1)
    assert there.sum() == 60 - 1 - 16 and not there[26:35].any()
