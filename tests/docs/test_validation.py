"""Figures that are kept say how they were made, and comparing them with new ones notices what is worse, no more."""

import importlib.util
import re
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT / "benchmarks"))

from metrics import Metric, is_worse  # noqa: E402


def loaded(path):
    """A program of the project as a module."""
    spec = importlib.util.spec_from_file_location(path.stem, path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


generate = loaded(ROOT / "docs" / "validation" / "generate.py")
STUDIES = generate.studies()


@pytest.mark.parametrize("name", STUDIES)
def test_a_study_is_there_and_what_is_kept_of_it_says_how_it_was_made(name):
    study = STUDIES[name]
    assert (ROOT / study["command"].split()[0]).is_file() and study["seed"]
    facts, output = generate.kept(name)
    assert facts.keys() == {"command", "seed", "date", "version", "machine", "seconds"}
    assert facts["command"] == f"python {study['command']}" and facts["seed"] == study["seed"]
    assert output.strip()


def test_the_page_of_results_is_made_of_what_is_kept():
    assert generate.PAGE.read_text(encoding="utf-8") == generate.page()


@pytest.mark.parametrize("name", STUDIES)
def test_what_is_quoted_is_called_so_in_what_is_printed_and_above_it(name):
    """Figures of papers beside computed ones are never without the word; nor is the word without such figures."""
    output, above = generate.kept(name)[1], STUDIES[name].get("quoted", "")
    said, told = (bool(re.search("quoted|published", text)) for text in (output, above))
    assert said == told, above
    others = re.findall(r"\((?:the |naive|aim|best|known|paper|thesis)[^)]*\d[^)]*\)", output)
    assert [words for words in others if "quoted" not in words] == []


SAID = "RMSE   0.42 mm, 15 of 15 markers, 2.5e-07\ntook 3.2 s\n"


@pytest.mark.parametrize("name", STUDIES)
def test_an_output_does_not_differ_from_itself(name):
    output = generate.kept(name)[1]
    assert generate.differences(STUDIES[name], output, output) == []


@pytest.mark.parametrize(
    ("after", "differs"),
    [
        (SAID, False),
        (SAID.replace("0.42", "0.43"), False),  # a unit of the last digit
        (SAID.replace("0.42", "0.45"), True),
        (SAID.replace("15 of", "14 of"), True),
        (SAID.replace("2.5e-07", "2.7e-07"), True),
        (SAID.replace("RMSE", "error"), True),
        (SAID.replace("3.2 s", "9.9 s"), False),  # a time
        (SAID + "more\n", True),
    ],
)
def test_outputs_differ_by_words_counts_and_figures_but_not_by_time(after, differs):
    assert bool(generate.differences({"ignore": [r"took .*"]}, SAID, after)) == differs


@pytest.mark.parametrize(
    ("better", "value", "worse"),
    [
        ("less", 1.04, False), ("less", 1.2, True), ("less", 0.1, False), ("less", float("nan"), True),
        ("more", 0.96, False), ("more", 0.8, True), ("more", 9.0, False), ("more", float("nan"), True),
        ("near", 1.04, False), ("near", 1.2, True), ("near", 0.8, True), ("near", float("nan"), True),
    ],
)  # fmt: skip
def test_a_metric_is_worse_beyond_its_tolerance_in_its_direction(better, value, worse):
    assert is_worse(Metric("m", value, "mm", better, relative=0.05), 1.0) == worse
    assert is_worse(Metric("m", value, "mm", better, absolute=0.05), 1.0) == worse


def test_the_baseline_states_unit_direction_and_tolerance_of_each_metric():
    import tomllib

    known = tomllib.loads((ROOT / "benchmarks" / "baseline.toml").read_text(encoding="utf-8"))
    suite = {"detection", "detection_speed", "recording", "tracking", "tracking_scenes", "bundle", "gaps"}
    suite |= {"labelling", "startup", "pages"}
    assert known.keys() == suite
    for metrics in known.values():
        for entry in metrics.values():
            assert entry.keys() == {"value", "unit", "better", "relative", "absolute"}
            assert entry["better"] in ("less", "more", "near") and min(entry["relative"], entry["absolute"]) >= 0
