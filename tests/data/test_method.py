"""Laws of every declared method: its parameters say all, their bounds are what they say, and the stages run at them."""

import json
import math
import subprocess
import sys
from dataclasses import dataclass, replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from kinemark.data import AngleModel, KinemarkError
from kinemark.data.method import Declaration, Method, Stage, parameter, plain_parameters
from kinemark.detect import DETECT, detect_frames
from kinemark.engine.settings import SETTABLE, STAGES, method_of, methods_figures, methods_table_markdown, methods_text
from kinemark.engine.settings.method_tables import COMMON
from kinemark.fill import Auto, Gap, KalmanAngles, LimbAngles, Linear, Quintic
from kinemark.fill.methods.stage import FILL, automatic, filler_of
from kinemark.match import MATCH, match
from kinemark.reconstruct import RECONSTRUCT, reconstruct
from kinemark.track import TRACK, matches_itself, track
from kinemark.track.simultaneous import track_detections
from support.filling import moving
from support.laboratory import observe, ring
from support.motions import swarm
from support.sessions import folder_of

DECLARED = [declared for stage in STAGES.values() for declared in stage.values()]
EACH = [(declared, p) for declared in DECLARED for p in declared.parameters]
NUMBERS = [(declared, p) for declared, p in EACH if p.leaf in (int, float)]
NEEDED = {"semi_automatic": {"markers": ("A", "B")}}
"""What a method cannot be made without."""
BESIDE = {
    "max_area": {"min_area": 1},
    "min_area": {"max_area": 2**31},
    "min_ratio": {"max_ratio": math.inf},
    "max_ratio": {"min_ratio": 1e-9},
    "longest_period": {"shortest_period": 1e-9},
    "lengths": {"links": ((0, 1),)},
}
"""What a parameter at its bound needs beside it, where a method has that as well: two parameters that must agree."""


def called(part):
    return f"{part[0].name}.{part[1].name}"


each = pytest.mark.parametrize(("declared", "p"), EACH, ids=map(called, EACH))
number = pytest.mark.parametrize(("declared", "p"), NUMBERS, ids=map(called, NUMBERS))


def made(declared, p, value):
    """The method with one parameter as given."""
    own = {q.name for q in declared.parameters}
    beside = {key: other for key, other in BESIDE.get(p.name, {}).items() if key in own}
    return declared.kind(**NEEDED.get(declared.name, {}) | beside | {p.name: value})


def wrapped(p, value):
    """A number as the parameter has it: a list of one number where it is a list, or of a list of one."""
    if p.kind != "list":
        return value
    return {"links": ((value, 1),), "banks": ((value,),)}.get(p.name, (value,))


def stepped(p, bound, towards):
    """The number next to a bound."""
    return int(bound) + int(math.copysign(1, towards)) if p.leaf is int else math.nextafter(bound, towards)


def inside(p):
    """The bounds that are allowed, and a millionth inside those that are not."""
    r, a_little = p.range, 1 if p.leaf is int else 1e-6
    found = [r.low, r.high if r.high is None or p.leaf is float else int(r.high)]
    found += [None if r.above is None else r.above + a_little, None if r.below is None else r.below - a_little]
    return [value for value in found if value is not None]


def outside(p):
    """Numbers just beyond the bounds, and what is no number."""
    r, found = p.range, [math.nan]
    found += [stepped(p, bound, -math.inf) for bound in (r.low,) if bound is not None]
    found += [stepped(p, bound, math.inf) for bound in (r.high,) if bound is not None and bound < math.inf]
    found += [bound for bound in (r.above, r.below) if bound is not None]
    return found if r.high == math.inf else [*found, math.inf]


@each
def test_a_parameter_says_what_it_means_in_one_line_and_every_number_has_a_unit(declared, p):
    assert p.meaning and "\n" not in p.meaning and p.meaning == p.meaning.strip() and not p.meaning.endswith(".")
    assert bool(p.unit) == (p.leaf in (int, float))
    assert p.wanted() and declared.summary.endswith(".") and "\n" not in declared.summary


