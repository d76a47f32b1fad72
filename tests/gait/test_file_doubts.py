"""What of a walk's file cannot be: names of markers that are exchanged, plates unlike what it says, lost samples."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from kinemark.data import MarkerTrajectory
from kinemark.data.strides import FootEvent
from kinemark.engine.gait.settings import GaitSettings
from kinemark.engine.gait.walks import gait_of_trial
from kinemark.findings.gait_doubts import of_doubts, of_plates
from kinemark.gait import analyse_gait, marker_points, standard_trial, with_static_offsets
from kinemark.gait.estimated_measures import mass_on_plates
from kinemark.gait.foot_events import foot_events
from kinemark.gait.marker_doubts import MarkerDoubts, marker_doubts
from kinemark.gait.plate_contacts import Contact
from kinemark.gait.plate_doubts import (
    PlateDoubt,
    plate_doubts,
    saturation_doubts,
    time_doubts,
    unit_doubts,
    weight_doubts,
)
from kinemark.gait.reaction import Reaction
from kinemark.io.c3d.subject_measures import measures_of
from kinemark.io.trial import read_trial
from kinemark.report.words import with_words
from kinemark.synth import WalkingBody, gait_laboratory
from support.shared import shared_data
from support.shift_gait import MEASURES

SETTINGS = GaitSettings(uncertainty=False, smoothing="none")


@cache
def lab():
    return gait_laboratory(WalkingBody(MEASURES), duration_s=2.6)


@cache
def measures():
    return with_static_offsets(MEASURES, marker_points(lab().static), flat_foot=True)


def gait(trial, of=None):
    return gait_of_trial(trial, measures() if of is None else of, SETTINGS, {})


def renamed(trial, *pairs):
    names = dict([*pairs, *(pair[::-1] for pair in pairs)])
    paths = tuple(replace(p, name=names.get(p.name, p.name)) for p in trial.trajectories)
    return replace(trial, trajectories=replace(trial.trajectories, paths=paths))


def both_sides(*names):
    return [("L" + name, "R" + name) for name in names]


ALL = ("ASI", "THI", "KNE", "TIB", "ANK", "HEE", "TOE")


@pytest.mark.parametrize(
    ("pairs", "how", "markers"),
    [
        ((), None, ()),
        (both_sides(*ALL), "sides", ()),
        (both_sides("ASI"), "across", ("LASI", "RASI")),
        (both_sides("KNE"), "across", ("LKNE", "RKNE")),
        (both_sides("ANK"), "across", ("LANK", "RANK")),
        (both_sides("TOE"), "across", ("LTOE", "RTOE")),
        ([("LHEE", "LTOE")], "foot", ("LHEE", "LTOE")),
        ([("RTIB", "RKNE")], "leg", ("RTIB", "RKNE")),
        ([("RTHI", "RKNE")], "leg", ("RTHI", "RKNE")),
        ([("RTIB", "RANK")], "leg", ("RTIB", "RANK")),
        ([("LKNE", "LANK")], "leg", ("LKNE", "LANK")),
        ([("RHEE", "RANK")], "leg", ("RANK", "RHEE")),
        ([("LTOE", "LANK")], "leg", ("LANK", "LTOE")),
    ],
)
def test_exchanged_names_are_told_however_the_subject_walks(pairs, how, markers):
    points = marker_points(renamed(lab().walk, *pairs))
    for deg in (0.0, 37.0, 180.0):
        c, s = np.cos(np.radians(deg)), np.sin(np.radians(deg))
        way = np.array([[c, s, 0], [-s, c, 0], [0, 0, 1.0]])
        found = marker_doubts({name: xyz @ way for name, xyz in points.items()})
        assert [each for each in found.exchanged if each[0] == how] == ([(how, markers)] if how else [])
        assert found.exchanged or not found.moved


def test_feet_that_turn_in_and_cross_are_no_exchange():
    points = dict(marker_points(lab().walk))
    for letter, sign in (("L", 1), ("R", -1)):
        c, s = np.cos(np.radians(40)), sign * np.sin(np.radians(40))
        turn = np.array([[c, s, 0], [-s, c, 0], [0, 0, 1.0]])  # to the inside, and the legs are nearer by 100 mm
        ankle, inwards = points[letter + "ANK"], np.array([0, -50.0 * sign, 0])
        for name in ("HEE", "TOE"):
            points[letter + name] = ankle + (points[letter + name] - ankle) @ turn.T + inwards
        points[letter + "ANK"] = ankle + inwards
    assert np.median((points["LTOE"] - points["RTOE"])[:, 1]) < -30
    assert marker_doubts(points) == MarkerDoubts()


@pytest.mark.parametrize("deg", [-100, -90, 90, 100])
def test_feet_that_are_turned_aside_are_no_exchange(deg):
    points = dict(marker_points(lab().walk))
    for letter, sign in (("L", 1), ("R", -1)):
        c, s = np.cos(np.radians(deg)), sign * np.sin(np.radians(deg))
        ankle = points[letter + "ANK"]
        for name in ("HEE", "TOE"):
            points[letter + name] = ankle + (points[letter + name] - ankle) @ [[c, s, 0], [-s, c, 0], [0, 0, 1]]
    assert not [how for how, _ in marker_doubts(points).exchanged if how == "foot"]


def test_a_whole_leg_that_is_exchanged_is_told():
    below = ("KNE", "ANK", "TOE")  # and the heels, which are too near to each other to tell
    found = marker_doubts(marker_points(renamed(lab().walk, *both_sides(*below, "TIB", "HEE"))))
    assert {name for how, markers in found.exchanged if how == "across" for name in markers} >= {
        letter + name for name in below for letter in "LR"
    }


def test_axes_that_are_left_handed_are_told():
    points = {name: xyz * (1, -1, 1) for name, xyz in marker_points(lab().walk).items()}
    assert [how for how, _ in marker_doubts(points).exchanged] == ["sides"]


def test_a_pelvis_that_is_named_the_wrong_way_round_is_told():
    points = dict(marker_points(lab().walk))
    left = points["LASI"] - points["RASI"]
    turned = points | {"SACR": (points["LASI"] + points["RASI"]) / 2}
    turned |= {"LASI": points["SACR"] + left / 2, "RASI": points["SACR"] - left / 2}
    assert [how for how, _ in marker_doubts(turned).exchanged] == ["pelvis"]


def test_a_marker_that_comes_off_is_told_and_one_that_is_never_seen_is_not():
    points = dict(marker_points(lab().walk))
    off = points["LKNE"].copy()
    off[100:] += (0, 0, 150.0)
    found = marker_doubts(points | {"LKNE": off})
    assert not found.exchanged and {name for a, b, _ in found.moved for name in (a, b)} >= {"LKNE", "LANK"}
    assert marker_doubts(points | {"LKNE": np.full_like(off, np.nan)}).moved == ()


def corners(order):
    def changed(walk):
        return replace(walk, plates=tuple(replace(p, corners=p.corners[order]) for p in walk.plates))

    return changed


def channels(factor, of):
    """Channels `of` each plate times a factor."""

    def changed(walk):
        names = {name for plate in walk.plates for name in plate.channels[of]}
        analog = [
            replace(a, values=a.values * np.where([n in names for n in a.names], factor, 1.0)[:, None])
            for a in walk.analog
        ]
        return replace(walk, analog=tuple(analog))

    return changed


def later(seconds):
    def changed(walk):
        return replace(walk, analog=tuple(replace(a, start=a.start + seconds) for a in walk.analog))

    return changed


def aside(walk):
    return replace(walk, plates=tuple(replace(p, corners=np.add(p.corners, (0, 70.0, 0))) for p in walk.plates))


OTHER_ORDERS = ([3, 2, 1, 0], [0, 3, 2, 1], [1, 0, 3, 2], [2, 1, 0, 3], [2, 3, 0, 1], [1, 2, 3, 0], [3, 0, 1, 2])
"""All but the right one; each turns or mirrors the plate."""


@pytest.mark.parametrize(
    ("changed", "told"),
    [
        (lambda walk: walk, set()),
        (channels(-1.0, slice(None)), set()),  # what the foot does to the plate is as good
        *((corners(order), {"backward", "beside", "askew"}) for order in OTHER_ORDERS),
        (aside, {"beside"}),
        (channels(0.5, slice(None)), {"weight"}),
    ],
)
def test_plates_that_are_not_as_the_file_says_are_told(changed, told):
    found = {doubt.what for doubt in gait(changed(lab().walk)).plates}
    assert found <= told and bool(found) == bool(told)


def stance(rolls_mm, aside_mm):
    """A foot of 160 mm that stands, and pressure below it that rolls so far forward, so far to its left."""
    n = 60
    heel = np.tile([0.0, 0, 40.0], (n, 1))
    points = {
        "LHEE": heel,
        "LTOE": np.add(heel, (160.0, 0, 0)),
        "RHEE": np.add(heel, (0, 3000.0, 0)),
        "RTOE": np.add(heel, (160.0, 3000, 0)),
    }
    centre = np.column_stack([np.linspace(80 - rolls_mm / 2, 80 + rolls_mm / 2, n), np.full(n, aside_mm), np.zeros(n)])
    force = np.column_stack([np.zeros((n, 2)), 700 * np.sin(np.linspace(0.1, 3.0, n))])
    true = np.ones(n, np.bool_)
    plate = Reaction(force, centre, np.zeros((n, 3)), true, np.zeros((4, 3)), ~true)
    return (plate,), (Contact(0, 0, n, "left", "", 10.0),), points


@pytest.mark.parametrize(
    ("rolls_mm", "aside_mm", "told"),
    [(150, 5, []), (60, -20, []), (0, 0, ["backward"]), (-120, 10, ["backward"]), (140, 70, ["beside"])],
)
def test_pressure_goes_forward_below_the_foot(rolls_mm, aside_mm, told):
    for deg in (0.0, 130.0):
        c, s = np.cos(np.radians(deg)), np.sin(np.radians(deg))
        way = np.array([[c, s, 0], [-s, c, 0], [0, 0, 1.0]])
        (plate,), contacts, points = stance(rolls_mm, aside_mm)
        turned = {name: xyz @ way for name, xyz in points.items()}
        found = plate_doubts([replace(plate, centre=plate.centre @ way)], contacts, turned)
        assert [doubt.what for doubt in found] == told


@pytest.mark.parametrize(("newton", "told"), [(30.0, []), (200.0, ["beside"])])
def test_a_stick_on_the_plate_of_the_foot_is_told(newton, told):
    """It stands 200 mm beside the foot from 40 to 90 % of the contact."""
    (plate,), contacts, points = stance(150, 5)
    n = len(plate.centre)
    on = (np.arange(n) > 0.4 * n) & (np.arange(n) < 0.9 * n)
    z = plate.force[:, 2] + newton * on
    centre = (plate.centre * plate.force[:, 2:] + (newton * on)[:, None] * [100.0, 200.0, 0.0]) / z[:, None]
    found = plate_doubts(
        [replace(plate, force=plate.force + (newton * on)[:, None] * [0, 0, 1.0], centre=centre)], contacts, points
    )
    assert [doubt.what for doubt in found] == told


def test_a_foot_that_strikes_with_the_toes_is_no_doubt_of_the_plate():
    (plate,), contacts, points = stance(150, 5)
    n = len(plate.centre)
    x = np.concatenate([np.linspace(165, 50, n // 3), np.linspace(50, 150, n - n // 3)])
    centre = plate.centre.copy()
    centre[:, 0] = x
    assert plate_doubts([replace(plate, centre=centre)], contacts, points) == ()


def test_pressure_at_the_edge_of_a_raised_foot_is_below_it():
    (plate,), contacts, points = stance(60, 38)
    raised = points | {"LHEE": points["LTOE"] - (160 * np.cos(0.8), 0, -160 * np.sin(0.8))}
    centre = np.add(plate.centre, (40.0, 0, 0))
    assert plate_doubts([replace(plate, centre=centre)], contacts, raised) == ()


def weighed(newton):
    """kg of steps of so many N by (side, N), and what is said of 70 kg."""
    true = np.ones(60, np.bool_)
    plates = [
        Reaction(np.tile([0.0, 0, n], (60, 1)), np.zeros((60, 3)), np.zeros((60, 3)), true, np.zeros((4, 3)), ~true)
        for _, n in newton
    ]
    contacts = [Contact(k, 0, 60, side, "", 10.0) for k, (side, _) in enumerate(newton)]
    events = [FootEvent(side, True, time, 0.005, "plate") for side in ("left", "right") for time in (0.0, 1.2)]
    kg = mass_on_plates(plates, contacts, events, rate=100)
    return kg, [doubt.what for doubt in weight_doubts(kg, 70.0, contacts)]


def test_a_leg_that_is_spared_is_no_doubt_of_the_weight():
    body = 70.0 * 9.81
    assert weighed([("left", 0.8 * body)]) == (pytest.approx(56, rel=1e-3), [])
    kg, said = weighed([("left", 0.8 * body), ("left", 0.8 * body), ("right", 1.2 * body)])
    assert kg == pytest.approx(70, rel=1e-3) and not said
    assert weighed([("left", 0.7 * body), ("right", 0.9 * body)])[1] == ["weight"]
    assert weighed([("left", 0.5 * body)])[1] == ["weight"]


def test_plates_and_cameras_that_do_not_begin_together_are_told():
    seen = [FootEvent("left", k % 2 == 0, 0.5 + 0.6 * k, 0.005, "markers") for k in range(4)]
    for late in (0.0, 0.02, 0.05, -0.05):
        measured = [event._replace(time=event.time + late, source="plate") for event in seen]
        found = time_doubts(seen, measured)
        assert [doubt.value for doubt in found] == (pytest.approx([late]) if abs(late) > 0.03 else [])
    slow = [event._replace(time=3 * event.time) for event in seen]
    assert time_doubts(slow, [event._replace(time=event.time + 0.05, source="plate") for event in slow]) == ()
    only = [event for event in seen if event.strike]
    assert time_doubts(only, [event._replace(time=event.time + 0.05) for event in only]) == ()


@pytest.mark.parametrize("name", ["HC030A05", "HC030A22"])
def test_real_walks_are_not_doubted_and_moments_of_another_unit_are(name):
    folder = shared_data("mocap3d/pig_gait_child")
    walk = standard_trial(read_trial(folder / f"{name}.c3d")).trial
    of = measures_of(walk.source)
    found = gait(walk, of)
    assert (found.names, found.plates) == (MarkerDoubts(), ())
    assert {d.what for d in gait(channels(1e-3, slice(3, 6))(walk), of).plates} & {"beside", "backward"}
    late = [doubt for doubt in gait(later(0.05)(walk), of).plates if doubt.what == "time"]
    assert len(late) == 1 and late[0].value == pytest.approx(0.05, abs=0.01)


def lost(trial, share, samples, value):
    """So many samples of the plates' channels, from a share of the first contact on."""
    contact = gait(trial).gait.contacts[0]
    record = trial.analog[0]
    first = int((contact.first + share * (contact.stop - contact.first)) / trial.trajectories.rate * record.rate)
    rows = [record.names.index(name) for name in trial.plates[contact.plate].channels]
    values = record.values.copy()
    values[rows, first : first + samples] = value
    return replace(trial, analog=(replace(record, values=values), *trial.analog[1:])), contact


