"""Force plates of all types: a force at a place with a free moment comes back from the channels that it makes."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from kinemark.data import Analog, ForcePlate, KinemarkError
from kinemark.gait import contacts, marker_points, reaction, standard_trial
from kinemark.gait.reaction import plate_axes
from kinemark.io.trial import read_trial
from support.shared import shared_data
from support.spreadsheet import numbers

CORNERS = np.array([[400.0, 0, 0], [0, 0, 0], [0, 600, 0], [400, 600, 0]])
"""x along the world's x, y against its y, z downwards."""
ORIGIN = np.array([3.0, -2.0, -40.0])
MATRIX = np.diag([2.0, 1.5, 4.0, 600.0, 500.0, 400.0]) + np.random.default_rng(0).normal(0, 0.02, (6, 6))
N = 50
RATE = 100.0


def loads(seed=0):
    """Force N and centre mm in the world, free moment N·m, of a foot."""
    rng = np.random.default_rng(seed)
    force = np.column_stack([rng.normal(0, 60, N), rng.normal(0, 40, N), rng.uniform(200, 900, N)])
    centre = np.column_stack([rng.uniform(50, 350, N), rng.uniform(50, 550, N), np.zeros(N)])
    return force, centre, rng.normal(0, 5, N)


def six(force, centre, free, corners=CORNERS):
    """What a sensor at `ORIGIN`, below the surface whichever way z goes, feels, N and N·mm, in the plate's axes."""
    R, middle = plate_axes(corners)
    origin = ORIGIN * (1, 1, -R[2, 2])
    F, p = force @ R, (centre - middle) @ R
    moment = np.cross(p, F) + np.outer(1000 * free, [0, 0, 1.0]) * (R[:, 2] @ [0, 0, 1.0])
    return F, moment + np.cross(origin, F), p, origin


def made(kind, seed=0, sign=1.0, corners=CORNERS):
    """A plate of a type and its channels for `loads`."""
    force, centre, free = loads(seed)
    F, M, p, origin = six(force, centre, free, corners)
    F, M, calibration = sign * F, sign * M, None
    if kind == 1:
        moment = sign * 1000 * free * (plate_axes(corners)[0][:, 2] @ [0, 0, 1.0])
        values = np.column_stack([F, p[:, :2], moment])
    elif kind == 3:
        values, origin = eight(F, M, origin)
    elif kind == 4:
        calibration = MATRIX
        values = np.column_stack([F, M]) @ np.linalg.inv(MATRIX).T
    elif kind == 5:
        values, calibration = np.column_stack([F, M]) @ FROM_SIX.T, np.linalg.pinv(FROM_SIX)
    else:
        values = np.column_stack([F, M])
    names = tuple(f"c{k}" for k in range(values.shape[1]))
    plate = ForcePlate(kind, corners, origin, names, calibration)
    return plate, (Analog(names, ("",) * len(names), RATE, values.T),), force, centre, free


FROM_SIX = np.random.default_rng(1).normal(0, 1, (8, 6))


def eight(F, M, origin):
    """Channels of sensors at (±a, ±b), and (a, b, height)."""
    a, b, height = 120.0, 200.0, origin[2]
    height_only = np.array([0.0, 0.0, height])
    M = M - np.cross(origin, F) + np.cross(height_only, F)  # about the middle of the sensors
    z = np.array([[1, 1, 1, 1], [b, b, -b, -b], [-a, a, a, -a]])
    fz = np.column_stack([F[:, 2], M[:, 0], M[:, 1]]) @ np.linalg.pinv(z).T
    x34 = F[:, 0] / 2 + M[:, 2] / (4 * b)
    y14 = F[:, 1] / 2 + M[:, 2] / (4 * a)
    values = np.column_stack([F[:, 0] - x34, x34, y14, F[:, 1] - y14, fz])
    return values, np.array([a, b, height])


