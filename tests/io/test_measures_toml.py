"""Subjects' measures from TOML and from C3D parameters."""

import numpy as np
import pytest

from kinemark.data import KinemarkError, Trajectories, Trial
from kinemark.io.c3d import Parameter, document_of, with_parameters
from kinemark.io.c3d.subject_measures import measures_of
from kinemark.io.measures_toml import read_measures

TEXT = """
mass_kg = 61.5
marker_diameter_mm = 25
[left]
leg_mm = 880
knee_mm = 102.5
ankle_mm = 68
torsion_deg = 5
[right]
leg_mm = 885
knee_mm = 101
ankle_mm = 69
"""


def written(tmp_path, text):
    path = tmp_path / "anna.toml"
    path.write_text(text, encoding="utf-8")
    return path


def test_measures_are_read(tmp_path):
    found = read_measures(written(tmp_path, TEXT))
    assert (found.mass_kg, found.left.knee_mm, found.left.torsion_deg, found.right.leg_mm) == (61.5, 102.5, 5.0, 885.0)
    assert found.height_mm is None and found.marker_diameter_mm == 25.0


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("knee_mm = 101", "knee_width = 101", "knee_"),
        ("knee_mm = 101", "", "lacks knee_mm"),
        ("leg_mm = 880", "leg_mm = 0.88", "millimetres"),
        ("leg_mm = 880", 'leg_mm = "long"', "wanted a number"),
        ("[left]", "[lft]", "did you mean 'left'"),
        ("mass_kg = 61.5", "mass_kg = 61500", "mass_kg"),
        ("[left]", "[left", "no TOML"),
    ],
)
def test_what_is_wrong_is_named(tmp_path, old, new, says):
    with pytest.raises(KinemarkError, match=says):
        read_measures(written(tmp_path, TEXT.replace(old, new, 1)))


def processed(**values):
    trial = Trial("walk", Trajectories((), 100.0))
    doc = document_of(trial)
    return with_parameters(doc, "PROCESSING", [Parameter.real(name, [value]) for name, value in values.items()])


LEGS = {f"{side}{name}": value for side in "LR" for name, value in
        (("LegLength", 900.0), ("KneeWidth", 100.0), ("AnkleWidth", 70.0))}  # fmt: skip


@pytest.mark.parametrize(("stated", "deg"), [(0.2, np.degrees(0.2)), (11.5, 11.5)])
def test_offsets_in_radians_and_in_degrees_are_told_apart(stated, deg):
    offsets = {f"{side}{name}": stated for side in "LR" for name in ("StaticPlantFlex", "StaticRotOff")}
    found = measures_of(processed(**LEGS, **offsets, Bodymass=50.0))
    assert found.left.plantar_offset_deg == pytest.approx(deg, rel=1e-6) and found.mass_kg == 50.0


def test_a_file_without_measures_has_none():
    assert measures_of(processed(LLegLength=900.0)) is None and measures_of("no C3D") is None


def test_measures_typed_instead_of_a_file_say_what_the_file_holds():
    with pytest.raises(
        KinemarkError, match=r"leg=800 is not a file. Measures are read from a TOML file: .*leg_mm = 880"
    ):
        read_measures("leg=800")
