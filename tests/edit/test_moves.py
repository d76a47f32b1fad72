"""Edits of a file that was written again in another world go with its places."""

from dataclasses import replace

import numpy as np
import pytest

from kinemark.data import MarkerTrajectory, Origin, same
from kinemark.data.edits import AddEvent, Claim, Erase, Put, Trim
from kinemark.edit import anchored, replay, stretch_of
from kinemark.edit.moves import carried_over
from kinemark.edit.values import Footage
from support.edited import entries, paths_without_images

TURNED = np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]])
"""Y up for Z up."""
UNMOVED = np.eye(3), np.zeros(3)


def of_file(R=UNMOVED[0], t=UNMOVED[1], n=6, change=lambda xyz: xyz, names="ABCDEF", **made):
    """A file, moved by R x + t, with a spike in A, a gap in B, and other samples by `change`."""
    given = paths_without_images(n=n, **made)
    paths = [path.xyz.copy() for path in given]
    paths[0][80:84] += 80.0
    paths[1][100:120] = np.nan
    moved = (MarkerTrajectory.measured(name, change(xyz @ R.T + t)) for name, xyz in zip(names, paths, strict=False))
    return replace(given, paths=tuple(moved))


def said_of(given):
    """A journal of claims, values, a trim and an event; the places of B by hand, from the whole walk of it."""
    place = paths_without_images(n=6)["*2"].xyz[109]
    some = (
        Claim(stretch_of(given, "C", at=60), "LKNE"),
        (Claim(stretch_of(given, "D", first=101), "E"), Claim(stretch_of(given, "E", first=101), "D")),
        anchored(Erase("A", 81, 84), given, None, ""),
        anchored(Put("B", 110, tuple(place.tolist()), 1.0), given, None, ""),
        anchored(Trim(11, 190), given, None, ""),
        anchored(AddEvent("Foot Strike", "Left", 0.5), given, None, ""),
    )
    return entries(*some)


def outcomes(edited):
    return [one.outcome for one in edited.applied]


@pytest.mark.parametrize(
    ("R", "t"),
    [(UNMOVED[0], np.array([1000.0, -20.0, 0])), (TURNED, UNMOVED[1]), (TURNED, np.array([3.0, 900.0, 50.0]))],
    ids=["another origin", "other axes", "both"],
)
def test_edits_go_with_the_places_of_a_file_that_was_moved(R, t):
    said = said_of(of_file())
    before, after = replay(of_file(), said), replay(of_file(R, t), said)
    assert outcomes(before) == outcomes(after) == ["held"] * 7
    assert [path.name for path in before.trajectories] == [path.name for path in after.trajectories]
    for old, new in zip(before.trajectories, after.trajectories, strict=True):
        assert np.array_equal(old.origin, new.origin)
        there = old.origin != Origin.MISSING
        apart = np.abs(old.xyz[there] @ R.T + t - new.xyz[there])
        assert apart.max(initial=0) < 0.01, "the place that was put among them"
    assert after.applied[0].reason.startswith("all places of the file were moved")
    assert before.kept == after.kept and before.events[0].time_s == after.events[0].time_s


def test_a_single_edit_goes_too_and_those_said_since_stay_where_they_are():
    t = np.array([1000.0, 0, 0])
    moved = of_file(t=t)
    old, new = anchored(Erase("A", 81, 84), of_file(), None, ""), anchored(Erase("C", 21, 30), moved, None, "")
    edited = replay(moved, entries(old, new))
    assert outcomes(edited) == ["held", "held"] and edited.applied[1].edit is new and not edited.applied[1].reason