@each
def test_a_default_is_what_it_may_be(declared, p):
    if not p.required:
        p.check(p.default)
        method = declared.kind(**NEEDED.get(declared.name, {}))
        assert getattr(method, p.name) == p.default


@number
def test_what_is_at_its_bounds_is_taken(declared, p):
    assert inside(p) or p.name in ("seed", "volume")  # those of which every number will do
    for value in inside(p):
        assert getattr(made(declared, p, wrapped(p, value)), p.name) == wrapped(p, value)
    for bound, towards in ((p.range.above, math.inf), (p.range.below, -math.inf)):
        if bound is not None:
            p.check(wrapped(p, stepped(p, bound, towards)))


@number
def test_what_is_beyond_its_bounds_is_refused_with_name_found_and_wanted(declared, p):
    if p.name != "volume":  # corners are a list of two
        for value in outside(p):
            with pytest.raises(ValueError) as refused:
                made(declared, p, wrapped(p, value))
            assert str(refused.value).startswith(p.name) and repr(value) in str(refused.value)
            assert ", wanted " in str(refused.value)


@each
def test_what_is_of_another_kind_is_refused(declared, p):
    wrong = {"number": "wide", "whole number": 2.5, "true or false": "yes", "choice": "magic", "text": 3, "list": 3}
    if p.kind in wrong:
        with pytest.raises(ValueError, match=rf"{p.name} is .*, wanted "):
            made(declared, p, wrong[p.kind])


def values(p):
    """Any value that a parameter may have, as a file states it."""
    r = p.range
    if p.kind == "choice":
        return st.sampled_from(p.choices)
    if p.kind == "true or false":
        return st.booleans()
    if p.leaf is int:
        return st.integers(int(r.low or 0), int(min(r.high or 1e6, 1e6)))
    low = r.above if r.low is None else r.low
    high = r.below if r.high in (None, math.inf) else r.high
    open_ends = {"exclude_min": low is not None and r.low is None, "exclude_max": high is not None and r.high is None}
    return st.floats(low, high, **open_ends, allow_nan=False, allow_infinity=False)


@pytest.mark.parametrize("declared", [d for d in DECLARED if d.stage in SETTABLE], ids=lambda d: f"{d.stage}.{d.name}")
@settings(max_examples=25)
@given(data=st.data())
def test_a_method_comes_back_from_the_table_that_states_it(declared, data):
    single = {p.name: p for p in declared.stateable if p.kind not in ("list", "text")}
    names = data.draw(st.lists(st.sampled_from(sorted(single)), unique=True)) if single else []
    table = NEEDED.get(declared.name, {}) | {name: data.draw(values(single[name])) for name in names}
    try:
        method = declared.kind(**table)
    except ValueError:  # parameters that do not go together
        return
    stated = json.loads(json.dumps({name: getattr(method, name) for name in (*table, *names)}))
    assert method_of(declared.stage, {"method": declared.name} | stated) == method


# ---- One new file is a new method ----

NEW = '''
from dataclasses import dataclass

from kinemark.data.method import Method, parameter
from kinemark.match.nearest_epipolar import NearestEpipolar, match_nearest
from kinemark.match.stage import MATCH


@dataclass(frozen=True, slots=True)
class Nearest(Method):
    """The nearest image of two cameras, within a band."""

    width: float = parameter(1.5, unit="px", above=0, high=9, meaning="half width of the band")


@MATCH.method("nearest", Nearest, source="Somebody 2000")
def match_within(detections, rig, *, method):
    return match_nearest(detections, rig, method=NearestEpipolar(search_band=method.width))
'''

ASKED = """
import json, sys
import kinemark.match
new, folder = sys.argv[1:]
sys.modules["kinemark.match"].__path__.append(new)  # as if the file lay beside the others
from kinemark.data import KinemarkError
from kinemark.engine.session import Session
from kinemark.engine.settings import methods_figures, methods_text, session_schema

def refused(*overrides):
    try:
        Session.open(folder, overrides=["track.method=distance_only", "match.method=nearest", *overrides])
    except KinemarkError as error:
        return str(error)

ran = Session.open(folder, overrides=["track.method=distance_only", "match.method=nearest", "match.width=1.25"]).run()
print(json.dumps({
    "steps": ran["one"].quality["steps"],
    "figures": methods_figures("match")["match"]["methods"],
    "text": methods_text("match"),
    "schema": session_schema(),
    "refused": [refused("match.width=10"), refused("match.widht=1")],
}))
"""