ORDERS = {
    f"{'z up' if back else 'z down'}, from corner {first + 1}": np.roll(CORNERS, -first, axis=0)[:: -1 if back else 1]
    for back in (False, True)
    for first in range(4)
}


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("kind", [1, 2, 3, 4, 5])
def test_a_load_comes_back(kind, sign, order):
    """Whichever corner is the first, and which way round they go: the plate's axes go with them."""
    plate, analog, force, centre, free = made(kind, sign=sign, corners=ORDERS[order])
    found = reaction(plate, analog, n_frames=N, rate=RATE)
    np.testing.assert_allclose(found.force, force, atol=1e-8)
    np.testing.assert_allclose(found.centre, centre, atol=1e-6)
    np.testing.assert_allclose(found.free_moment, np.outer(free, [0, 0, 1]), atol=1e-8)


def test_an_origin_above_the_surface_is_one_below_it():
    plate, analog, _, centre, _ = made(2)
    upside = ForcePlate(2, CORNERS, -ORIGIN, plate.channels)
    np.testing.assert_allclose(reaction(upside, analog, n_frames=N, rate=RATE).centre, centre, atol=1e-6)


def test_a_frame_is_the_mean_of_its_samples():
    values = np.arange(200.0)[None] ** 2
    plate = ForcePlate(2, CORNERS, ORIGIN, tuple("abcdef"))
    analog = (Analog(tuple("abcdef"), ("N",) * 3 + ("Nmm",) * 3, 1000.0, np.repeat(values, 6, 0)),)
    found = reaction(plate, analog, n_frames=20, rate=100.0)
    assert abs(found.force[5, 2]) == pytest.approx(np.mean(np.arange(45.0, 56) ** 2))


def test_the_stated_baseline_is_taken_off_unless_somebody_stands_on_it():
    t = np.arange(400) / 1000.0
    foot = np.where(t > 0.2, 600.0, 0.0)
    off = np.array([3.0, -4.0, 25.0, 900.0, -400.0, 60.0])[:, None]
    clean = np.zeros((6, 400))
    clean[2] = -foot
    plate = ForcePlate(2, CORNERS, ORIGIN, tuple("abcdef"))

    def upwards(channels, **known):
        analog = Analog(plate.channels, ("N",) * 3 + ("N·mm",) * 3, 1000.0, channels)
        return reaction(replace(plate, **known), [analog], n_frames=40, rate=100.0).force[:, 2]

    true = upwards(clean)
    np.testing.assert_allclose(upwards(clean + off, zero_frames=np.array([2, 10])), true, atol=1e-9)
    assert upwards(clean + off)[30] != pytest.approx(600.0, abs=1)
    np.testing.assert_array_equal(upwards(clean + off, zero_frames=np.array([15, 25])), upwards(clean + off))


def test_the_same_load_by_type_2_and_by_type_4_differs_by_the_cross_talk_alone():
    one, other = (
        [reaction(t.plates[0], t.analog, n_frames=t.trajectories.n_frames, rate=t.trajectories.rate, threshold_n=20.0)]
        for t in (read_trial(shared_data(f"mocap3d/force_plate_types/TYPE-{kind}.C3D")) for kind in (2, 4))
    )
    a, b = one[0], other[0]
    both = a.loaded & b.loaded
    assert both.sum() > 20
    np.testing.assert_allclose(a.force[both], b.force[both], atol=0.03 * np.abs(a.force).max())
    assert np.median(np.abs(a.centre - b.centre)[both]) < 10.0
    assert a.force[both, 2].mean() > 100 and (a.force[both, 2] > 0).all()


@pytest.fixture(scope="module")
def sheet():
    """The spreadsheet of answers of the plates of types 2 and 4: 20 loads in counts of the converter, what a count is
    by channel and type, the calibration matrix (there a row a channel), forces and moments (20, 6) by type."""
    cells = numbers(shared_data("mocap3d/force_plate_types/TYPE-4.XLS"))

    def block(rows, columns):
        return np.array([[cells[0, r, c] for c in columns] for r in rows])

    rows = range(23, 43)
    return SimpleNamespace(
        counts=block(rows, range(1, 7)) - cells[0, 10, 4],
        scale={2: block(range(5, 11), [13])[:, 0], 4: block(range(5, 11), [14])[:, 0]},
        matrix=block(range(14, 20), range(9, 15)).T,
        answers={4: block(rows, range(9, 15)), 2: block(rows, range(16, 22))},
    )


