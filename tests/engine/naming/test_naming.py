"""Tracks become markers: joined, without ghosts, and the tracker's findings with their names."""

import numpy as np
import pytest

from kinemark.data import Cloud, KinemarkError, MarkerTrajectory, Tracks, Trajectories, make_finding
from kinemark.data.edits import Claim
from kinemark.edit import stretch_of
from kinemark.engine.naming import Earlier
from kinemark.engine.naming.claims import claimed_tracks
from kinemark.engine.naming.label_stage import static_of
from kinemark.engine.naming.named_tracks import LEARNT
from kinemark.engine.naming.naming import ghost_tracks, with_names
from kinemark.io.records import save
from kinemark.io.stated_names_csv import read_stated_names


def tracks_of(detection, identity):
    """One point a frame and track."""
    n = len(identity)
    xyz, cov = np.zeros((n, 3)), np.tile(np.eye(3), (n, 1, 1))
    return Tracks(Cloud(50.0, np.array([0, n]), xyz, cov, np.zeros(n), np.array(detection)), np.array(identity))


def test_a_nameless_track_of_the_images_of_a_named_marker_is_a_ghost():
    images = [[0, 1, -1], [0, -1, 2], [3, 4, -1], [-1, 5, 6]]
    tracks = tracks_of(images, [0, 1, 2, 3])
    joined = np.array([0, 1, 2, 3])
    assert ghost_tracks(tracks, joined, n_named=1) == {1}
    assert ghost_tracks(tracks, joined, n_named=0) == frozenset()
    assert ghost_tracks(tracks, joined, n_named=4) == frozenset()


def test_what_the_tracker_found_is_told_with_names():
    found = make_finding("tracks_continue", tracks=2, earlier_list=["*1", "*3"], later_list=["*2", "*4"])
    told = with_names(found, ["KNE", "KNE", "TOE", ""])
    assert told.values == {"tracks": 1, "earlier_list": ("TOE",), "later_list": ("no marker",)}
    assert with_names(found, ["KNE", "KNE", "TOE", "TOE"]) is None


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("trial,frame,name\n", "Wanted are the columns"),
        ("trial,frame,x_mm,y_mm,z_mm,name\nw,0,1,2,3,A\n", "line 2"),
        ("trial,frame,x_mm,y_mm,z_mm,name\nw,1,1,2,nan,A\n", "line 2"),
        ("trial,frame,x_mm,y_mm,z_mm,name\nw,1,1,2,A\n", "line 2"),
    ],
)
def test_statements_that_are_none_are_refused_with_their_line(tmp_path, text, said):
    file = tmp_path / "names.csv"
    file.write_text(text)
    with pytest.raises(KinemarkError, match=said):
        read_stated_names(file)


def test_claims_cut_tracks_where_they_begin_and_end_and_the_later_one_counts():
    """A claim of no marker leaves what is around it one track; one of a name makes it two."""
    xyz = np.column_stack([np.arange(60.0), np.zeros(60), np.zeros(60)])
    tracks = Trajectories(
        tuple(MarkerTrajectory.measured(f"*{k}", xyz + np.array([0.0, 100.0 * k, 0.0])) for k in (1, 2, 3)), 50.0
    )

    def claim(k, name, first=None, last=None):
        return Claim(stretch_of(tracks, f"*{k}", first=first, last=last, world="w"), name)

    said = [claim(1, "LKNE", 21, 30), claim(2, None, 21, 30), claim(3, "LKNE"), claim(3, "RKNE")]
    found = claimed_tracks(tracks, said, None, world="w")
    assert found.tracks.names == ("*1 (1)", "*1 (2)", "*1 (3)", "*2 (1)", "*2 (2)", "*3")
    assert found.stated == {"*1 (1)": "LKNE", "*2 (1)": None, "*3": "RKNE"}
    counts = [int(np.isfinite(path.xyz[:, 0]).sum()) for path in found.tracks]
    assert counts == [10, 20, 30, 10, 50, 60]
    twice = claimed_tracks(tracks, [claim(1, "LKNE"), claim(2, "LKNE")], None, world="w")
    assert twice.stated == {"*2": "LKNE"}


def test_pieces_that_are_joined_though_both_are_seen_for_a_frame_are_the_marker_both():
    xyz = np.column_stack([np.arange(60.0), np.zeros(60), np.zeros(60)])
    first, second = xyz.copy(), xyz.copy()
    second[:, 1] = 8.0
    first[31:], second[:29] = np.nan, np.nan  # both are seen in two frames
    tracks = Trajectories(tuple(MarkerTrajectory.measured(n, p) for n, p in (("*1", first), ("*2", second))), 50.0)
    said = [Claim(stretch_of(tracks, n, first=None, last=None, world="w"), "LKNE") for n in ("*1", "*2")]
    found = claimed_tracks(tracks, said, None, world="w")
    assert found.stated == {"*1": "LKNE", "*2": "LKNE"} and found.tracks.names == ("*1", "*1 (twice)", "*2")
    assert [np.isfinite(path.xyz[:, 0]).sum() for path in found.tracks] == [29, 2, 31]


def test_a_static_trial_of_another_subject_places_no_marker_of_these(tmp_path):
    for name, markers in (("first", ("A:HEE", "A:TOE")), ("second", ("B:HEE", "A:KNE"))):
        (tmp_path / name).mkdir()
        paths = tuple(MarkerTrajectory.measured(marker, np.zeros((2, 3))) for marker in markers)
        save(tmp_path / name / LEARNT, Trajectories(paths, 50.0))
    earlier = [Earlier(name, "static", tmp_path / name, "key") for name in ("first", "second")]

    def names(*subjects):
        found = static_of(earlier, subjects)
        return None if found is None else found.names

    assert names("B") == ("B:HEE",) and names("A") == names() == ("A:HEE", "A:TOE") and names("C") is None
