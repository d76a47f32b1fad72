"""The angle model in the tracking loop knows its markers by their lengths and directions, not by their order."""

from types import SimpleNamespace

import numpy as np
import pytest

from kinemark.data import KinemarkError
from kinemark.engine import tracking_stage
from kinemark.engine.tracking_stage import with_angle_model
from kinemark.fill import MarkerArray, fit_model
from kinemark.fill.methods.angles import LimbAngles
from kinemark.io.angle_model_csv import write_angle_model
from kinemark.report.words.trial import TRIAL_WORDS
from kinemark.synth import elbow_flexion, ring
from kinemark.track.swamidas import Constraint, Swamidas, diagnose_model, follow_points
from support.clouds import cloud_and_markers


def model():
    """Of the third motion, made of another recording than the one that is tracked."""
    other = elbow_flexion(duration_s=8.0, seed=5)
    links = (("B", "D"), ("C", "B"))
    return fit_model(MarkerArray(other.xyz, other.rate, other.names), method=LimbAngles(links=links)).model


def hidden(order):
    """A cloud of the markers in this order, D and B hidden for two seconds, and the marker of each point."""
    subject = elbow_flexion(duration_s=6.0, seed=9)
    xyz = subject.xyz[np.array(order)]
    seen = np.ones(xyz.shape[:2], bool)
    seen[np.isin(order, (0, 1)), 40:100] = False
    return cloud_and_markers(xyz, seen, rate=subject.rate)


@pytest.mark.parametrize("order", [(0, 1, 2), (2, 0, 1), (1, 2, 0)])
def test_two_markers_that_come_back_at_once_are_told_apart_in_whatever_order_tracks_begin(order):
    cloud, marker = hidden(order)
    followed = follow_points(cloud, method=Swamidas(model=model()))
    np.testing.assert_array_equal(followed.tracks.id, marker)
    assert (followed.by == Constraint.MODEL).sum() == 2


def test_backwards_the_model_is_of_the_motion_reversed():
    cloud, marker = hidden((0, 1, 2))
    with_model = follow_points(cloud, method=Swamidas(model=model(), direction="backward"))
    np.testing.assert_array_equal(with_model.tracks.id, marker)
    assert (with_model.by == Constraint.MODEL).sum() == 2
    own = model()
    np.testing.assert_array_equal(own.reversed().reversed().direction, own.direction)


def test_with_a_model_predictions_meet_where_the_predictor_alone_is_lost():
    """Two markers hidden for two seconds: by both ends of the gap alone they are exchanged, with the model not, and
    each half of a gap is what that pass expects of it."""
    cloud, marker = hidden((0, 1, 2))
    alone = follow_points(cloud, method=Swamidas(direction="meeting"))
    assert (alone.tracks.id != marker).any()
    for own in (Swamidas(model=model(), direction="meeting"), Swamidas(angle_model="own", direction="meeting")):
        met = follow_points(cloud, method=own)
        np.testing.assert_array_equal(met.tracks.id, marker)
        assert (met.by == Constraint.MEETING).sum() == 2 and not [*diagnose_model(met.model)]
    guided = {d: follow_points(cloud, method=Swamidas(model=model(), direction=d)) for d in ("forward", "backward")}
    met = follow_points(cloud, method=Swamidas(model=model(), direction="meeting"))
    for k in (0, 1):
        back = next(i for i in range(3) if set(guided["backward"].tracks.id[marker == k]) == {i})
        np.testing.assert_allclose(met.path(k)[40:69], guided["forward"].path(k)[40:69])
        np.testing.assert_allclose(met.path(k)[71:100], guided["backward"].path(back)[71:100])


def test_a_model_that_knows_none_of_the_markers_leaves_the_meeting_as_it_is():
    cloud, _ = hidden((0, 1, 2))
    strange = follow_points(cloud, method=Swamidas(model=model().turned(90.0), direction="meeting"))
    plain = follow_points(cloud, method=Swamidas(direction="meeting"))
    np.testing.assert_array_equal(strange.tracks.id, plain.tracks.id)
    assert [one.values["why"] for one in diagnose_model(strange.model)] == ["unrecognised"]


def test_a_file_of_a_model_is_read_for_the_session_and_its_absence_is_said(tmp_path):
    write_angle_model(tmp_path / "arm.csv", model())
    read = with_angle_model(Swamidas(angle_model="arm.csv"), tmp_path)
    cloud, marker = hidden((0, 1, 2))
    np.testing.assert_array_equal(follow_points(cloud, method=read).tracks.id, marker)
    with pytest.raises(ValueError, match=r"arm\.csv, which was not read"):
        follow_points(cloud, method=Swamidas(angle_model="arm.csv"))
    with pytest.raises((KinemarkError, OSError)):
        with_angle_model(Swamidas(angle_model="absent.csv"), tmp_path)


def arm_hidden(*markers, turned=0.0):
    """What was found of the third motion's model, turned about the vertical, with these markers hidden for a second."""
    subject = elbow_flexion(duration_s=5.0, seed=9)
    seen = np.ones(subject.xyz.shape[:2], bool)
    seen[list(markers), 40:70] = False
    cloud, _ = cloud_and_markers(subject.xyz, seen, rate=subject.rate)
    return [*diagnose_model(follow_points(cloud, method=Swamidas(model=model().turned(turned))).model)]


def test_a_model_that_corrects_nothing_is_a_finding_and_says_why():
    assert [*diagnose_model(None)] == arm_hidden(0) == []
    (unknown,), (alone,), (unneeded,) = arm_hidden(0, turned=90.0), arm_hidden(0, 1, 2), arm_hidden()
    assert [one.severity for one in (unknown, alone, unneeded)] == ["amber", "amber", "info"]
    assert [one.values["why"] for one in (unknown, alone, unneeded)] == ["unrecognised", "no_neighbour", "not_needed"]
    assert alone.values["missing"] == 90
    text, advice = TRIAL_WORDS["angle_model_unused"].of(unknown)
    assert "not found among the tracks" in text and "leave angle_model out" in advice
    assert "in 90 frames" in TRIAL_WORDS["angle_model_unused"].of(alone)[0]


def test_the_stage_of_tracking_tells_of_a_model_that_was_not_used(monkeypatch):
    cloud, _ = hidden((0, 1, 2))
    monkeypatch.setattr(tracking_stage, "diagnose_tracks", lambda *_: [])
    monkeypatch.setattr(tracking_stage, "_outside", lambda *_: None)
    settings = SimpleNamespace(track=Swamidas(model=model().turned(90.0)))
    inputs = SimpleNamespace(settings=settings, source=SimpleNamespace(of=SimpleNamespace(root=None)), rig=ring(3))
    tracked = tracking_stage.from_points(inputs, {"reconstruct": cloud, "match": None, "detect": None})
    assert [found.kind for found in tracked.diagnostics] == ["angle_model_unused"]