def loads_of(plate, channels):
    """(N, 6) force and moment in the plate's axes, by what `reaction` says of them, and which of them are loaded."""
    n = len(channels)
    analog = Analog(plate.channels, ("",) * 6, 100.0, np.ascontiguousarray(channels.T))
    found = reaction(plate, (analog,), n_frames=n, rate=100.0, threshold_n=1e-6, averaged=False)
    R, middle = plate_axes(plate.corners)
    force, at, free = found.force @ R, (found.centre - middle) @ R, 1000 * found.free_moment @ R
    made = channels if plate.type == 2 else channels @ plate.calibration.T
    sign = np.sign(force[:, 2] @ made[:, 2])  # the floor pushes upwards, whatever the plate writes
    force, free = sign * force, sign * free
    x, y, _ = at.T
    moment = np.stack([y * force[:, 2], -x * force[:, 2], free[:, 2] + x * force[:, 1] - y * force[:, 0]], -1)
    return np.concatenate([force, moment], 1), found.loaded


@pytest.mark.parametrize("kind", [2, 4])
def test_plates_of_types_2_and_4_are_those_of_their_spreadsheet_to_the_printed_digits(kind, sheet):
    plate = read_trial(shared_data(f"mocap3d/force_plate_types/TYPE-{kind}.C3D")).plates[0]
    plate = replace(plate, origin=np.zeros(3), zero_frames=None)  # as the spreadsheet: about the sensor
    if kind == 4:
        written = plate.calibration.copy()
        written[5, 2] *= -1  # the file has this one of 36 with the other sign
        np.testing.assert_allclose(written, sheet.matrix, atol=0.5001e-3)  # of three decimals
        plate = replace(plate, calibration=sheet.matrix)
    found, loaded = loads_of(plate, sheet.counts * sheet.scale[kind])
    assert loaded.sum() == (np.abs(sheet.answers[kind][:, 2]) > 0).sum() >= 7
    np.testing.assert_allclose(found[loaded], sheet.answers[kind][loaded], rtol=1e-9, atol=1e-6)


def test_an_unloaded_plate_has_no_centre():
    plate, analog, *_ = made(2)
    quiet = (Analog(plate.channels, ("",) * 6, RATE, 1e-3 * analog[0].values),)
    found = reaction(plate, quiet, n_frames=N, rate=RATE)
    assert not found.loaded.any() and np.isnan(found.centre).all() and not found.force.any()


def test_moments_in_newton_metres_are_told_by_their_unit():
    plate, analog, _, centre, _ = made(2)
    metres = Analog(plate.channels, ("N",) * 3 + ("Nm",) * 3, RATE, analog[0].values / np.repeat([1, 1000], 3)[:, None])
    np.testing.assert_allclose(reaction(plate, (metres,), n_frames=N, rate=RATE).centre, centre, atol=1e-6)


@pytest.mark.parametrize(
    "plate", [ForcePlate(9, CORNERS, ORIGIN, tuple("abcdef")), ForcePlate(2, CORNERS, ORIGIN, tuple("abcdeg"))]
)
def test_what_cannot_be_read_is_named(plate):
    analog = (Analog(tuple("abcdef"), ("N",) * 6, RATE, np.zeros((6, N))),)
    with pytest.raises(KinemarkError, match=r"type 9|channels a, b"):
        reaction(plate, analog, n_frames=N, rate=RATE)


AHEAD = np.array([90.0, 0.0, 0.0])


def stepping(left, right, *, other_stands=False, at=None, loaded=(0.3, 0.7), speed=1500.0):
    """Two feet over one second: the left stands at `left` (2) mm from 0.3 to 0.7 s, the right elsewhere."""
    t = np.arange(100) / 100.0
    stand = (t >= 0.25) & (t < 0.75)
    points = {}
    for letter, place, still in (("L", left, True), ("R", right, other_stands)):
        middle = np.column_stack([np.full(100, place[0]), np.full(100, place[1]), np.full(100, 40.0)])
        middle[:, 0] += np.where(stand & still, 0, speed * (t - 0.5))
        points[letter + "HEE"], points[letter + "TOE"] = middle - AHEAD, middle + AHEAD
    force = np.where(((t >= loaded[0]) & (t < loaded[1]))[:, None], [0.0, 0, 700], 0.0)
    F, M, *_ = six(force, np.tile([*(at or left), 0.0], (100, 1)), np.zeros(100))
    analog = (Analog(tuple("abcdef"), ("",) * 6, 100.0, np.column_stack([F, M]).T),)
    plate = ForcePlate(2, CORNERS, ORIGIN, tuple("abcdef"))
    return contacts([reaction(plate, analog, n_frames=100, rate=100.0)], points, rate=100.0)


