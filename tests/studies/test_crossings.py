"""Crossings in space: the markers pass as the study says, passages are judged as they are, and identities hold."""

import crossings as study
import numpy as np
import pytest

from kinemark.data import Cloud, Tracks


@pytest.mark.parametrize("way", ["crossing", "turning", "together"])
def test_markers_pass_at_the_distance_of_the_row(way):
    subject, at = study.crossing(20.0, 1000.0, 7, study.WAYS[way])
    apart = np.linalg.norm(subject.xyz[::2] - subject.xyz[1::2], axis=-1)
    there = [apart[k, round(when * 1000)] for k, when in enumerate(at)]
    np.testing.assert_allclose(there, 20.0, atol=2.5)


def tracks_of(subject, ids):
    """Tracks that follow the truth, (M, F) ids."""
    n = subject.n_frames
    xyz = subject.xyz.transpose(1, 0, 2).reshape(-1, 3)
    start = np.arange(n + 1) * len(subject)
    cov = np.broadcast_to(np.eye(3), (len(xyz), 3, 3))
    cloud = Cloud(subject.rate, start, xyz, cov, np.zeros(len(xyz)), np.full((len(xyz), 2), -1))
    return Tracks(cloud, ids.T.ravel())


def test_right_swapped_and_cut_passages_are_told_apart():
    subject, at = study.crossing(20.0, 100.0, 3, study.WAYS["crossing"])
    ids = np.repeat(np.arange(12)[:, None], subject.n_frames, 1)
    assert study.judged(tracks_of(subject, ids), subject, at, []) == (12, 0, 0, 0)
    f = round(at[0] * 100)
    ids[[0, 1], f:] = ids[[1, 0], f:]
    ids[2, round(at[1] * 100) :] = 12
    assert study.judged(tracks_of(subject, ids), subject, at, []) == (9, 2, 0, 1)


def test_no_marker_is_swapped_unless_it_is_listed():
    found = study.passages(study.WAYS["crossing"], 10.0, 100.0, 5, [11], "simultaneous")
    assert found.swapped == 0 and found.right >= 11
