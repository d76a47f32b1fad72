"""Edits of samples have witnesses: they are not applied to what is called so, or numbered so, by now."""

from dataclasses import replace

import numpy as np
import pytest

from kinemark.data import MarkerTrajectory, Origin, same
from kinemark.data.edits import AddEvent, Claim, Erase, GapChoice, ImagePoint, Put, Smooth, Trim
from kinemark.edit import anchored, replay, stretch_of
from kinemark.geometry import project
from support.edited import entries, paths_without_images, scene

NAMES = "ABCD"


def of_file(change=lambda xyz: xyz, names=NAMES, **other):
    """Markers of a file, A with a spike in frames 81 to 84 and B with a gap in frames 101 to 120, changed somehow."""
    given = paths_without_images()
    paths = [path.xyz.copy() for path in given]
    paths[0][80:84] += 80.0
    paths[1][100:120] = np.nan
    changed = (MarkerTrajectory.measured(name, change(xyz)) for name, xyz in zip(names, paths, strict=True))
    return replace(given, paths=tuple(changed), **other)


def said_of(trajectories, detections=None, world=""):
    """One edit of each kind, with its witnesses."""
    place = tuple(trajectories["B"].xyz[100 - 1].tolist())
    some = Erase("A", 81, 84), Put("B", 101, place, 1.0), GapChoice("B", 101, 120, "open"), Smooth("C", 20, 80, 6.0)
    return [anchored(edit, trajectories, detections, world) for edit in some]


def outcomes(trajectories, said, **other):
    return [one.outcome for one in replay(trajectories, entries(*said), **other).applied]


@pytest.mark.parametrize(
    "again",
    [
        of_file(),
        of_file(lambda xyz: xyz + np.random.default_rng(1).normal(0, 3, xyz.shape)),
        of_file(lambda xyz: xyz[15:], first_frame=16),
        of_file(lambda xyz: xyz, names="ABCE"),
    ],
    ids=["same", "noisier", "cropped", "another marker renamed"],
)
def test_edits_of_samples_hold_where_these_are_what_they_were(again):
    assert outcomes(again, said_of(of_file())) == ["held"] * 4


@pytest.mark.parametrize(
    "again",
    [
        of_file(lambda xyz: xyz[30:]),
        of_file(lambda xyz: np.repeat(xyz, 3, axis=0), rate=300.0),
        of_file(lambda xyz: xyz / 1000.0),
    ],
    ids=["numbered from another frame", "another rate", "another unit"],
)
def test_what_is_elsewhere_now_is_not_erased_put_or_smoothed_and_this_is_said(again):
    edited = replay(again, entries(*said_of(of_file())))
    assert [one.outcome for one in edited.applied] == ["orphan"] * 4
    assert same(edited.trajectories, again) and not edited.choices
    assert all("elsewhere" in one.reason for one in edited.applied)


def test_good_samples_that_came_in_the_place_of_erased_ones_stay():
    whole = replace(of_file(), paths=(replace(paths_without_images().paths[0], name="A"), *of_file().paths[1:]))
    edited = replay(whole, entries(said_of(of_file())[0]))
    assert [one.outcome for one in edited.applied] == ["orphan"] and edited.trajectories is whole


def test_a_trim_and_an_event_are_of_their_moment_whatever_its_number_is_by_now():
    given = of_file()
    said = [anchored(edit, given, None, "") for edit in (Trim(41, 160), AddEvent("Foot Strike", "Left", 0.5))]
    assert all(len(edit.where.witnesses) == 4 for edit in said)
    for again in (given, of_file(lambda xyz: xyz[45:], first_frame=46), of_file(names="BADC")):
        assert outcomes(again, said) == ["held", "held"]
    assert outcomes(of_file(lambda xyz: xyz[70:100], first_frame=71), said[:1]) == ["held"], "no end of it is there"
    edited = replay(of_file(lambda xyz: xyz[30:]), entries(*said))
    assert [one.outcome for one in edited.applied] == ["orphan", "orphan"]
    assert edited.kept == (0, 170) and not edited.events


@pytest.mark.parametrize("rate", [50.0, 120.0, 250.0])
def test_an_event_is_at_its_time_at_another_rate(rate):
    said = anchored(AddEvent("Foot Strike", "Left", 0.5), of_file(), None, "")
    again = paths_without_images(frames=round(2 * rate), rate=rate)
    edited = replay(again, entries(said))
    assert [one.outcome for one in edited.applied] == ["held"] and edited.events[0].time_s == 0.5
    late = replace(again, paths=tuple(replace(p, xyz=np.roll(p.xyz, round(rate / 4), axis=0)) for p in again))
    assert [one.outcome for one in replay(late, entries(said)).applied] == ["orphan"]