def test_a_foot_alone_on_a_plate_is_found():
    (one,) = stepping((200, 300), (700, 500))
    assert (one.side, one.reason, one.first, one.stop) == ("left", "", 30, 70)


@pytest.mark.parametrize(
    ("left", "right", "stands", "reason"),
    [((200, 300), (240, 420), True, "two_feet"), ((200, 640), (900, 100), False, "beside")],
)  # fmt: skip
def test_a_contact_that_does_not_count_says_why(left, right, stands, reason):
    (one,) = stepping(left, right, other_stands=stands)
    assert one.reason == reason


@pytest.mark.parametrize(("name", "plate"), [("HC031A23", 0), ("HC032A01", 0), ("HC002D02", 0)])
def test_two_feet_on_one_plate_are_told_though_the_pressure_is_near_neither(name, plate):
    """Who stands on one plate, or steps on it twice in a turn, was told that no foot was near, and to look for wrong
    corners."""
    walk = standard_trial(read_trial(shared_data("mocap3d/pig_gait_children") / f"{name}.c3d")).trial
    rate, n = walk.trajectories.rate, walk.trajectories.n_frames
    forces = [reaction(one, walk.analog, n_frames=n, rate=rate) for one in walk.plates]
    found = contacts(forces, marker_points(walk), rate=rate)
    assert [one.reason for one in found if one.plate == plate] == ["two_feet"]


@pytest.mark.parametrize("loaded", [(0.05, 0.7), (0.3, 0.95)])
def test_a_stick_that_loads_the_plate_while_the_foot_swings_is_noticed(loaded):
    (one,) = stepping((200, 300), (700, 500), loaded=loaded, speed=1100.0)
    assert (one.side, one.reason) == (None, "aid")


def on_two_plates(share, at):
    """A step on a plate of which this share of the force, from 0.5 s on, is on the next one, at `at` (2) mm."""
    t = np.arange(100) / 100.0
    stands = (t >= 0.3) & (t < 0.7)
    points = {}
    for letter, place in (("L", (200, 300)), ("R", (900, 300))):
        middle = np.column_stack([np.full(100, place[0]), np.full(100, place[1]), np.full(100, 40.0)])
        points[letter + "HEE"], points[letter + "TOE"] = middle - AHEAD, middle + AHEAD
    there = share * (t >= 0.5)
    found = []
    for k, (part, where, corners) in enumerate(
        ((1 - there, (200.0, 300.0), CORNERS), (there, at, CORNERS + np.array([400.0, 0, 0])))
    ):
        force = np.where(stands[:, None], part[:, None] * [0.0, 0, 700], 0.0)
        F, M, *_ = six(force, np.tile([*where, 0.0], (100, 1)), np.zeros(100), corners)
        names = tuple(f"{letter}{k}" for letter in "abcdef")
        analog = (Analog(names, ("",) * 6, 100.0, np.column_stack([F, M]).T),)
        found.append(reaction(ForcePlate(2, corners, ORIGIN, names), analog, n_frames=100, rate=100.0))
    return [(one.side, one.reason) for one in contacts(found, points, rate=100.0)]


@pytest.mark.parametrize(
    ("share", "at", "reason"),
    [(0.8, (405.0, 300.0), "two_plates"), (0.02, (405.0, 300.0), ""), (0.8, (750.0, 300.0), "")],
)
def test_a_foot_that_rolls_on_to_the_next_plate_does_not_count(share, at, reason):
    """Crosstalk and the other foot's load are no such thing."""
    assert on_two_plates(share, at)[0] == (None if reason else "left", reason)


