"""The JSON schema of session.toml takes the sessions that Kinemark takes, and refuses wrong ones."""

import json
import tomllib
from pathlib import Path

import pytest
from jsonschema import Draft202012Validator
from pydantic import ValidationError

from kinemark.apps.commands.listings import schema as schema_command
from kinemark.engine.settings import SETTABLE, Settings, session_schema
from kinemark.engine.settings.read import overridden
from kinemark.findings.schema import quality_schema
from support.calibrations import BY_POINTS, BY_WAND, HEAD, L_FRAME, TAIL

SCHEMA = session_schema()
FILE = 'file = "rig.toml"'
FRAME = 'control_frame = { rods = "rods.toml", images = "calib/{camera}.png" }'
MARKER = 'single_marker = { images = "led/{camera}.mkv", distance = { mm = 500, detections = "two.csv" } }'
GRID = 'linearisation = { grid = [9, 7], pitch_mm = 30, images = "grid/{camera}.png" }'


def text(calibration=FILE, more="", head=HEAD, tail=TAIL):
    return f"{head}[calibration]\n{calibration}\n{tail}\n{more}"


RIGHT = {
    "plain": text(),
    "control points": text(BY_POINTS),
    "lenses": text(f"{BY_POINTS}\n{GRID}", '[calibrate]\nmethod = "dlt"\nreject = 4'),
    "control frame": text(FRAME, "[calibrate]\nradial = 2"),
    "wand": text(f"{BY_WAND}\n{L_FRAME}", "[calibrate]\nsquare_pixels = false\nmost_poses = 300"),
    "single marker": text(MARKER, '[calibrate]\nmethod = "bundle"\nseed = 3'),
    "marks": text(f"{FILE}\nreference_marker = {{ c0 = [[1.5, 2]] }}\nmark_reach_px = 3"),
    "masks": text(more='[masks]\nempty = "empty/{camera}.png"\ngrow_px = 2'),
    "infinite": text(BY_POINTS, "[calibrate]\nreject = inf"),
    "digitise": text(more='[digitise]\nmarkers = ["A", "B"]\nreference = "B"'),
    "fill": text(more='[fill]\nmethod = "kalman"\nmode = "forward"\nlimit_mm = 5\nends = true'),
    "subjects": text(
        more='[label]\ngrow = false\n[label.subjects.A]\ntemplate = ["a.c3d"]\n[label.subjects.B-2]\nheight_mm = 1400\n'
        'marker_set = "kiss-15"'
    ),
    "auto": text(more='[fill]\ncandidates = ["linear", "body"]'),
    "stages": text(
        more='[detect]\nmethod = "kiss_scanning"\nthreshold = 40\n[match]\nsearch_band = 1\n'
        '[reconstruct]\nmarker_diameter = 14.5\n[track]\nmethod = "swamidas"\nlinks = [[0, 1]]\nlengths = [300.0]'
    ),
}

WRONG = {
    "no name": text(head=HEAD.replace('name = "lab"', "")),
    "no trials": text(tail=""),
    "unknown key": text(head="treshold = 3\n" + HEAD),
    "unknown table": text(more="[trakc]\n"),
    "unknown parameter": text(more="[track]\ngaet = 3"),
    "another method's parameter": text(more='[track]\nmethod = "kiss_tracking"\ngate = 3'),
    "unknown method": text(more='[track]\nmethod = "magic"'),
    "text for a number": text(more='[track]\ngate = "far"'),
    "at a bound": text(more="[track]\ngate = 0"),
    "beyond a bound": text(more="[detect]\nthreshold = 255"),
    "no whole number": text(more="[detect]\nmin_area = 2.5"),
    "a subject's key": text(more='[label.subjects.A]\nsubject = "A"'),
    "a subject's height": text(more="[label.subjects.A]\nheight_mm = 0"),
    "no choice": text(more='[track]\nmethod = "extrapolation_ladder"\n[match]\npairs = "some"'),
    "an element": text(more='[track]\nmethod = "swamidas"\nlinks = [[0, 1]]\nlengths = [0.0]'),
    "no pair": text(more='[track]\nmethod = "swamidas"\nlinks = [[0, 1, 2]]'),
    "rate": text(head=HEAD.replace("50.0", "-3")),
    "no way": text(""),
    "two ways": text(f"{FILE}\n{BY_WAND}"),
    "another way's method": text(BY_WAND, '[calibrate]\nmethod = "dlt"'),
    "another way's parameter": text(BY_POINTS, "[calibrate]\nmost_poses = 300"),
    "no source": text(tail='[[trials]]\nname = "one"'),
    "two sources": text(tail=TAIL + 'images = "one.mkv"'),
    "interlaced": text(head=HEAD + 'interlaced = "left"\n'),
    "masks of nothing": text(more="[masks]\ngrow_px = 2"),
    "no markers": text(more="[digitise]\ngrid = 7"),
    "common parameter": text(more="[fill]\nlimit_mm = 0"),
}


def errors(table):
    return [error.message for error in Draft202012Validator(SCHEMA).iter_errors(table)]


def test_it_is_a_schema_and_plain_json():
    Draft202012Validator.check_schema(SCHEMA)
    assert json.loads(json.dumps(SCHEMA, allow_nan=False)) == SCHEMA
    assert '"null"' not in json.dumps(SCHEMA)


@pytest.mark.parametrize("name", RIGHT)
def test_right_sessions_are_taken(name):
    table = tomllib.loads(RIGHT[name])
    Settings.model_validate(table)
    assert errors(table) == []


@pytest.mark.parametrize("name", WRONG)
def test_wrong_sessions_are_refused(name):
    table = tomllib.loads(WRONG[name])
    with pytest.raises(ValidationError):
        Settings.model_validate(table)
    assert errors(table)


def test_the_session_of_the_documentation_is_taken():
    page = Path(__file__).parents[3] / "docs" / "session.md"
    table = tomllib.loads(page.read_text("utf-8").split("```toml\n")[1].split("```")[0])
    Settings.model_validate(table)
    assert errors(table) == []


@pytest.mark.parametrize("stage", SETTABLE)
def test_every_method_can_be_named(stage):
    way = {"wand": BY_WAND, "bundle": MARKER, "control_points": BY_POINTS, "dlt": FRAME}
    for name in SETTABLE[stage]:
        needed = 'markers = ["A"]' if stage == "digitise" else ""
        table = tomllib.loads(text(way.get(name, FILE), f'[{stage}]\nmethod = "{name}"\n{needed}'))
        assert errors(table) == []
        assert errors(overridden(table, [f"{stage}.nothing=3"]))


def test_everything_in_it_is_described():
    for name, model in SCHEMA["$defs"].items():
        assert model["description"], name
        for key, field in model["properties"].items():
            assert field["description"], f"{name}.{key}"
    for key, field in SCHEMA["properties"].items():
        assert field["description"], key


def test_the_command_prints_it(capsys):
    schema_command()
    assert json.loads(capsys.readouterr().out) == SCHEMA
    schema_command("quality")
    assert json.loads(capsys.readouterr().out) == quality_schema()
