"""Models of segment chains as TOML files: those that come along are whole, and wrong ones say why."""

from dataclasses import replace

import numpy as np
import pytest

from kinemark.data import KinemarkError, MarkerTrajectory, Trajectories
from kinemark.io.model_toml import load_model, model_from_toml, models
from kinemark.kinematics import Axis, Centre, Cluster, Joint, JointMotion, Model, Segment, joint_angles


def test_every_model_that_comes_along_is_whole():
    assert models() == ("isb_shoulder", "isb_upper_limb", "um2as")
    for name in models():
        for side in ("right", "left"):
            model = load_model(name, side=side)
            assert model.name == name and model.side == side and model.source and model.links
            assert set(p for link in model.links for p in link) <= set(model.points)
    assert load_model("isb_upper_limb", side="left").aliases["EL"] == ("LEL",)


GOOD = """
name = "hinge"
[points]
M = ["C", "D"]
[[segment]]
name = "a"
first = { axis = "y", vector = ["A", "B"] }
second = { axis = "x", normal = ["A", "B", "A", "C"] }
[[segment]]
name = "b"
first = { axis = "z", vector = ["C", "D"] }
second = { axis = "x", vector = ["C", "A"] }
[[joint]]
name = "hinge"
parent = "a"
child = "b"
sequence = "xyz"
angles = [{ positive = "open", negative = "shut", normal = [0, 90] }, {}, {}]
[[cluster]]
name = "one"
markers = ["A", "B", "C"]
"""


def test_a_model_of_ones_own(tmp_path):
    path = tmp_path / "hinge.toml"
    path.write_text(GOOD)
    model = load_model(path)
    assert model.joints[0].motions[0] == JointMotion("open", "shut", (0.0, 90.0)) and model.joints[0].motions[1] is None
    xyz = np.random.default_rng(0).normal(size=(4, 10, 3)) * 100
    trial = Trajectories(tuple(MarkerTrajectory.measured(n, x) for n, x in zip("ABCD", xyz, strict=True)), 100.0)
    R = joint_angles(trial, model=model).deg
    assert np.isfinite(R).all()


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('name = "hinge"\n[points]', "[points]", "has no name"),
        ("[points]", "[point]", "the file has the unknown key 'point' \\(did you mean 'points'"),
        ('sequence = "xyz"', 'sequence = "xxz"', "sequence is 'xxz'"),
        ('sequence = "xyz"', "sequence = 7", "sequence is 7, wanted text"),
        ('parent = "a"', 'parent = "c"', r"names \['c'\]; there are the segments"),
        ('vector = ["A", "B"]', 'vector = ["A", "B", "C"]', "has 3 points, wanted 2"),
        ('vector = ["A", "B"]', 'vector = ["A", "A"]', "goes from A to itself"),
        ('vector = ["A", "B"]', "colour = 3", "axis has the unknown key 'colour'; known"),
        ('axis = "y", vector', 'axis = "w", vector', "is called 'w'"),
        ('axis = "y", vector', 'axis = "x", vector', "both axes are x"),
        ("normal = [0, 90]", "normal = [90, 0]", "the least angle first"),
        ("normal = [0, 90]", 'normal = "much"', "normal is 'much'"),
        ("{}, {}]", "{}]", "names 2 angles, wanted 3"),
        ('markers = ["A", "B", "C"]', 'markers = ["A", "B"]', "three or more"),
        ('M = ["C", "D"]', 'N = ["M"]\nM = ["C", "D"]', "must stand above it"),
        ("[[cluster]]", '[[centre]]\nname = "E"\nbetween = ["x", "y"]\n[[cluster]]', "centre E names"),
        ("[points]", 'side = "both"\n[points]', "side is 'both'"),
        ("[points]", 'up = "x"\n[points]', "wanted two axes such as"),
        ("[points]", "[[", "is no TOML"),
    ],
)  # fmt: skip
def test_models_that_do_not_hold_together_say_why(old, new, message):
    assert old in GOOD and model_from_toml(GOOD)
    with pytest.raises(KinemarkError, match=message):
        model_from_toml(GOOD.replace(old, new, 1))


@pytest.mark.parametrize(
    "text", ["", "a = 1", "segment = 3", "name = 'x'\nsegment = []\njoint = []", "\x00", "[" * 5000]
)
def test_texts_that_are_no_model(text):
    with pytest.raises(KinemarkError):
        model_from_toml(text)


def test_records_refuse_models_that_cannot_be():
    a = Segment("a", Axis("x", ("A", "B")), Axis("y", ("A", "C")))
    joint = Joint("j", "laboratory", "a", "xyz")
    assert Model("m", (a,), (joint,)).markers == ("A", "B", "C")
    for bad in (
        lambda: Model("m", (a, a), (joint,)),
        lambda: Model("m", (a,), ()),
        lambda: Model("m", (a,), (replace(joint, child="laboratory", parent="a"),)),
        lambda: Model("m", (a,), (joint,), centres=(Centre("c", ("p", "q")),)),
        lambda: replace(joint, middle="up"),
        lambda: Cluster("c", ("A", "A", "B")),
    ):
        with pytest.raises(ValueError):
            bad()


def test_a_model_on_the_base_of_another(tmp_path):
    """What the file does not say is as there; its names come first, and its points are its own."""
    text = 'name = "mine"\nbase = "isb_upper_limb"\n[aliases]\nEL = ["EPICl"]\n[points]\nGH = ["ACRO"]\n'
    (tmp_path / "m.toml").write_text(text)
    mine, theirs = load_model(tmp_path / "m.toml"), load_model("isb_upper_limb")
    assert mine.name == "mine" and mine.segments == theirs.segments and mine.joints == theirs.joints
    assert mine.aliases["EL"] == ("EPICl", *theirs.aliases.get("EL", ())) and mine.means["GH"] == ("ACRO",)
    assert "ACRO" in mine.markers and "GH" not in mine.markers
    assert load_model(tmp_path / "m.toml", side="left").side == "left"
    with pytest.raises(KinemarkError, match="base is 'their', wanted one of"):
        model_from_toml('name = "x"\nbase = "their"\n')
