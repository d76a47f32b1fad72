"""quality.json is what its schema says, and the schema is what the declarations say."""

import json
from importlib.resources import files

import jsonschema
import pytest

from kinemark.data import KINDS, make_finding
from kinemark.findings.schema import FILE, declared_schema, quality_schema, schema_text
from support.captures import capture, empty_capture, judge, ring, walk
from support.schema import check_quality


def test_the_shipped_schema_is_that_of_the_declarations():
    assert files("kinemark.findings").joinpath(FILE).read_text(encoding="utf-8") == schema_text()
    assert quality_schema() == declared_schema()
    jsonschema.Draft202012Validator.check_schema(quality_schema())


def good():
    rig = ring()
    return judge(rig, capture(rig, walk()))


def test_figures_follow_it_with_and_without_trajectories():
    check_quality(good())
    for frames in (0, 30):
        check_quality(judge(ring(), empty_capture(ring(), frames)))


@pytest.mark.parametrize(
    "spoil",
    [
        lambda q: q.pop("verdict"),
        lambda q: q.update(more=1),
        lambda q: q["recording"].update(frames=-1),
        lambda q: q["cameras"][0].update(used_share=1.5),
        lambda q: q["verdict"].update(grade="blue"),
        lambda q: q["findings"].append({"kind": "no_frames"}),
        lambda q: q["findings"].append(make_finding("no_frames").as_dict() | {"kind": "no_such"}),
        lambda q: q["findings"].append(make_finding("no_frames").as_dict() | {"stage": "fill"}),
        lambda q: q["findings"].append(make_finding("no_frames").as_dict() | {"values": {"x": 1}}),
        lambda q: q["findings"].append(make_finding("gaps_open", gaps=1).as_dict() | {"values": {"gaps": "one"}}),
    ],
)
def test_what_is_not_declared_is_refused(spoil):
    figures = good()
    spoil(figures)
    with pytest.raises(jsonschema.ValidationError):
        check_quality(figures)


def test_every_kind_is_in_it():
    schema = quality_schema()["$defs"]
    assert schema["FindingData"]["properties"]["kind"]["enum"] == list(KINDS)
    for name, kind in KINDS.items():
        values = schema[f"kind_{name}"]["then"]["properties"]["values"]
        assert values["required"] == list(kind.values) and not values["additionalProperties"]


def test_the_file_on_disk_is_plain_json(tmp_path):
    text = json.dumps(good(), allow_nan=False)
    check_quality(json.loads(text))
