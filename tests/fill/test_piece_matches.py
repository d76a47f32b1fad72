"""A later piece of track is compared with where filling puts the markers that are missing then."""

from dataclasses import replace

import numpy as np
import pytest

from kinemark.data import KinemarkError, MarkerTrajectory
from kinemark.engine.editing.files import open_editing
from kinemark.fill import piece_matches
from kinemark.io.trial import write_trial
from support.filling import moving, trial, trial_of

LOST, BACK = 120, 180


def with_piece(*lost, of, seed=0):
    """Two bodies of five markers; markers `lost` end, and one of them goes on as the track *9."""
    rng = np.random.default_rng(seed)
    one, other = moving(markers=5, soft=0.5, seed=seed), moving(markers=5, soft=0.5, seed=seed + 20)
    xyz = np.concatenate([one.xyz, other.xyz + np.array([0.0, 600.0, 0.0])]) + rng.normal(0, 0.2, (10, 300, 3))
    piece = np.full((300, 3), np.nan)
    piece[BACK:] = xyz[of, BACK:]
    xyz[list(lost), LOST:] = np.nan
    whole = trial(one._replace(xyz=xyz, names=tuple(f"M{k}" for k in range(10))))
    return replace(whole, paths=(*whole.paths, MarkerTrajectory.measured("*9", piece)))


@pytest.mark.parametrize("seed", range(4))
def test_a_piece_is_likely_the_marker_whose_fill_it_lies_on(seed):
    found = piece_matches(with_piece(0, 1, 7, of=1, seed=seed), "*9")
    assert found[0].name == "M1" and {one.name for one in found} == {"M0", "M1", "M7"}
    assert found[0].likely and found[0].off_mm < 5 < found[1].off_mm
    assert found[0].gap == BACK - LOST and not any(one.likely for one in found[1:])


def test_a_piece_that_lies_on_no_fill_is_nobody():
    lost = with_piece(0, 1, of=2)
    ghost = lost["*9"]
    away = replace(ghost, xyz=ghost.xyz + np.array([0.0, 0.0, 150.0]))
    found = piece_matches(replace(lost, paths=(*lost.paths[:-1], away)), "*9")
    assert found and not any(one.likely for one in found)


def test_markers_that_are_seen_then_are_not_meant_and_the_piece_fills_nobody():
    found = piece_matches(with_piece(3, of=3), "*9")
    assert [one.name for one in found] == ["M3"]
    with pytest.raises(KeyError):
        piece_matches(with_piece(3, of=3), "*10")
    empty = replace(with_piece(3, of=3), paths=(MarkerTrajectory.measured("A", np.full((300, 3), np.nan)),))
    with pytest.raises(ValueError, match="no sample"):
        piece_matches(empty, "A")


def test_a_file_says_which_marker_a_piece_may_be(tmp_path):
    said = replace(trial_of(np.zeros((1, 300, 3))), trajectories=with_piece(0, 1, of=1))
    write_trial(said, tmp_path / "walk.c3d")
    editing = open_editing(tmp_path / "walk.c3d")
    assert editing.matches("*9")[0].name == "M1" and editing.matches("*9")[0].likely
    with pytest.raises(KinemarkError):
        editing.matches("*10")
