"""Marker sets as files: those that are shipped hold together, what is written comes back, what is wrong is said."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from kinemark.data import KinemarkError, MarkerSet
from kinemark.io.marker_sets import (
    marker_set_from_toml,
    marker_set_toml,
    marker_sets,
    read_marker_set,
    write_marker_set,
)
from kinemark.io.model_toml import load_model
from kinemark.synth import arm, control_frame, walking

FIELDS = tuple(MarkerSet.__dataclass_fields__)
BODIES = [name for name in marker_sets() if read_marker_set(name).joints]


def assert_same(a, b):
    for name in FIELDS:
        if isinstance(getattr(a, name), np.ndarray):
            np.testing.assert_array_equal(getattr(a, name), getattr(b, name), name)
        else:
            assert getattr(a, name) == getattr(b, name), name


def test_the_sets_that_are_shipped():
    sizes = {name: len(read_marker_set(name).moving) for name in marker_sets()}
    assert sizes == {
        "isb-upper-limb": 22, "kiss-15": 15, "plug-in-gait-full": 39, "plug-in-gait-lower": 17, "rods": 24,
        "um2as-7": 7, "wand": 2,
    }  # fmt: skip


@pytest.mark.parametrize("name", marker_sets())
def test_a_shipped_set_says_all_that_there_is_to_say(name):
    found = read_marker_set(name)
    assert found.name == name and found.description and found.source
    assert all(found.meaning[marker] and found.faces[marker] and marker in found.places for marker in found.names)
    assert set(found.rigidity) == set(found.segments) and all(len(ms) > 1 for ms in found.segments.values())
    linked = {found.names[i] for i in found.links.ravel()}
    assert set(found.moving) - linked <= {*found.optional, "SACR"}


@pytest.mark.parametrize("name", BODIES)
def test_a_body_hangs_together_and_its_sides_mirror_each_other(name):
    found = read_marker_set(name)
    reached = {next(iter(found.segments))}
    for _ in found.segments:
        reached |= {end for two in found.joints.values() if reached & set(two) for end in two}
    assert reached == set(found.segments) and set(found.joints) <= set(found.places)
    for left, right in found.pairs:
        x, y = np.array(found.places[left]), np.array(found.places[right])
        assert x[1] > 0 > y[1] and np.abs(x * [1, -1, 1] - y).max() <= 0.04, left
        assert "left" in found.meaning[left] and found.meaning[left].replace("left", "right") == found.meaning[right]
    joint = {j: np.array(found.places[j]) for j in found.joints}
    for j, (a, b) in found.joints.items():
        near = [np.linalg.norm(joint[j] - found.places[m]) for s in (a, b) for m in found.segments[s]]
        assert min(near) < 0.15, j


def test_sets_name_markers_as_models_and_simulated_subjects_do():
    assert set(read_marker_set("kiss-15").names) == set(walking(duration_s=0.1).names)
    assert set(read_marker_set("um2as-7").names) == set(arm(duration_s=0.1).names)
    assert read_marker_set("rods").names == control_frame().marker_names
    worn = {name.removeprefix("R") for name in read_marker_set("isb-upper-limb").names}
    used = {marker for a, b in load_model("isb_upper_limb").links for marker in (a, b)}
    assert used - worn == {"GH", "MC3"}  # which are calculated


@pytest.mark.parametrize("name", marker_sets())
def test_what_is_written_comes_back(name, tmp_path):
    found = read_marker_set(name)
    write_marker_set(tmp_path / "own.toml", found)
    assert_same(read_marker_set(tmp_path / "own.toml"), found)


NAMES = st.text(st.characters(exclude_categories=["Cs"]), min_size=1, max_size=12).filter(str.strip)


@settings(max_examples=40, deadline=None)
@given(st.lists(NAMES, min_size=2, max_size=6, unique=True), NAMES, st.floats(0, 0.9))
def test_any_names_come_back(names, segment, share):
    links = np.array([[0, 1]])
    found = MarkerSet(
        tuple(names), {segment: tuple(names)}, links, np.array([12.5]), np.array([0.25]), ((names[0], names[1]),),
        name=names[0], meaning={names[1]: segment}, rigidity={segment: share}, places={names[0]: (0.1, -0.2, 1.0)},
        optional=(names[1],),
    )  # fmt: skip
    assert_same(marker_set_from_toml(marker_set_toml(found)), found)


BASE = '[markers]\nLASI = {}\nRASI = {}\nSACR = {}\n[segments]\npelvis = { markers = ["LASI", "RASI", "SACR"] }\n'


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("names = 3", "unknown key 'names'"),
        ("= 3", "no TOML"),
        ("name = 'x'", "no markers"),
        ("[markers]\nA = 3", "marker A is 3"),
        ("[markers]\nA = { meanning = 'x' }", r"did you mean 'meaning'\?"),
        (BASE.replace('"SACR"]', '"SACRR"]'), r"segment pelvis has the unknown marker 'SACRR' \(did you mean 'SACR'"),
        ('pairs = [["LASI", "RASY"]]\n' + BASE, r"pairs has the unknown marker 'RASY' \(did you mean 'RASI'"),
        ('pairs = [["LASI", "RASI"], ["LASI", "SACR"]]\n' + BASE, "LASI stands in more than one"),
        ('pairs = [["LASI", "LASI"]]\n' + BASE, "two different names"),
        ('links = [["LASI", "SACK"]]\n' + BASE, r"did you mean 'SACR'"),
        ('links = [{ markers = ["LASI", "SACR"], length_mm = -1.0 }]\n' + BASE, "above 0 mm"),
        ('links = [{ markers = ["LASI", "SACR"], length_mm = nan, spread_mm = inf }]\n' + BASE, "finite"),
        (BASE + '[joints]\nhip = { segments = ["pelvis", "thigh"] }', "unknown segment 'thigh'"),
        (BASE + '[joints]\nLASI = { segments = ["pelvis", "pelvis"] }', "two different names|marker and of a joint"),
        (BASE.replace("LASI = {}", "LASI = { place = [0.1, 0.2] }"), "2 numbers, wanted three"),
        (BASE.replace("LASI = {}", "LASI = { place = [0.1, 0.2, nan] }"), "wanted three numbers"),
        (BASE.replace("LASI = {}", "LASI = { worn = 'sometimes' }"), "always, optional, static"),
        (BASE.replace("LASI = {}", "LASI = { view = 'left' }"), "front, back, both"),
        (BASE.replace('"SACR"] }', '"SACR"], spread = 14 }'), "wanted a share"),
        (BASE.replace('"SACR"] }', '"SACR"], spread = true }'), "wanted a number"),
        (BASE.replace('"SACR"]', '"LASI"]'), "names a marker twice"),
        ('[markers]\n"" = {}', "empty"),
    ],
)
def test_what_does_not_hold_together_is_said(text, says):
    with pytest.raises(KinemarkError, match=says):
        marker_set_from_toml(text)


def test_an_unknown_set_is_said_with_what_there_is(tmp_path):
    with pytest.raises(KinemarkError, match=r"did you mean 'kiss-15'.*plug-in-gait-full"):
        read_marker_set("kiss15")
    (tmp_path / "bad.toml").write_text("[markers]\nA = 3")
    with pytest.raises(KinemarkError, match=r"bad\.toml.*marker A"):
        read_marker_set(tmp_path / "bad.toml")
    (tmp_path / "binary.toml").write_bytes(b"\0\1\2")
    with pytest.raises(KinemarkError, match="binary"):
        read_marker_set(tmp_path / "binary.toml")


def test_a_wheel_holds_the_sets():
    import tomllib
    from pathlib import Path

    project = tomllib.loads((Path(__file__).parents[2] / "pyproject.toml").read_text())
    assert "marker_sets/*.toml" in project["tool"]["setuptools"]["package-data"]["kinemark.data"]