def test_an_event_stays_in_its_frame_where_the_rate_was_wrong():
    said = anchored(AddEvent("Foot Strike", "Left", 0.5), of_file(), None, "")
    edited = replay(of_file(rate=120.0), entries(said))
    assert [one.outcome for one in edited.applied] == ["held"] and np.isclose(edited.events[0].time_s, 50 / 120)


def test_an_edit_most_of_whose_samples_are_elsewhere_is_thin():
    erased, again = anchored(Erase("C", 41, 80), of_file(), None, ""), of_file()
    xyz = again["C"].xyz.copy()
    xyz[50:] += 100.0
    again = replace(again, paths=tuple(MarkerTrajectory.measured("C", xyz) if p.name == "C" else p for p in again))
    edited = replay(again, entries(erased))
    assert [(one.outcome, one.samples) for one in edited.applied] == [("thin", 40)]
    assert (edited.trajectories["C"].origin[40:80] == Origin.MISSING).all()


def test_edits_go_with_their_samples_to_the_names_that_these_have_now():
    edited = replay(of_file(names="BADC"), entries(*said_of(of_file())))
    assert [(one.outcome, one.edit.marker) for one in edited.applied] == [("held", name) for name in "BAAD"]
    assert [choice.marker for choice in edited.choices] == ["A"]
    assert edited.applied[0].reason == "the samples of A are called B now"
    assert (edited.trajectories["B"].origin == Origin.MISSING).nonzero()[0].tolist() == [80, 81, 82, 83]


@pytest.mark.parametrize(("a", "b"), ["AB", "AE"], ids=["exchanged", "renamed"])
def test_an_edit_does_not_go_over_to_the_marker_that_has_the_name_since(a, b):
    given = of_file()
    erase = anchored(Erase("A", 81, 84), given, None, "")
    claims = tuple(Claim(stretch_of(given, x, first=61), y) for x, y in (a + b, b + a) if x in given.names)
    edited = replay(given, entries(erase, claims))
    assert {one.outcome for one in edited.applied} == {"held"} and edited.applied[0].edit.marker == b
    assert (edited.trajectories[b].origin[80:84] == Origin.MISSING).all()


def test_a_place_stays_with_its_marker_where_a_tracker_exchanged_two_for_some_frames():
    given = of_file()
    put = anchored(Put("B", 101, tuple(given["B"].xyz[99].tolist()), 1.0), given, None, "")
    paths = {path.name: path.xyz.copy() for path in given}
    for at in (slice(90, 100), slice(120, 130)):
        paths["B"][at], paths["D"][at] = paths["D"][at].copy(), paths["B"][at].copy()
    again = replace(given, paths=tuple(MarkerTrajectory.measured(name, xyz) for name, xyz in paths.items()))
    assert replay(again, entries(put)).applied[0].edit.marker == "B"


def test_samples_erased_as_they_were_another_marker_s_stay_with_that_one():
    """A jumps onto B's path in frames 76 to 90, and what is B's is erased; then the two are exchanged there."""
    given = of_file()
    erase = anchored(Erase("A", 81, 84), given, None, "")
    claims = tuple(Claim(stretch_of(given, x, first=76, last=90), y) for x, y in ("AB", "BA"))
    edited = replay(given, entries(erase, claims))
    assert [one.outcome for one in edited.applied] == ["orphan", "held", "held"]
    assert (edited.trajectories["B"].origin[75:90] != Origin.MISSING).all()


def test_a_place_that_is_on_the_path_now_stands_though_the_samples_beside_it_were_wrong():
    given = of_file()
    wrong = given["C"].xyz.copy()
    wrong[40:60] += 100.0
    seen = replace(given, paths=tuple(MarkerTrajectory.measured("C", wrong) if p.name == "C" else p for p in given))
    put = anchored(Put("C", 51, tuple(given["C"].xyz[50].tolist()), 1.0), seen, None, "")
    assert outcomes(seen, [put]) == outcomes(given, [put]) == ["held"]
    renamed = of_file(names="ABDC")
    assert replay(renamed, entries(put)).applied[0].edit.marker == "D"
    assert outcomes(renamed, [replace(put, whose=None)]) == ["orphan"]


def test_a_method_chosen_for_a_gap_that_is_far_longer_now_is_thin():
    given, longer = of_file(), of_file()
    xyz = longer["B"].xyz.copy()
    xyz[90:150] = np.nan
    longer = replace(longer, paths=tuple(MarkerTrajectory.measured("B", xyz) if p.name == "B" else p for p in longer))
    for method, outcome in (("best", "thin"), ("open", "held")):
        choice = anchored(GapChoice("B", 101, 120, method), given, None, "")
        assert outcomes(given, [choice]) == ["held"] and outcomes(longer, [choice]) == [outcome]


