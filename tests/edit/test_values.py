"""Edits of values: places, gaps, images, ends and events."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from kinemark.data import MarkerTrajectory, Origin
from kinemark.data.edits import (
    SMOOTHING,
    AddEvent,
    DropUnnamed,
    Erase,
    GapChoice,
    ImagePoint,
    Put,
    Smooth,
    Stretch,
    Trim,
    Undo,
    Verdict,
    Witness,
)
from kinemark.edit import cropped, replay, stretch_of
from kinemark.fill import Quintic, fill
from kinemark.geometry import project
from support.edited import entries, paths_without_images, samples, scene


@pytest.fixture
def named():
    """Markers A and B, named, and two without names, which begin at frame 11."""
    whole = paths_without_images(first_frame=11)
    return replace(whole, paths=tuple(replace(p, name=n) for p, n in zip(whole, ("A", "B", "*3", "*4"), strict=True)))


def outcome(trajectories, *said, **other):
    edited = replay(trajectories, entries(*said), **other)
    return edited, [one.outcome for one in edited.applied]


def test_erased_samples_are_missing_and_nothing_else_changes(named):
    edited, outcomes = outcome(named, Erase("A", 21, 30))
    a = edited.trajectories["A"]
    assert outcomes == ["held"] and np.flatnonzero(a.origin == Origin.MISSING).tolist() == list(range(10, 20))
    assert edited.trajectories["B"] is named["B"] and np.array_equal(a.xyz[20:], named["A"].xyz[20:])
    assert outcome(named, Erase("A", 21, 30), Erase("A", 22, 25))[1] == ["held", "moot"]
    assert outcome(named, Erase("A", 900, 950))[1] == ["moot"]
    assert outcome(named, Erase("C", 21, 30))[1] == ["orphan"]


def test_a_place_put_by_hand_is_a_sample_with_its_deviation_and_fillers_see_it(named):
    true = named["A"].xyz[50]
    put = Put("A", 61, tuple((true + 5).tolist()), 2.0)
    edited, outcomes = outcome(named, Erase("A", 51, 71), put)
    a = edited.trajectories["A"]
    assert outcomes == ["held", "held"] and a.origin[50] == Origin.EDITED
    assert np.allclose(a.xyz[50], true + 5) and np.allclose(a.cov[50], 4 * np.eye(3))
    assert a.gaps == [(40, 50), (51, 61)]
    assert outcome(named, put, replace(put, sd_mm=1.0))[1] == ["overruled", "held"]


def test_a_place_said_in_another_world_is_worked_out_from_its_images_or_is_an_orphan():
    rig, detections, tracks, world = scene()
    marked = replace(tracks, paths=(replace(tracks.paths[0], name="A"), *tracks.paths[1:]))
    place = tracks.paths[0].xyz[30]
    images = tuple((c.name, *project(c, place[None])[0].tolist()) for c in rig)
    there = {"detections": detections, "rig": rig, "world": world}
    edited, outcomes = outcome(marked, Put("A", 31, (0.0, 0.0, 0.0), 1.0, images, "another"), **there)
    assert outcomes == ["held"] and np.abs(edited.trajectories["A"].xyz[30] - place).max() < 1e-6
    edited, outcomes = outcome(marked, Put("A", 31, (0.0, 0.0, 0.0), 1.0, images[:1], "another"), **there)
    assert outcomes == ["orphan"] and edited.trajectories["A"] is marked["A"]


def test_a_place_by_two_images_is_thin_where_their_cameras_say_something_else_now():
    rig, detections, tracks, _ = scene()
    marked = replace(tracks, paths=(replace(tracks.paths[0], name="A"), *tracks.paths[1:]))
    images = tuple((c.name, *project(c, tracks.paths[0].xyz[30][None])[0].tolist()) for c in rig)
    turned = Rotation.from_rotvec([0.004, 0.0, 0.0]).as_matrix() @ rig[0].R
    other = replace(rig, cameras=(replace(rig[0], R=turned), *rig.cameras[1:]))
    for of, some, said in ((rig, images[:2], "held"), (other, images[:2], "thin"), (other, images, "held")):
        put = Put("A", 31, (0.0, 0.0, 0.0), 1.0, some, "another")
        assert outcome(marked, put, detections=detections, rig=of, world="now")[1] == [said]


def test_a_corrected_image_moves_the_sample_to_where_the_images_say():
    rig, detections, tracks, world = scene()
    marked = replace(tracks, paths=(replace(tracks.paths[0], name="A"), *tracks.paths[1:]))
    there = {"detections": detections, "rig": rig, "world": world}
    other = tracks.paths[0].xyz[30] + [30.0, 0.0, 0.0]
    clicked = [ImagePoint(c.name, 31, *project(c, other[None])[0].tolist(), "A") for c in rig]
    edited, outcomes = outcome(marked, *clicked, **there)
    assert outcomes == ["held"] * len(rig)
    assert np.abs(edited.trajectories["A"].xyz[30] - other).max() < 0.01
    assert (edited.trajectories["A"].detection[30] == -1).all()


def test_the_first_of_two_images_of_a_missing_marker_is_an_orphan_until_the_second_is_there():
    rig, detections, tracks, world = scene()
    there = {"detections": detections, "rig": rig, "world": world}
    place, gone = tracks.paths[0].xyz[30], np.arange(tracks.n_frames) != 30
    marked = replace(tracks, paths=(replace(tracks.paths[0].only(gone), name="A"), *tracks.paths[1:]))
    first, second = (ImagePoint(c.name, 31, *project(c, place[None])[0].tolist(), "A") for c in rig.cameras[:2])
    elsewhere = replace(second, frame=32)
    assert outcome(marked, first, **there)[1] == ["orphan"]
    assert outcome(marked, first, elsewhere, **there)[1] == ["orphan", "held"]
    edited, outcomes = outcome(marked, first, second, **there)
    assert outcomes == ["held", "held"] and np.abs(edited.trajectories["A"].xyz[30] - place).max() < 0.01
    assert outcome(marked, first, **there)[1] == ["orphan"], "as before, when the second is undone"


def test_an_image_that_is_no_markers_is_taken_from_the_sample_that_has_it():
    rig, detections, tracks, world = scene()
    there = {"detections": detections, "rig": rig, "world": world}
    path = tracks.paths[0]
    f = int(np.flatnonzero((path.detection >= 0).all(1))[0])
    u, v = detections.uv[path.detection[f, 0]].tolist()
    edited, outcomes = outcome(tracks, ImagePoint(rig.names[0], f + 1, u, v, None), **there)
    after = edited.trajectories.paths[0]
    assert outcomes == ["held"] and after.detection[f, 0] == -1 and (after.detection[f, 1:] >= 0).all()
    assert 0 < np.linalg.norm(after.xyz[f] - path.xyz[f]) < 2
    left = [ImagePoint(c.name, f + 1, *detections.uv[path.detection[f, k]].tolist(), None) for k, c in enumerate(rig)]
    gone, outcomes = outcome(tracks, *left[:3], **there)
    assert outcomes == ["held"] * 3 and gone.trajectories.paths[0].origin[f] == Origin.MISSING
    assert outcome(tracks, ImagePoint(rig.names[0], f + 1, 3.0, 3.0, None), **there)[1] == ["moot"]


def test_a_smoothed_stretch_loses_noise_and_keeps_the_motion(named):
    noisy = named["A"].xyz + np.random.default_rng(0).normal(0, 1, (200, 3))
    rough = replace(named, paths=(MarkerTrajectory.measured("A", noisy), *named.paths[1:]))
    edited, outcomes = outcome(rough, Smooth("A", 61, 160, 6.0))
    after, off = edited.trajectories["A"], noisy - named["A"].xyz
    assert outcomes == ["held"] and set(np.flatnonzero(after.origin == Origin.EDITED)) == set(range(50, 150))
    assert np.std((after.xyz - named["A"].xyz)[60:140]) < 0.5 * np.std(off[60:140])
    assert np.array_equal(after.xyz[:50], noisy[:50])
    assert outcome(named, Smooth("A", 61, 160, 80.0))[1] == ["orphan"], "above half the rate"


@pytest.mark.parametrize("function", SMOOTHING)
def test_a_stretch_is_smoothed_by_the_function_that_is_chosen(named, function):
    """Each leaves the slow motion, takes noise away, and of a wave at the cut-off leaves 1/√2."""
    noisy = named["A"].xyz + np.random.default_rng(0).normal(0, 1, (200, 3))
    rough = replace(named, paths=(MarkerTrajectory.measured("A", noisy), *named.paths[1:]))
    edited, outcomes = outcome(rough, Smooth("A", 61, 160, 6.0, "smooth", function))
    after = edited.trajectories["A"].xyz
    assert outcomes == ["held"] and np.array_equal(after[:50], noisy[:50]) and np.array_equal(after[150:], noisy[150:])
    assert np.std((after - named["A"].xyz)[60:140]) < 0.55 * np.std((noisy - named["A"].xyz)[60:140])
    wave = np.sin(2 * np.pi * 6.0 * np.arange(200) / named.rate)[:, None] * np.ones(3)
    whole = replace(named, paths=(MarkerTrajectory.measured("A", 1e6 + wave), *named.paths[1:]))
    edited, _ = outcome(whole, Smooth("A", 11, 210, 6.0, "smooth", function))
    left = np.std(edited.trajectories["A"].xyz[60:140] - 1e6) / np.std(wave[60:140])
    assert left == pytest.approx(0.5**0.5, abs=0.06)


def test_choices_for_gaps_are_honoured_and_leave_other_gaps_as_they_were(named):
    broken = outcome(named, Erase("A", 51, 60), Erase("A", 101, 140), Erase("B", 51, 60))[0].trajectories
    usual = fill(broken, method=Quintic(), limit_mm=1e-3)
    assert not any(gap.method for gap in usual.gaps)
    edited, outcomes = outcome(
        broken, GapChoice("A", 55, 55, "linear"), GapChoice("B", 1, 500, "best"), GapChoice("B", 1, 40, "best")
    )
    assert outcomes == ["held", "held", "moot"]
    filled = fill(broken, method=Quintic(), limit_mm=1e-3, choices=edited.choices)
    states = {(gap.marker, gap.start): (gap.method, gap.state) for gap in filled.gaps}
    assert states["A", 40][0] == "linear" and states["A", 90] == ("", "above_limit") and states["B", 40][0] == "quintic"
    line = np.linspace(broken["A"].xyz[39], broken["A"].xyz[50], 12)[1:-1]
    assert np.allclose(filled.trajectories["A"].xyz[40:50], line)
    free = fill(broken, method=Quintic())
    left = fill(broken, method=Quintic(), choices=[GapChoice("A", 51, 60, "open")])
    assert [g.state for g in left.gaps if (g.marker, g.start) == ("A", 40)] == ["left_open"]
    assert (left.trajectories["A"].origin[40:50] == Origin.MISSING).all()
    assert np.array_equal(left.trajectories["A"].xyz[90:130], free.trajectories["A"].xyz[90:130])
    with pytest.raises(ValueError, match="no method of filling"):
        fill(broken, choices=[GapChoice("A", 51, 60, "magic")])


def test_what_comes_last_is_trimmed_and_the_unnamed_dropped(named):
    edited, outcomes = outcome(named, Trim(21, 60), Trim(31, 50), DropUnnamed(), AddEvent("Foot Strike", "Left", 0.3))
    assert outcomes == ["overruled", "held", "held", "held"]
    left = cropped(edited.trajectories, edited)
    assert left.names == ("A", "B") and (left.first_frame, left.n_frames) == (31, 20)
    assert np.array_equal(left["A"].xyz, named["A"].xyz[20:40]) and edited.events[0].label == "Foot Strike"
    assert outcome(named, Trim(900, 950))[1] == ["orphan"] and cropped(named, replay(named, [])) is named


def test_a_verdict_finds_its_tracks_again():
    rig, detections, tracks, world = scene()
    where = tuple(stretch_of(tracks, n, first=20, last=40, detections=detections, world=world) for n in ("*2", "*4"))
    order = (3, 2, 1, 0, 4)
    again = replace(tracks, paths=tuple(replace(tracks.paths[k], name=f"*{i + 1}") for i, k in enumerate(order)))
    edited, outcomes = outcome(again, Verdict("swap", where, True), detections=detections, rig=rig, world=world)
    assert outcomes == ["held"] and edited.reviewed[0].paths == (0, 2) and edited.reviewed[0].first == 19
    nowhere = Stretch(20, 40, (Witness(20, (9e4, 0.0, 0.0)),), world)
    assert outcome(tracks, Verdict("swap", (nowhere,), True), world=world)[1] == ["orphan"]


def test_undone_values_leave_no_trace(named):
    edited = replay(named, entries(Erase("A", 21, 30), Put("A", 25, (0.0, 0.0, 0.0), 1.0), Undo(1), Undo(2)))
    assert edited.trajectories is named and samples(edited.trajectories).keys() == samples(named).keys()