def test_edits_of_somebody_who_stands_still_go_too_though_two_names_were_exchanged_since():
    """The places of one marker do not tell how the file was turned; those of all do."""
    given = of_file(change=lambda xyz: xyz[:1] + np.random.default_rng(2).normal(0, 0.2, xyz.shape))
    said = entries(*(anchored(Erase(name, 41, 44), given, None, "") for name in "ABCDEF"))
    t = np.array([0, 900.0, 0])
    moved = (MarkerTrajectory.measured(n, given[m].xyz @ TURNED.T + t) for n, m in zip("ABCDEF", "BACDEF", strict=True))
    edited = replay(replace(given, paths=tuple(moved)), said)
    assert [(one.outcome, one.edit.marker) for one in edited.applied] == [("held", n) for n in "BACDEF"]


@pytest.mark.parametrize(
    "again",
    [
        of_file(seed=5),
        of_file(change=lambda xyz: xyz * 1.1),
        of_file(change=lambda xyz: xyz * [1, -1, 1] + 500.0),
        of_file(change=lambda xyz: xyz[30:] + 500.0),
    ],
    ids=["another recording", "another scale", "mirrored", "moved and numbered from another frame"],
)
def test_nothing_is_carried_over_where_no_move_explains_it(again):
    edited = replay(again, said_of(of_file()))
    assert set(outcomes(edited)) <= {"orphan", "held"} and outcomes(edited)[:5] == ["orphan"] * 5
    assert same(edited.trajectories, again)


def test_a_move_that_explains_only_a_few_of_the_lost_edits_is_none():
    """A alone was moved, as one marker that slipped: what was said of all others stays lost."""
    paths = [path.xyz.copy() for path in of_file(seed=5)]
    paths[0] = of_file()["A"].xyz + 300.0
    again = replace(
        of_file(), paths=tuple(MarkerTrajectory.measured(n, x) for n, x in zip("ABCDEF", paths, strict=True))
    )
    assert outcomes(replay(again, said_of(of_file())))[:5] == ["orphan"] * 5


def test_edits_that_find_their_samples_are_the_same_values():
    given = of_file()
    said = [edit for entry in said_of(given) for edit in entry.edits]
    found = carried_over(said, given, Footage(1, given.rate))
    assert all(a is b for a, b in zip(found, said, strict=True))


def alike(paths, t=0.0):
    """Three markers of one body that does not turn, by the ways (F, 3) mm that each goes."""
    places = np.array([[0, 0, 1000.0], [250, 0, 1010], [125, 180, 1030]])
    xyz = (place + way + t for place, way in zip(places, paths, strict=True))
    return replace(of_file(), paths=tuple(MarkerTrajectory.measured(n, one) for n, one in zip("ABC", xyz, strict=True)))


def sledge(t=0.0):
    s = np.linspace(0, 1, 200)
    return alike([np.column_stack([800 * s, 150 * np.sin(6 * s), 0 * s])] * 3, t)


def standing(seed, t=0.0):
    """Somebody who stands still: a plate of markers that sways by a mm."""
    rng = np.random.default_rng(seed)
    return alike(np.cumsum(rng.normal(0, 0.05, (200, 3)), 0) + rng.normal(0, 0.05, (3, 200, 3)), t)


def test_where_all_markers_move_alike_an_edit_goes_to_its_name_s_and_a_claim_nowhere():
    moved = sledge(t=np.array([900.0, 200, 0]))
    erased = anchored(Erase("C", 41, 44), sledge(), None, "")
    (one,) = replay(moved, entries(erased)).applied
    assert (one.outcome, one.edit.marker) == ("held", "C")
    claimed = Claim(stretch_of(sledge(), "C", at=60), "LKNE")
    assert outcomes(replay(moved, entries(claimed))) == ["orphan"], "it would be of A, B or C"


def test_edits_of_somebody_who_stands_still_do_not_go_to_another_recording():
    said = entries(*(anchored(Erase(name, 41, 44), standing(1), None, "") for name in "ABC"))
    t = np.array([300.0, 200, 0])
    assert outcomes(replay(standing(1, t), said)) == ["held"] * 3
    assert outcomes(replay(standing(2, t), said)) == ["orphan"] * 3