def test_images_find_samples_again_in_another_world():
    rig, detections, tracks, world = scene()
    named = replace(tracks, paths=tuple(replace(p, name=n) for p, n in zip(tracks, "ABCDE", strict=True)))
    erase = anchored(Erase("A", 31, 40), named, detections, world)
    moved = replace(named, paths=tuple(replace(p, xyz=p.xyz + 1000.0) for p in named))
    assert len(erase.where.witnesses) == 4 and all(len(w.images) > 1 for w in erase.where.witnesses)
    assert outcomes(moved, [erase], detections=detections, rig=rig, world="another") == ["held"]
    other = replace(moved, paths=tuple(replace(p, name=n) for p, n in zip(moved, "BACDE", strict=True)))
    edited = replay(other, entries(erase), detections=detections, rig=rig, world="another")
    assert [(one.outcome, one.edit.marker) for one in edited.applied] == [("held", "B")]


def named_scene(names="ABCDE"):
    tracks = scene()[2]
    return replace(tracks, paths=tuple(replace(p, name=n) for p, n in zip(tracks, names, strict=True)))


def clicked(trajectories, marker, frame=31, camera=0):
    """An image of a marker by hand, 2 px from where it was found, with its witnesses."""
    rig, detections, _, world = scene()
    u, v = project(rig.cameras[camera], trajectories[marker].xyz[frame - 1][None])[0].tolist()
    return anchored(ImagePoint(rig.names[camera], frame, u + 2.0, v, marker), trajectories, detections, world)


def test_an_image_by_hand_goes_with_its_marker_and_is_not_given_to_another_one():
    rig, detections, _, world = scene()
    behind = {"detections": detections, "rig": rig, "world": world}
    given, said = named_scene(), clicked(named_scene(), "A")
    assert len(said.where.witnesses) == len(said.whose.witnesses) == 4
    assert outcomes(given, [said], **behind) == ["held"]
    edited = replay(named_scene("BACDE"), entries(said), **behind)
    assert [(one.outcome, one.edit.marker) for one in edited.applied] == [("held", "B")]
    assert (
        edited.trajectories["A"] is edited.trajectories.paths[1]
        and edited.trajectories["B"].origin[30] == Origin.EDITED
    )
    elsewhere = replace(given, paths=(replace(given["B"], name="A"), *given.paths[2:]))
    found = replay(elsewhere, entries(said), **behind)
    assert [one.outcome for one in found.applied] == ["orphan"] and found.trajectories is elsewhere


def test_an_image_that_shows_the_marker_now_stands_though_the_samples_beside_it_were_wrong():
    rig, detections, _, world = scene()
    given = named_scene()
    wrong = given["A"].xyz.copy()
    wrong[20:45] += 300.0
    seen = replace(given, paths=(MarkerTrajectory.measured("A", wrong), *given.paths[1:]))
    u, v = project(rig.cameras[0], given["A"].xyz[30][None])[0].tolist()
    said = anchored(ImagePoint(rig.names[0], 31, u, v, "A"), seen, None, world)
    assert outcomes(given, [said], detections=detections, rig=rig, world=world) == ["held"]
    off = replace(said, u=u + 200.0)
    assert outcomes(given, [off], detections=detections, rig=rig, world=world) == ["orphan"]


def test_an_image_that_is_no_marker_s_needs_no_witness():
    said = ImagePoint(scene()[0].names[0], 31, 3.0, 3.0, None)
    assert anchored(said, named_scene(), scene()[1], scene()[3]) is said


def test_what_nobody_saw_has_no_witness_and_stands_as_in_older_journals():
    given = of_file()
    for edit in (Erase("A", 900, 950), Erase("no such", 1, 5), Claim(stretch_of(given, "A"), "E")):
        assert anchored(edit, given, None, "") is edit
    assert outcomes(of_file(names="BADC"), [Erase("A", 81, 84)]) == ["held"]


def test_whose_an_edit_is_follows_later_claims_where_nobody_had_most_of_its_samples_before():
    given = of_file()
    erase = anchored(Erase("A", 81, 84), given, None, "")
    first, second, _, fourth = (w.frame for w in erase.whose.witnesses)
    parts = tuple(
        Claim(stretch_of(given, "A", first=a, last=b), name)
        for name, a, b in (("X", first + 5, second + 5), ("Y", second + 6, fourth))
    )
    said = entries(erase, parts)
    before = replay(given, said)
    assert before.applied[0].edit.marker == "A", "one of its four samples is A's, one X's, two Y's"
    joined = Claim(stretch_of(before.trajectories, "X", first=first + 5, last=second + 5), "Y")
    after = replay(given, [*said, *entries(joined, first=3)])
    assert after.applied[0].edit.marker == "Y"
    assert replay(given, said).applied[0].edit.marker == "A", "as it was, where the claim is undone"


@pytest.mark.parametrize("rate", [0.0, -100.0, np.nan, np.inf])
def test_an_event_is_at_no_such_rate(rate):
    with pytest.raises(ValueError, match="wanted above 0"):
        AddEvent("Foot Strike", "Left", 0.5, rate=rate)
