"""All of a trial but its samples: what the page draws and offers by."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

pytest.importorskip("fastapi", reason="the studio's dependencies are absent: pip install 'kinemark[studio]'")

from kinemark.apps.studio.header import _up
from kinemark.data import Trial
from kinemark.data.laboratory_axes import axis_of, level_axes, turned
from kinemark.io.trial import write_trial
from support.laboratory import ring
from support.studio import Studio
from support.walked import clean


def header_of(trial, folder):
    write_trial(trial, folder / "walk.c3d")
    studio = Studio(folder / "walk.c3d")
    return studio.page.get(studio.trial).json()


@pytest.mark.parametrize("up", ["+Z", "+Y", "+X"])
def test_a_body_stands_upright_whichever_axis_of_its_file_goes_up(up, tmp_path):
    """An OpenSim walk, with y up, was drawn lying on its floor."""
    turn = level_axes(axis_of("z")) @ level_axes(axis_of(up)).T
    trial = turned(Trial("walk", clean(markers=12).frames(0, 60)), turn)
    assert header_of(trial, tmp_path)["up"] == axis_of(up).tolist()


def test_markers_without_a_partner_are_named_beside_the_pairs(tmp_path):
    names = ("LASI", "RASI", "LKNE", "RKNE", "RBAK", "LELB", "C7", "STRN")
    paths = clean(markers=12).frames(0, 20).paths[:8]
    found = replace(
        clean(markers=12).frames(0, 20), paths=tuple(replace(p, name=n) for p, n in zip(paths, names, strict=True))
    )
    header = header_of(Trial("walk", found), tmp_path)
    assert header["pairs"] == [["LASI", "RASI"], ["LKNE", "RKNE"]]
    assert header["one_sided"] == ["RBAK", "LELB"]


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_a_session_stands_as_its_cameras_do(axis):
    """A walk of BTS, whose y goes up, went up a wall."""
    turn = np.roll(np.eye(3), axis - 2, axis=0).T  # z becomes this axis
    cameras = ring()
    turned_rig = replace(cameras, cameras=tuple(replace(c, R=c.R @ turn) for c in cameras))
    document = SimpleNamespace(kept={}, trial=object(), editing=SimpleNamespace(rig=turned_rig, source=None))
    assert _up(document) == tuple(np.eye(3)[axis].tolist())