def test_samples_that_a_plate_lost_are_no_force_of_nothing():
    walk, contact = lost(lab().walk, 0.4, 60, np.nan)
    whole, found = gait(lab().walk).gait, gait(walk).gait
    name = contact.side[0].upper() + "AnkleMoment"
    ours, true = found.signals[name].values, whole.signals[name].values
    inside = slice(contact.first, contact.stop)
    missing = np.isnan(ours[inside]).any(1)
    assert 5 <= missing.sum() <= 10
    np.testing.assert_allclose(ours[inside][~missing], true[inside][~missing], atol=1e-9)
    assert [c[:5] for c in found.contacts] == [c[:5] for c in whole.contacts]


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_single_samples_that_are_lost_take_no_step_away(value):
    rng = np.random.default_rng(3)
    record = lab().walk.analog[0]
    values = np.where(rng.random(record.values.shape[1]) < 0.01, value, record.values)
    found = gait(replace(lab().walk, analog=(replace(record, values=values), *lab().walk.analog[1:]))).gait
    whole = gait(lab().walk).gait
    assert [c[:5] for c in found.contacts] == [c[:5] for c in whole.contacts]
    for name in ("LAnkleMoment", "RAnkleMoment"):
        ours, true = found.signals[name].values, whole.signals[name].values
        assert (np.isnan(ours) == np.isnan(true)).all() and np.nanmax(np.abs(ours - true)) < 0.01 * np.nanmax(true)


