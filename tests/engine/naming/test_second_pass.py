"""The second pass: markers that the tracker missed are found by the named body, and nothing else changes."""

from functools import cache

import numpy as np
import pytest

from kinemark.data import Cloud, Tracks
from kinemark.engine.naming.naming import name_tracks
from kinemark.engine.naming.second_pass import Search, second_pass, twins
from kinemark.engine.naming.templates import SessionTemplate
from kinemark.engine.session import Session
from kinemark.label import Labelling, learn_template
from kinemark.synth import observe, ring, walking, with_markers
from kinemark.track.simultaneous import Simultaneous, track_detections
from support.named_sessions import session_of

RATE = 25.0
RIG = ring(4, focal_px=1100.0)


@cache
def walk(seed, speed):
    walker = walking(duration_s=2.0, rate=RATE, seed=seed, wobble_mm=2.0, marker_radius_mm=7.0, speed_mm_s=speed)
    return with_markers(walker, 39, seed=1)


@cache
def recorded():
    """What four cameras see at few frames a second, its tracks, and how they are named by another walk."""
    seen = observe(RIG, walk(3, 1000.0), noise_px=0.2, merge_px=6.0, false_per_frame=1.0, dropout=0.05, seed=1)
    tracks = track_detections(seen.detections, RIG, method=Simultaneous())
    by = {"": SessionTemplate(learn_template(walk(1, 900.0).trajectories), ("another",))}
    return seen, tracks, by, name_tracks(tracks, by, how=Labelling())


@cache
def again():
    seen, tracks, by, found = recorded()
    return second_pass(found, tracks, by, Search(seen.detections, RIG, Simultaneous()))


def right(named):
    """(M, F) whether a marker has a point within 10 mm under its name; and how many named points are farther off."""
    truth, cloud = walk(3, 1000.0), named.tracks.cloud
    found, off = np.zeros(truth.xyz.shape[:2], bool), 0
    for k, name in enumerate(named.names):
        rows = np.flatnonzero(named.tracks.id == k)
        if name in truth.names:
            m, f = truth.names.index(name), cloud.frame[rows]
            near = np.linalg.norm(cloud.xyz[rows] - truth.xyz[m, f], axis=1) < 10
            found[m, f[near]] = True
            off += int((~near).sum())
    return found, off


def test_samples_that_were_missed_are_found_and_the_others_stay():
    seen, _, _, found = recorded()
    before, off = right(found)
    after, off_after = right(again())
    wanted = seen.unmerged_views >= 2
    lost = (wanted & ~before).sum()
    assert (wanted & ~after).sum() < 0.85 * lost
    assert not (before & ~after).any() and off_after <= off
    counts = again().figures["second_pass"]
    finding = [one for one in again().findings if one.kind == "second_pass_by_body"]
    assert len(finding) == 1 and finding[0].values["found"] == counts["found"] > 0


def test_an_image_is_of_one_named_marker():
    cloud, id = again().tracks.cloud, again().tracks.id
    M = sum(not name.startswith("*") for name in again().names)
    found = recorded()[3]
    new = cloud.detection[(id >= 0) & (id < M)]
    used, count = np.unique(new[new >= 0], return_counts=True)
    old = found.tracks.cloud.detection[found.tracks.id >= 0]
    shared_before, n = np.unique(old[old >= 0], return_counts=True)
    assert set(used[count > 1].tolist()) <= set(shared_before[n > 1].tolist())
    frames = cloud.frame[id >= 0]
    assert len(np.unique(np.column_stack([id[id >= 0], frames]), axis=0)) == len(frames)


def test_a_second_pass_over_the_result_finds_hardly_anything():
    seen, _, by, _ = recorded()
    more = second_pass(again(), again().tracks, by, Search(seen.detections, RIG, Simultaneous()))
    assert more.figures["second_pass"]["found"] <= 0.1 * again().figures["second_pass"]["found"] + 1


def test_what_a_person_said_stays():
    seen, tracks, by, found = recorded()
    fixed = np.ones(len(tracks.cloud), bool)
    said = second_pass(found, tracks, by, Search(seen.detections, RIG, Simultaneous()), fixed=fixed)
    counts = said.figures["second_pass"]
    assert counts["renamed"] == counts["joined"] == counts["put_aside"] == 0 < counts["found"]


def test_without_names_nothing_changes():
    seen, tracks, by, found = recorded()
    search = Search(seen.detections, RIG, Simultaneous())
    nobody = name_tracks(tracks, {}, how=Labelling())
    assert second_pass(nobody, tracks, {}, search) is nobody
    stars = found._replace(names=tuple(f"*{k}" for k in range(len(found.names))))
    assert second_pass(stars, tracks, by, search) is stars


def test_a_track_beside_a_named_marker_all_along_is_its_twin():
    xyz = np.repeat(np.array([[0.0, 0, 0], [4, 0, 0], [30, 0, 0]])[None], 5, axis=0) + 1e6
    start = np.arange(6) * 3
    cloud = Cloud(50.0, start, xyz.reshape(-1, 3), np.tile(np.eye(3), (15, 1, 1)), np.zeros(15), np.full((15, 2), -1))
    assert twins(Tracks(cloud, np.tile([0, 1, 2], 5)), 1) == {1}
    assert twins(Tracks(cloud, np.tile([0, 1, 2], 5)), 3) == frozenset()


@pytest.mark.parametrize("said", ["", "second_pass = false\n"])
def test_a_session_has_it_and_can_do_without(tmp_path, said):
    folder = session_of(tmp_path, "walk01", label=f'template = ["earlier.c3d"]\n{said}')
    Session.open(folder).run(("walk01",), to="label")
    figures = (folder / "results/walk01/labels.json").read_text()
    assert ('"second_pass"' in figures) == (not said)
