"""A marker set with a static trial, or with a height, names the markers of a subject who wears it."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
import scipy
from labelling import shredded

from kinemark.data import KinemarkError, MarkerTrajectory
from kinemark.io.marker_sets import marker_sets, read_marker_set
from kinemark.label import figure_template, label, static_template
from kinemark.label.anatomy import Anatomy
from kinemark.label.decided_sides import decided_sides
from kinemark.label.evidence import PairScore
from kinemark.label.from_set import by_figure_alone
from kinemark.label.held import stiffness_kept
from kinemark.label.side_pairs import mirrored
from kinemark.label.stretches import stretches_of
from support.named_sessions import walk as walker
from support.wearing import body_of, moving, standing

WORN = [name for name in marker_sets() if len(read_marker_set(name)) >= 4]


@cache
def subject(name, seed):
    worn = read_marker_set(name)
    body = body_of(worn, seed)
    return worn, standing(worn, body), moving(worn, body, seed + 20, duration_s=2.0)


@pytest.mark.parametrize("name", WORN)
def test_a_static_trial_and_the_set_name_all_markers_of_a_subject_who_wears_it(name):
    worn, still, walk = subject(name, 4)
    tracks, truth, _ = shredded(walk, 1, 2.0, 1)
    found = label(tracks, static_template(still, worn))
    assert found.refused is None
    assert {a for a, b in zip(found.names, truth, strict=True) if b is None and a is not None} == set()
    assert [a for a, b in zip(found.names, truth, strict=True) if b is not None] == [b for b in truth if b is not None]
    assert min(p for p, b in zip(found.probability, truth, strict=True) if b is not None) > 0.5


def test_legs_alone_are_named_by_the_static_trial_of_the_whole_body():
    """Head and trunk, which the trial does not have, come first in the search's own order, and lead it astray."""
    worn, still, walk = subject("plug-in-gait-full", 6)
    lower = [m for key, own in worn.segments.items() for m in own if key.endswith(("pelvis", "thigh", "shank", "foot"))]
    legs = walk.select([name for name in walk.names if name in lower])
    found = label(legs, static_template(still, worn))
    assert len(legs) == 16 and found.refused is None and found.names == legs.names


def test_segments_say_which_distances_a_static_trial_shows():
    worn, still, _ = subject("plug-in-gait-full", 4)
    found = static_template(still, worn)
    at = found.names.index
    same, apart = (at("LFHD"), at("RBHD")), (at("LWRA"), at("RANK"))
    doubt = np.hypot(found.spread, found.doubt)
    assert doubt[same] < 0.02 * found.distance[same] and doubt[apart] > 0.1 * found.distance[apart]
    assert len(found.handed) > 10
    for quad in found.handed.tolist():  # on one segment, or on two that meet
        there = {found.names[i] for i in quad}
        two = [{*worn.segments[a], *worn.segments[b]} for a, b in worn.joints.values()]
        assert any(there <= group for group in two)


def test_markers_of_the_static_trial_alone_are_not_looked_for():
    worn, still, walk = subject("plug-in-gait-lower", 4)
    assert "LKNM" in still.names and "LKNM" not in static_template(still, worn).names
    assert "LKNM" not in walk.names


def test_the_figure_alone_names_but_is_never_sure():
    worn, _, walk = subject("plug-in-gait-full", 4)
    found = by_figure_alone(label(walk, figure_template(worn, 1700.0)))
    right = np.mean([a == b for a, b in zip(found.names, walk.names, strict=True)])
    assert right > 0.8 and "sure" not in found.state and found.probability.max() <= 0.8


def test_the_height_scales_the_figure_whatever_the_subject():
    worn = read_marker_set("kiss-15")
    one, other = figure_template(worn, 1000.0), figure_template(worn, 1800.0)
    np.testing.assert_allclose(1.8 * one.distance, other.distance)
    np.testing.assert_allclose(1.8 * one.doubt, other.doubt)
    assert {tuple(quad) for quad in one.handed.tolist()} == {tuple(quad) for quad in other.handed.tolist()}


def test_what_cannot_be_a_template_is_said():
    with pytest.raises(KinemarkError, match="2 markers of wand have places"):
        figure_template(read_marker_set("wand"), 502.5)
    worn, _, walk = subject("plug-in-gait-full", 4)
    with pytest.raises(KinemarkError, match="0 of the 7 markers of um2as-7"):
        static_template(walk, read_marker_set("um2as-7"))
    with pytest.raises(ValueError, match="height_mm"):
        figure_template(worn, 0.0)


@pytest.mark.parametrize(
    ("worn", "other"),
    [
        ("isb-upper-limb", "kiss-15"),
        ("kiss-15", "plug-in-gait-full"),
        ("plug-in-gait-full", "isb-upper-limb"),
        ("rods", "kiss-15"),
    ],
)
def test_a_static_trial_of_another_set_is_refused(worn, other):
    _, still, _ = subject(worn, 4)
    _, _, walk = subject(other, 4)
    found = label(walk, static_template(still, read_marker_set(worn)))
    assert found.refused is not None and found.refused.kind == "labels_refused" and set(found.names) == {None}


def test_a_part_of_the_body_is_not_refused():
    worn, still, walk = subject("plug-in-gait-full", 4)
    legs = walk.select([n for n in walk.names if n.endswith(("ASI", "PSI", "THI", "KNE", "TIB", "ANK", "HEE", "TOE"))])
    found = label(legs, static_template(still, worn))
    assert found.refused is None and found.names == legs.names