@pytest.mark.parametrize("lost", [1, 6])
def test_a_strike_within_lost_samples_says_how_well_it_is_known(lost):
    record = lab().walk.analog[0]
    whole = next(e for e in foot_events(lab().walk, marker_points(lab().walk)) if e.strike and e.source == "plate")
    at = round((whole.time - record.start) * record.rate)
    values = record.values.copy()
    values[:, at - lost // 2 : at - lost // 2 + lost] = np.nan
    walk = replace(lab().walk, analog=(replace(record, values=values), *lab().walk.analog[1:]))
    events = foot_events(walk, marker_points(walk))
    found = min((e for e in events if e.strike), key=lambda e: abs(e.time - whole.time))
    assert abs(found.time - whole.time) <= max(2 * found.sd, 1 / record.rate)


def test_lost_samples_change_neither_events_nor_weight():
    walk, _ = lost(lab().walk, 0.4, 60, np.nan)
    ways = []
    for trial in (lab().walk, walk):
        points, rate = marker_points(trial), trial.trajectories.rate
        events, found = foot_events(trial, points), analyse_gait(trial, measures())
        ways.append((events, mass_on_plates(found.reactions, found.contacts, events, rate=rate)))
    assert [e.time for e in ways[0][0]] == [e.time for e in ways[1][0]]
    assert ways[1][1] == pytest.approx(ways[0][1], rel=0.01)


def test_a_plate_that_stops_within_a_step_says_no_foot_off():
    walk, contact = lost(lab().walk, 0.6, 10_000, np.nan)
    found = gait(walk)
    cut = next(c for c in found.gait.contacts if c.first == contact.first)
    assert cut.reason == "cut"
    after = found.gait.signals[contact.side[0].upper() + "GroundReactionForce"].values[cut.stop : contact.stop]
    assert len(after) > 10 and np.isnan(after).all()


def test_who_reads_is_told_what_to_do():
    walk = renamed(lab().walk, ("LHEE", "LTOE"))
    off = walk.trajectories["RKNE"].xyz.copy()
    off[100:] += (0, 0, 150.0)
    paths = tuple(MarkerTrajectory.measured("RKNE", off) if p.name == "RKNE" else p for p in walk.trajectories)
    found = gait(replace(walk, trajectories=replace(walk.trajectories, paths=paths)))
    late = [
        *of_doubts("walk", found.names, found.leaps),
        *of_plates("walk", (*found.plates, PlateDoubt(None, "time", -0.06)), ()),
    ]
    said = with_words({"findings": [one.as_dict() for one in late]})["findings"]
    texts = " ".join(one["text"] + " " + one["advice"] for one in said)
    assert "LHEE" in texts and "point backwards" in texts and "before those of the markers" in texts
    assert "RKNE–RANK" in texts and "{" not in texts


@pytest.mark.parametrize("factor", [1.0, -1.0])
def test_a_plate_that_is_cut_off_at_its_limit_is_told_though_nobody_states_the_mass(factor):
    walk = channels(factor, slice(None))(lab().walk)
    assert saturation_doubts(walk.plates, walk.analog) == ()
    vertical = walk.plates[1].channels[2]

    def cut(block):
        x, k = block.values.copy(), block.names.index(vertical)
        x[k] = np.clip(x[k], 0.8 * x[k].min(), 0.8 * x[k].max())
        return replace(block, values=x)

    found = saturation_doubts(walk.plates, [cut(block) if vertical in block.names else block for block in walk.analog])
    assert [(one.plate, one.what) for one in found] == [(1, "saturated")] and 0.2 < found[0].value < 0.9


@pytest.mark.parametrize(("unit", "factor", "doubted"), [("", 1e-3, True), ("kN", 1e-3, False), ("", 1.0, False)])
def test_a_plate_in_kilonewtons_that_states_no_unit(unit, factor, doubted):
    walk = lab().walk
    forces = {name for plate in walk.plates for name in plate.channels}

    def other(block):
        own = np.isin(block.names, list(forces))
        units = tuple(unit if mine else text for mine, text in zip(own, block.units, strict=True))
        return replace(block, units=units, values=np.where(own[:, None], factor, 1.0) * block.values)

    found = unit_doubts(walk.plates, [other(block) for block in walk.analog])
    assert [(one.plate, one.what) for one in found] == ([(k, "unit") for k in range(len(walk.plates))] * doubted)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_the_noise_of_a_plate_on_which_nobody_steps_is_no_load_in_kilonewtons(seed):
    walk, rng = lab().walk, np.random.default_rng(seed)
    blocks = [
        replace(block, units=("",) * len(block.units), values=rng.normal(0, 0.4, block.values.shape))
        for block in walk.analog
    ]
    assert unit_doubts(walk.plates, blocks) == ()


@pytest.mark.parametrize("seed", [21, 22])
def test_a_belt_that_writes_nothing_below_a_threshold_is_not_at_its_limit(seed):
    """A belt of a treadmill bears a foot for most of the time, and its rest is 0, sample by sample."""
    rng = np.random.default_rng(seed)
    walk = lab().walk
    plate = walk.plates[0]
    step = np.concatenate([700 * np.sin(np.linspace(0, np.pi, 620)) ** 0.4, np.zeros(380)])
    force = np.tile(step, 8) + rng.normal(0, 1.5, 8000)
    channels = np.zeros((len(plate.channels), len(force)))
    channels[2] = -np.where(force < 20, 0, force)
    block = replace(walk.analog[0], names=plate.channels, units=("N",) * len(channels), values=channels)
    assert saturation_doubts([plate], [block]) == ()
    cut = replace(block, values=np.maximum(channels, -600))
    assert [one.what for one in saturation_doubts([plate], [cut])] == ["saturated"]


def plates(**changed):
    def of(plate):
        return replace(plate, **{name: change(getattr(plate, name)) for name, change in changed.items()})

    return lambda trial: replace(trial, plates=tuple(map(of, trial.plates)))


@pytest.mark.parametrize(
    ("changed", "told"),
    [
        ({}, set()),
        ({"corners": lambda c: 1000 * c}, {"elsewhere"}),
        ({"corners": lambda c: c / 1000}, {"elsewhere"}),
        ({"corners": lambda c: c + np.array([2000.0, 1000.0, 0.0])}, {"elsewhere"}),
        ({"origin": lambda o: np.array([0.0, 0.0, 0.04])}, {"origin"}),
        ({"origin": lambda o: np.array([0.0, 0.0, 40e3])}, {"origin"}),
        ({"origin": lambda o: np.array([900.0, 0.0, 40.0])}, {"origin"}),
        ({"origin": lambda o: np.zeros(3)}, set()),
    ],
)
@pytest.mark.parametrize(
    "name", ["pig_gait_child/HC030A05", "pig_gait_children/HC031A23", "pig_gait_children/HC002D25"]
)
def test_plates_that_are_elsewhere_and_origins_of_another_unit_are_told(name, changed, told):
    """A step on a plate 1000 times too far was no step, and nothing was said but that no foot was near."""
    walk = standard_trial(read_trial(shared_data("mocap3d") / f"{name}.c3d")).trial
    found = gait(plates(**changed)(walk), measures_of(walk.source)).plates
    where = [doubt for doubt in found if doubt.what in ("elsewhere", "origin")]
    assert bool(where) == bool(told) and told <= {doubt.what for doubt in where}
    assert len({doubt.plate for doubt in where}) == len(where)  # of each plate one
    said = with_words({"findings": [one.as_dict() for one in of_plates("walk", where, ())]})
    assert all("mm or m" in one["advice"] and "{" not in one["text"] for one in said["findings"])
