"""Files of gait: reference bands, OpenSim's tables, GCD."""

import json

import numpy as np
import pytest

from kinemark.data import KinemarkError
from kinemark.data.gait_curves import GaitCurves, GaitReference
from kinemark.io.gait_reference import control_curves, read_reference, write_reference
from kinemark.io.gcd import write_gcd
from kinemark.io.opensim_storage import write_storage


def band():
    rng = np.random.default_rng(0)
    mean = {"KneeAngles": rng.normal(20, 10, (101, 3)), "HipPower": rng.normal(0, 1, (101, 1))}
    sd = {name: np.abs(curve) / 10 for name, curve in mean.items()}
    sd["HipPower"][3:9] = np.nan
    return GaitReference(mean, sd, "our controls", 7)


def test_a_band_comes_back(tmp_path):
    write_reference(tmp_path / "band.json", band())
    again = read_reference(tmp_path / "band.json")
    assert (again.source, again.subjects) == ("our controls", 7)
    for name, curve in band().mean.items():
        np.testing.assert_allclose(again.mean[name], curve, atol=1e-5)
        np.testing.assert_allclose(again.sd[name], band().sd[name], atol=1e-5)


def test_a_band_may_be_toml_and_keeps_the_scale_of_its_controls(tmp_path):
    given = band()._replace(
        log_score=(1.6, 0.25), numbers={"speed": (1200.0, 90.0), "knee flexion at strike": (5.0, 3.5)}
    )
    write_reference(tmp_path / "band.json", given)
    rows = {name: [[f"{v:.9g}" for v in row] for row in given.mean[name]] for name in given.mean}
    tables = "".join(
        f"[curves.{name}]\nmean = [{', '.join('[' + ', '.join(row) + ']' for row in rows[name])}]\n"
        f"sd = [{', '.join('[' + ', '.join(row) + ']' for row in rows[name])}]\n"
        for name in rows
    )
    head = 'source = "a journal"\nsubjects = 40\nlicence = "CC BY 4.0"\nlog_score = [1.6, 0.25]\n'
    head += '[numbers]\nspeed = [1200, 90]\n"knee flexion at strike" = [5.0, 3.5]\n'
    (tmp_path / "band.toml").write_text(head + tables, encoding="utf-8")
    one, other = (read_reference(tmp_path / f"band.{end}") for end in ("json", "toml"))
    assert one.log_score == other.log_score == (1.6, 0.25) and other.subjects == 40
    np.testing.assert_allclose(other.mean["KneeAngles"], one.mean["KneeAngles"], atol=1e-5)
    assert one.numbers == other.numbers == given.numbers
    (tmp_path / "band.toml").write_text(head.replace("1200, 90", "1200, nan") + tables, encoding="utf-8")
    with pytest.raises(KinemarkError, match="speed is"):
        read_reference(tmp_path / "band.toml")
    (tmp_path / "band.toml").write_text(head.replace("0.25", "-1.0") + tables, encoding="utf-8")
    with pytest.raises(KinemarkError, match="log_score"):
        read_reference(tmp_path / "band.toml")
    for broken in ("source =", "source = " + "[" * 5000):
        (tmp_path / "band.toml").write_text(broken, encoding="utf-8")
        with pytest.raises(KinemarkError, match="no TOML"):
            read_reference(tmp_path / "band.toml")


@pytest.mark.parametrize(
    ("text", "said"),
    [("{", "no JSON"), ("[" * 100_000, "no JSON"), ("[]", "no reference band"),
     ('{"source": "a", "subjects": 2}', "gait-reference"),
     ('{"source": "a", "subjects": 2, "curves": {"K": {"mean": [[1]], "sd": [[1]]}}}', r"wanted \(101")],
)  # fmt: skip
def test_what_is_no_band_is_told(tmp_path, text, said):
    (tmp_path / "band.json").write_text(text, encoding="utf-8")
    with pytest.raises(KinemarkError, match=said):
        read_reference(tmp_path / "band.json")


def test_what_is_no_control_is_told(tmp_path):
    (tmp_path / "gait.json").write_text(json.dumps({"curves": [{"name": "LKneeAngles"}]}), encoding="utf-8")
    with pytest.raises(KinemarkError, match=r"no gait\.json"):
        control_curves(tmp_path / "gait.json")


def test_a_table_of_opensim_says_what_it_holds(tmp_path):
    knee = np.array([1.0, np.nan, -3.25])
    write_storage(tmp_path / "walk.mot", {"knee": knee, "hip": 2 * knee}, rate=50.0, in_degrees=True)
    lines = (tmp_path / "walk.mot").read_text().splitlines()
    end = lines.index("endheader")
    assert lines[0] == "walk" and {"nRows=3", "nColumns=3", "inDegrees=yes", "version=1"} < set(lines[:end])
    assert lines[end + 1].split("\t") == ["time", "knee", "hip"]
    rows = np.array([line.split("\t") for line in lines[end + 2 :]], float)
    np.testing.assert_allclose(rows, np.column_stack([[0, 0.02, 0.04], knee, 2 * knee]))
    with pytest.raises(KinemarkError, match="one length"):
        write_storage(tmp_path / "a.sto", {"a": knee, "b": knee[:2]}, rate=50.0)


def test_gcd_has_51_points_of_what_is_wholly_known(tmp_path):
    y = np.linspace(0, 60, 101)[:, None] * (1.0, 2.0, 3.0)
    gone = y.copy()
    gone[8] = np.nan
    curves = [
        GaitCurves(name, "left", "deg", ("a", "b", "c"), values[None], values[None], np.array([60.0]))
        for name, values in (("LKneeAngles", y), ("LHipAngles", gone))
    ]
    write_gcd(tmp_path / "a.gcd", curves, {"left": {"speed": 1234.0, "cadence": np.nan}, "right": {}})
    lines = (tmp_path / "a.gcd").read_text().splitlines()
    assert lines[0].startswith("#!DST-0.1 GCD") and lines[1:3] == ["!LeftSpeed", "1.234"]
    first = lines.index("!LeftKneeValgVar") + 1
    np.testing.assert_allclose(np.array(lines[first : first + 51], float), y[::2, 1], rtol=1e-5)
    assert lines[first + 51].startswith("!") and "!LeftHipFlexExt" not in lines and "!LeftCadence" not in lines
