"""Points of a file that another program computed of the markers: told apart, and asked nothing."""

from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("fastapi", reason="the studio's dependencies are absent: pip install 'kinemark[studio]'")

from kinemark.data import MarkerTrajectory, Trial
from kinemark.io.trial import write_trial
from support.computed import computed, walker, with_computed
from support.studio import Studio

SHORT, LONG = 20, 180
"""Frames between which one of the computed points is there."""


@pytest.fixture(scope="module")
def markers():
    return walker()


@pytest.fixture
def studio(markers, tmp_path):
    """A computed point has a gap and ends before the markers do, and so has one of the markers."""
    paths = {path.name: path for path in with_computed(markers)}
    for name, away in {"JUG": [*range(SHORT), *range(60, 70), *range(LONG, 200)], "LKNE": range(80, 90)}.items():
        xyz = paths[name].xyz.copy()
        xyz[list(away)] = np.nan
        paths[name] = MarkerTrajectory.measured(name, xyz)
    write_trial(Trial("walk", replace(markers, paths=tuple(paths.values()))), tmp_path / "walk.c3d")
    return Studio(tmp_path / "walk.c3d")


def test_the_page_is_told_which_points_are_no_markers(studio, markers):
    rows = studio.page.get(studio.trial).json()["tracks"]
    assert {row["name"] for row in rows if row["computed"]} == {*computed(markers)}


def test_one_that_is_given_a_marker_s_name_is_a_marker(studio):
    assert studio.act(kind="claim", track="JUG", name="LMEP").status == 200
    (row,) = [row for row in studio.page.get(studio.trial).json()["tracks"] if row["name"] == "LMEP"]
    assert not row["computed"]


def test_gaps_are_those_of_markers(studio):
    assert {gap["marker"] for gap in studio.page.get(f"{studio.trial}/gaps").json()["gaps"]} == {"LKNE"}


def test_finishing_trims_to_what_markers_have(studio):
    assert studio.act(kind="finish").status == 200
    assert studio.page.get(studio.trial).json()["trim"] == [1, 200]