@pytest.mark.parametrize("step", [250.0, 350.0, 600.0])
def test_a_step_counts_where_the_next_plate_has_the_other_foot_whose_markers_are_missing(step):
    """A child's short step: the left foot swings by the right one, which nobody sees on the next plate."""
    t = np.arange(200) / 100.0
    middle = np.column_stack(
        [np.interp(t, [0.9, 1.35], [200, 200 + 2 * step]), np.full(200, 300.0), np.full(200, 40.0)]
    )
    points = {"LHEE": middle - AHEAD, "LTOE": middle + AHEAD} | dict.fromkeys(
        ("RHEE", "RTOE"), np.full((200, 3), np.nan)
    )
    found = []
    for k, (begin, end, x) in enumerate(((0.3, 0.9, 200.0), (0.8, 1.4, 200.0 + step))):
        corners = CORNERS + k * np.array([max(step - 100.0, 400.0), 0, 0])
        force = np.where(((t >= begin) & (t < end))[:, None], [0.0, 0, 700], 0.0)
        F, M, *_ = six(force, np.tile([x, 300.0 - 100.0 * k, 0.0], (200, 1)), np.zeros(200), corners)
        names = tuple(f"{letter}{k}" for letter in "abcdef")
        analog = (Analog(names, ("",) * 6, 100.0, np.column_stack([F, M]).T),)
        found.append(reaction(ForcePlate(2, corners, ORIGIN, names), analog, n_frames=200, rate=100.0))
    first = contacts(found, points, rate=100.0)[0]
    assert (first.plate, first.side, first.reason) == (0, "left", "")


WORDS = [("Newton-Meters", 1e3), ("newton metre", 1e3), ("N millimeters", 1.0), ("NMeters", 1e3), ("N·cm", 10.0)]


@pytest.mark.parametrize(("unit", "newton_mm"), [("Nmm", 1.0), ("N*m", 1e3), ("kNmm", 1e3), ("kNm", 1e6), *WORDS])
def test_moments_have_a_unit(unit, newton_mm):
    plate, analog, *_ = made(2)
    scale = np.repeat([1, newton_mm], 3)[:, None]
    other = Analog(plate.channels, ("N",) * 3 + (unit,) * 3, RATE, analog[0].values / scale)
    one, two = (reaction(plate, (each,), n_frames=N, rate=RATE) for each in (analog[0], other))
    np.testing.assert_allclose(two.centre, one.centre, atol=1e-6)


@pytest.mark.parametrize(("unit", "newton"), [("Newtons", 1.0), ("kN", 1e3), ("Kilonewton", 1e3)])
def test_forces_have_a_unit(unit, newton):
    plate, analog, *_ = made(2)
    other = Analog(
        plate.channels, (unit,) * 3 + ("Nmm",) * 3, RATE, analog[0].values / np.repeat([newton, 1], 3)[:, None]
    )
    one, two = (reaction(plate, (each,), n_frames=N, rate=RATE) for each in (analog[0], other))
    np.testing.assert_allclose(two.force, one.force, atol=1e-6)


@pytest.mark.parametrize(("unit", "mm"), [("mm", 1.0), ("cm", 10.0), ("m", 1000.0), ("centimetres", 10.0)])
def test_a_measured_centre_has_a_unit(unit, mm):
    plate, analog, _, centre, _ = made(1)
    units = ("N", "N", "N", unit, unit, "Nmm")
    scale = np.array([1, 1, 1, mm, mm, 1])[:, None]
    other = Analog(plate.channels, units, RATE, analog[0].values / scale)
    np.testing.assert_allclose(reaction(plate, (other,), n_frames=N, rate=RATE).centre, centre, atol=1e-6)


def test_a_load_between_the_feet_belongs_to_neither():
    (one,) = stepping((200, 220), (200, 380), other_stands=True, at=(200, 295))
    assert (one.side, one.reason) == (None, "two_feet")
    (one,) = stepping((200, 540), (200, 660), other_stands=True, at=(200, 598))  # the other stands beside the plate
    assert (one.side, one.reason) == (None, "unclear")