def test_a_wrong_side_of_static_names_is_never_sure():
    """From this posture the best search begins with the legs exchanged and the pelvis turned a third about."""
    template = static_template(walker(7, speed=1.0, phase=0.3, seconds=0.4).trajectories, read_marker_set("kiss-15"))
    tracks, truth, _ = shredded(walker(1, phase=0.5).trajectories, 2, 1.0, 1)
    found = label(tracks, template)
    assert found.names == truth and found.undecided is None


def test_legs_exchanged_and_the_pelvis_turned_are_turned_back():
    template = static_template(walker(7, speed=1.0, phase=0.3, seconds=0.4).trajectories, read_marker_set("kiss-15"))
    trial = walker(1, phase=0.5).trajectories
    true = np.array([template.names.index(name) for name in trial.names])
    turned = {"RASI": "SACR", "SACR": "LASI", "LASI": "RASI"}
    other = mirrored(template.names)
    wrong = np.array(
        [template.names.index(turned[n]) if n in turned else other[template.names.index(n)] for n in trial.names]
    )
    sides = decided_sides(stretches_of(trial, template.size), wrong, template, PairScore.of_template(template))
    np.testing.assert_array_equal(sides.label, true)
    assert sides.finding is None


def test_feet_and_pelvis_tell_the_front_and_with_it_the_sides():
    trial = walker(1, phase=0.5).trajectories
    y, anatomy = np.moveaxis(trial.xyz, 1, 0), Anatomy.of(trial.names)
    rotated = y @ scipy.spatial.transform.Rotation.from_euler("xyz", [1.0, 2.0, 3.0]).as_matrix() + 500.0
    assert anatomy.agreement(y) > 1.5
    assert anatomy.agreement(rotated) == pytest.approx(anatomy.agreement(y))
    assert anatomy.agreement(y[:, mirrored(trial.names)]) < 0.5
    none = [name for name in trial.names if not name.endswith(("HEE", "TOE"))]
    assert Anatomy.of(none).agreement(np.moveaxis(trial.select(none).xyz, 1, 0)) == 0


@pytest.mark.parametrize("hand", [1, -1])
def test_elbow_wrist_and_hand_tell_the_two_markers_of_a_wrist_apart(hand):
    """From the elbow all three lie in one direction, yet the four are far from one plane."""
    worn, still, _ = subject("plug-in-gait-full", 4)
    elbow, one, two = (np.nanmedian(still[name].xyz, axis=0) for name in ("LELB", "LWRA", "LWRB"))
    out = np.cross(one - elbow, two - elbow)
    raised = still["LFIN"].xyz + hand * 60.0 * out / np.linalg.norm(out)
    paths = tuple(MarkerTrajectory.measured("LFIN", raised) if p.name == "LFIN" else p for p in still)
    template = static_template(replace(still, paths=paths), worn)
    at = [template.names.index(name) for name in ("LELB", "LWRA", "LWRB", "LFIN")]
    (k,) = (k for k, quad in enumerate(template.handed.tolist()) if set(quad) == set(at))
    order = [at.index(a) for a in template.handed[k].tolist()]
    assert template.sign[k] == hand * round(np.linalg.det(np.eye(4)[order]))


def test_quadruples_that_are_nearly_in_one_plane_from_every_corner_are_left_out():
    worn, still, _ = subject("plug-in-gait-full", 4)
    template = static_template(still, worn)
    at = np.stack([np.nanmedian(still[name].xyz, axis=0) for name in template.names])
    for quad in template.handed.tolist():
        best = 0.0
        for k in range(4):
            p, *others = at[np.roll(quad, k)]
            u, v, w = (one - p for one in others)
            best = max(best, abs(u @ np.cross(v, w)) / np.prod([np.linalg.norm(one) for one in (u, v, w)]))
        alone = any({template.names[i] for i in quad} <= {*markers} for markers in worn.segments.values())
        assert best > (0.1 if alone else 0.3)


def test_feet_that_stood_together_do_not_make_heels_unsure():
    """The other foot is the nearest that a static trial shows of a heel; what it tells of a walk is nothing."""
    still, walk = walker(7, speed=1.0, phase=0.3, seconds=0.4).trajectories, walker(9).trajectories
    feet = [side + name for side in "LR" for name in ("ANK", "HEE", "TOE")]
    apart = np.nanmedian(still["LHEE"].xyz - still["RHEE"].xyz, axis=0) - [0, 150, 0]
    moved = {name: still[name].xyz - 0.5 * apart * (1 if name[0] == "L" else -1) for name in feet}
    paths = tuple(MarkerTrajectory.measured(p.name, moved.get(p.name, p.xyz)) for p in still)
    template = static_template(replace(still, paths=paths), read_marker_set("kiss-15"))
    y = np.stack([walk[name].xyz[::10] for name in template.names], axis=1).astype(np.float32)
    pairs, heels = PairScore.of_template(template), [template.names.index(side + "HEE") for side in "LR"]
    assert stiffness_kept(y, pairs, template.keeps)[0][heels].min() > 0.75
    assert stiffness_kept(y, pairs, np.ones_like(template.keeps))[0][heels].max() < 0.7  # where all tell
    alone = np.where(np.isin(template.names, ["LASI", "RASI", "SACR", "LHEE", "RHEE"])[:, None], y, np.nan)
    assert (stiffness_kept(alone, pairs, template.keeps)[0][heels] == 0).all()  # of what tells nothing is seen