def test_one_new_file_is_a_new_method_everywhere(tmp_path):
    """In the stage's function, session files, `--set`, `kinemark methods` and the JSON schema."""
    for name in ("new", "session"):
        (tmp_path / name).mkdir()
    (tmp_path / "new/nearest.py").write_text(NEW)
    folder, *_ = folder_of(tmp_path / "session", n_cameras=2)
    command = [sys.executable, "-c", ASKED, str(tmp_path / "new"), str(folder)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    steps = {step["stage"]: step for step in found["steps"]}
    assert steps["match"]["method"] == "Nearest" and steps["match"]["parameters"] == {"width": 1.25}
    told = found["figures"]["nearest"]
    assert told["source"] == "Somebody 2000" and told["parameters"]["width"]["high"] == 9
    assert "half width of the band" in found["text"]
    assert {"$ref": "#/$defs/match.nearest"} in found["schema"]["properties"]["match"]["anyOf"]
    assert found["schema"]["$defs"]["match.nearest"]["properties"]["width"]["maximum"] == 9
    assert "width is 10.0, wanted a number above 0 to 9 px" in found["refused"][0]
    assert "did you mean 'width'" in found["refused"][1]


def test_a_method_that_is_declared_elsewhere_is_one_too():
    stage = Stage("odd", "kinemark.match", default="mine", meaning="nothing")

    @dataclass(frozen=True, slots=True)
    class Mine(Method):
        """Mine."""

        much: float = parameter(1.0, unit="mm", above=0, meaning="how much")

    @stage.method("mine", Mine)
    def do(*, method):
        return method.much

    assert stage.function(stage.make(much=2.0))(method=Mine(3.0)) == 3.0
    assert stage.of(Mine()).name == "mine" and list(stage) == ["mine"]
    with pytest.raises(ValueError, match="no method of the stage odd; there are mine"):
        stage.of(Linear())

    @dataclass(frozen=True, slots=True)
    class Unsaid(Method):
        """It does not say what its field is."""

        much: float = 1.0

    with pytest.raises(TypeError, match=r"much is not declared, wanted much: … = parameter\(…\)"):
        stage.declare(Declaration("odd", "unsaid", Unsaid))
    with pytest.raises(ValueError, match="has a method 'mine' already"):
        stage.declare(Declaration("odd", "mine", replace(stage["mine"]).kind.__mro__[1]))


def test_a_method_that_takes_something_else_is_refused():
    with pytest.raises(ValueError, match=r"simultaneous takes no cloud, wanted one of .*kiss_tracking"):
        track(None, method=TRACK.make("simultaneous"))
    with pytest.raises(ValueError, match="auto takes no input here"):
        filler_of(Auto())
    assert "kalman_angles" not in automatic() and set(automatic()) < set(FILL)


# ---- Stages run at the bounds of their methods ----

RIG = ring(3)
POINTS = swarm(n=3, frames=12)
SEEN, _ = observe(RIG, POINTS, noise=0.1)
IMAGES = np.zeros((2, 40, 60), np.uint8)
IMAGES[:, 8:14, 10:17], IMAGES[:, 20:26, 30:44], IMAGES[1, 33:35, 50] = 220, 180, 255
MOTION = moving(frames=60, markers=5).hidden([Gap(1, 20, 32)])


def runs(stage, method):
    """Do a stage with a method on something tiny."""
    if stage is DETECT:
        return detect_frames(IMAGES, method=method)
    if stage is MATCH:
        two = method == replace(method) and type(method) is MATCH["nearest_epipolar"].kind
        rig = RIG.select(RIG.names[:2]) if two else RIG
        return match(SEEN.select(rig.names), rig, method=method)
    cloud = match(SEEN, RIG)
    if stage is RECONSTRUCT:
        return reconstruct(cloud, SEEN, RIG, method=method)
    if stage is FILL:
        return filler_of(method)(MOTION, [Gap(1, 20, 32)], method=method)
    if not matches_itself(method):
        return track(reconstruct(cloud, SEEN, RIG), method=method)
    rig = RIG.select(RIG.names[:2]) if type(method) is TRACK["former_two_cameras"].kind else RIG
    return track_detections(SEEN.select(rig.names), rig, method=method)


AT_BOUNDS = [
    (stage, declared, p, value)
    for stage in (DETECT, MATCH, RECONSTRUCT, TRACK, FILL)
    for declared in stage.values()
    if declared.function
    for p in declared.stateable
    for value in ([*p.choices] or ([True, False] if p.kind == "true or false" else []) or inside(p))
    if p.kind != "list" and value not in (math.inf,)
]


@pytest.mark.parametrize(
    ("stage", "declared", "p", "value"), AT_BOUNDS, ids=[f"{d.name}.{p.name}={v}" for _, d, p, v in AT_BOUNDS]
)
def test_a_stage_runs_with_every_parameter_at_its_bounds(stage, declared, p, value):
    try:
        method = made(declared, p, value)
    except ValueError as error:  # this one alone does not go with the others' defaults
        assert "differences" in str(error)
        return
    try:
        assert runs(stage, method) is not None
    except KinemarkError as error:
        assert str(error)  # it says what to do; that is an answer, too


# ---- What is written down of a method ----


def model(n=5000, at=None):
    """An angle model of one segment at n steps; `at` one step of which the direction is another."""
    direction = np.tile([0.0, 0.0, 1.0], (1, n, 1))
    if at is not None:
        direction[0, at] = [1.0, 0.0, 0.0]
    return AngleModel(
        ("A", "B"), np.array([[0, 1]]), np.zeros(1, int), np.array([300.0]), np.ones(1), direction,
        np.zeros((1, n, 3, 3)), np.ones((1, n), int), 1.0,
    )  # fmt: skip


def written(method):
    return json.dumps(plain_parameters(method), allow_nan=False)


def test_a_method_that_holds_arrays_is_written_by_their_content():
    one = LimbAngles(model=model())
    assert json.loads(written(one))["model"]["direction"]["shape"] == [1, 5000, 3]
    assert written(one) == written(LimbAngles(model=model()))
    assert written(one) != written(LimbAngles(model=model(at=2500)))  # where NumPy's text has an ellipsis
    assert written(KalmanAngles(limbs=one)) != written(KalmanAngles(limbs=LimbAngles(model=model(at=2500))))
    assert len(written(one)) < 3000


def test_methods_in_a_method_are_told_apart_and_infinity_has_a_word():
    assert written(Auto((Linear(),))) != written(Auto((Quintic(),)))
    assert written(STAGES["calibrate"].make("dlt", reject=np.inf)) == '{"reject": "inf"}'
    assert plain_parameters(None) == {}
    big = np.arange(8, dtype=">f8")
    assert plain_parameters(Holder(big)) == plain_parameters(Holder(big.astype("<f8")))
    with pytest.raises(TypeError, match="what is a object, wanted a plain value"):
        plain_parameters(Holder(object()))


@dataclass(frozen=True)
class Holder:
    """Something that holds anything."""

    what: object


# ---- Lists for reading ----


def test_the_lists_tell_all_of_every_parameter():
    figures, text, pages = methods_figures(), " ".join(methods_text().split()), methods_table_markdown()
    for declared, p in EACH:
        if p.stateable:
            told = figures[declared.stage]["methods"][declared.name]["parameters"][p.name]
            assert (told["meaning"], told["wanted"]) == (p.meaning, p.wanted())
            assert f"| `{p.name}` |" in pages and p.meaning in pages and p.meaning.split(";")[0][:25] in text
    for stage, common in COMMON.items():
        for p in common:
            assert figures[stage]["parameters"][p.name]["meaning"] == p.meaning
    json.dumps(figures, allow_nan=False)
