"""Tracks become markers: joined, without ghosts, and the tracker's findings with their names."""

import numpy as np
import pytest

from kinemark.data import Cloud, KinemarkError, Tracks, make_finding
from kinemark.engine.naming.naming import ghost_tracks, with_names
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
