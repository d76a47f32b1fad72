"""Two conditions: what differs by chance or by the measurement's error is no difference, and what is one is found."""

import csv
import json

import numpy as np
import pytest

from kinemark.apps.cli import app
from kinemark.data import KinemarkError, Trial
from kinemark.engine.gait.comparison import compare_gait
from kinemark.engine.gait.files import gait_of_files
from kinemark.engine.gait.settings import GaitSettings
from kinemark.engine.gait.trial_files import SubjectFiles
from kinemark.gait.comparison import Condition, difference, stretches
from kinemark.io.c3d import write_c3d
from kinemark.synth import walking
from support.drawings import check_page
from support.pages import data_of

PERCENT = np.linspace(0, 2 * np.pi, 101)


def condition(rng, strides, *, error, vary=3.0, shift=0.0):
    """Strides of one curve that differ smoothly, with an error of the whole measurement."""
    waves = np.stack([np.ones(101), np.cos(PERCENT), np.sin(PERCENT), np.cos(2 * PERCENT), np.sin(2 * PERCENT)])
    values = rng.normal(size=(strides, 5)) @ waves * vary / np.sqrt(3) + error * rng.normal() + shift
    spread = values.std(0, ddof=1) if strides > 1 else np.full(101, np.nan)
    return Condition(values.mean(0)[:, None], spread[:, None], np.full((101, 1), error), strides)


@pytest.mark.parametrize(("n", "m"), [(2, 2), (3, 8), (1, 4), (12, 12)])
@pytest.mark.parametrize("error", [0.0, 4.0])
def test_differences_by_chance_are_rare_at_each_point(n, m, error):
    rng = np.random.default_rng(8)
    claimed = [difference(condition(rng, n, error=error), condition(rng, m, error=error)).exceeds for _ in range(400)]
    assert np.mean(claimed) < 0.055
    assert np.mean([bool(stretches(one[:, 0])) for one in claimed]) < 0.09, "of whole curves"


@pytest.mark.parametrize("n", [3, 8])
def test_true_differences_are_found_and_have_their_size(n):
    rng = np.random.default_rng(8)
    found = [difference(condition(rng, n, error=2.0), condition(rng, n, error=2.0, shift=20.0)) for _ in range(50)]
    assert np.mean([one.exceeds for one in found]) > 0.95
    assert np.mean([one.value for one in found]) == pytest.approx(20.0, abs=1.5)


def test_one_number_and_what_is_unknown():
    one = Condition(np.array(1.0), np.array(0.1), np.array(0.0), 10)
    assert difference(one, one._replace(mean=np.array(1.3))).exceeds
    assert not difference(one, one._replace(mean=np.array(1.05))).exceeds
    alone = Condition(np.array(1.0), np.array(np.nan), np.array(0.1), 1)
    found = difference(alone, alone._replace(mean=np.array(9.0)))
    assert np.isnan(found.error) and not found.exceeds


def test_short_stretches_are_chance():
    exceeds = np.zeros(101, bool)
    exceeds[10:14] = exceeds[50:60] = exceeds[98:] = True
    assert stretches(exceeds) == [(50, 59)]


@pytest.fixture(scope="module")
def conditions(tmp_path_factory):
    """Gait of one person at two speeds, and again at the first."""
    folder = tmp_path_factory.mktemp("compared")
    for name, seed, speed in (("slow", 1, 900.0), ("again", 2, 900.0), ("fast", 3, 1500.0)):
        subject = walking(duration_s=5.0, rate=50.0, seed=seed, speed_mm_s=speed, wobble_mm=2.0)
        write_c3d(folder / f"{name}.c3d", Trial(name, subject.trajectories))
        gait_of_files(
            SubjectFiles([folder / f"{name}.c3d"]), folder=folder / name, settings=GaitSettings(uncertainty=False)
        )
    return folder


def test_a_faster_walk_differs_and_the_same_does_not(conditions):
    fast = compare_gait(conditions / "slow", conditions / "fast", folder=conditions / "out").figures
    rows = {(row["name"], row["side"]): row for row in fast["time_distance"]}
    assert rows["speed", "left"]["exceeds"] and rows["speed", "left"]["difference"] == pytest.approx(600, rel=0.1)
    page = (conditions / "out/comparison.html").read_text()
    assert "walking speed" in page and "Knee flexion" in page and check_page(page)
    again = compare_gait(conditions / "slow", conditions / "again/gait.json", folder=conditions / "same").figures
    assert not any(row["exceeds"] for row in again["time_distance"] if row["name"] in ("speed", "stride_length"))
    differing = [part for row in again["curves"] for part in row["components"] if part["stretches"]]
    assert len(differing) <= 0.15 * sum(len(row["components"]) for row in again["curves"])


def test_heels_that_were_put_on_anew_explain_a_wider_step_and_many_strides_do_not_make_it_sure(conditions):
    table = json.loads((conditions / "slow/gait.json").read_text())

    def walked(name, width):
        """A folder with many strides of this step width, whose heels sit somewhere within 5 mm."""
        found = json.loads(json.dumps(table))
        known = {"mean": width, "spread": 3.0, "strides": 20, "sd": 7.1, "systematic_sd": 7.0}
        for side in ("left", "right"):
            found["time_distance"][side]["step_width"] = known
        (conditions / name).mkdir(exist_ok=True)
        (conditions / name / "gait.json").write_text(json.dumps(found))
        return conditions / name

    def exceeds(width, *, same_markers):
        one, two = walked("before", 90.0), walked("after", width)
        found = compare_gait(one, two, folder=conditions / "wider", same_markers=same_markers).figures
        return next(row["exceeds"] for row in found["time_distance"] if row["name"] == "step_width")

    assert not exceeds(102.0, same_markers=False) and exceeds(102.0, same_markers=True)
    assert exceeds(115.0, same_markers=False) and not exceeds(91.0, same_markers=True)


def test_key_values_are_compared_and_kept_for_statistics(conditions):
    """A knee that bends 25° more in swing, known to 3°, differs; a range, whose error nobody knows, is not judged."""
    table = json.loads((conditions / "slow/gait.json").read_text())

    def walked(name, more):
        found = json.loads(json.dumps(table)) | {"uncertainty": [{"name": "LKneeAngles", "by_cause": {}}]}
        for key in found["key_values"]:
            sd = None if key["name"].endswith("range") else 3.0
            key["left"] = {"mean": 40.0 + more, "spread": 2.0, "strides": 6, "sd": sd}
        (conditions / name).mkdir()
        (conditions / name / "gait.json").write_text(json.dumps(found))
        return conditions / name

    app(["gait-compare", str(walked("stiff", 0.0)), str(walked("freed", 25.0)), "-o", str(conditions / "keys")],
        result_action="return_value")  # fmt: skip
    with (conditions / "keys/comparison.csv").open(encoding="utf-8") as file:
        rows = {(row["name"], row["side"]): row for row in csv.DictReader(file)}
    swing, whole = rows["knee flexion, greatest in swing", "left"], rows["knee flexion, range", "left"]
    assert [float(swing[key]) for key in ("first", "second", "difference", "exceeds")] == [40, 65, 25, 1]
    assert 8 < float(swing["error_95"]) < 10  # 1.96 √(3² + 3²) and what strides differ
    assert (float(whole["difference"]), whole["error_95"], whole["exceeds"]) == (25, "", "")
    assert float(rows["knee flexion, greatest in swing", "right"]["difference"]) == 0
    assert ("speed", "left") in rows
    page = (conditions / "keys/comparison.html").read_text()
    assert "knee flexion, greatest in swing, left (°)" in page and "not judged" in page


def test_what_nobody_can_judge_is_told(conditions, capsys):
    """One stride of each condition says nothing of how strides differ: that is no proof that they are alike."""
    table = json.loads((conditions / "slow/gait.json").read_text())
    for name in ("one stride", "another stride"):
        found = json.loads(json.dumps(table))
        for curve in found["curves"]:
            if curve["name"] == "LKneeAngles":
                curve["spread"] = [[None] * 3 for _ in range(101)]
        (conditions / name).mkdir()
        (conditions / name / "gait.json").write_text(json.dumps(found))
    app(["gait-compare", str(conditions / "one stride"), str(conditions / "another stride"),
         "-o", str(conditions / "alone")], result_action="return_value")  # fmt: skip
    words = "Parts of curves knee flexion left, knee adduction left, knee rotation left are not judged"
    assert words in " ".join(capsys.readouterr().out.split())
    assert words in (conditions / "alone/comparison.html").read_text()


def test_a_measurement_whose_error_was_not_computed_is_told_and_its_ranges_are_not_judged(conditions, capsys):
    """Where markers sat may be all that differs, and the page must not say that it counts."""
    app(["gait-compare", str(conditions / "slow"), str(conditions / "fast"), "-o", str(conditions / "bare")],
        result_action="return_value")  # fmt: skip
    words = "The measurement's own error was not computed for slow and fast (--no-uncertainty)"
    said, page = " ".join(capsys.readouterr().out.split()), (conditions / "bare/comparison.html").read_text()
    assert words in said and words in page.replace("&#39;", "'")
    assert "where they sit counts in both" not in page
    with (conditions / "bare/comparison.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    ranges = [row["exceeds"] for row in rows if row["name"].endswith("range")]
    assert ranges and not any(ranges)
    assert f"{sum(not row['exceeds'] for row in rows)} are not judged." in said


def test_a_drawing_of_a_comparison_fits_a_page_of_paper_and_says_what_is_up(conditions):
    """270 mm of A4 are 1020 px, and drawings are printed at 0.8 of their size."""
    compare_gait(conditions / "slow", conditions / "fast", folder=conditions / "paper")
    figures = data_of((conditions / "paper/comparison.html").read_text())
    sides = [one for name, one in figures.items() if name.startswith(("left", "right"))]
    assert sides and all(0.8 * one["layout"]["height"] < 900 for one in sides)
    said = {note["text"] for one in sides for note in one["layout"]["annotations"]}
    assert {"flexion", "extension", "varus", "valgus", "<b>sagittal plane</b>"} <= said


def test_two_people_are_told(conditions, capsys):
    """Whoever takes the wrong folder sees it on the page and in the terminal; one spelling of a name is one person."""
    table = json.loads((conditions / "slow/gait.json").read_text())
    for name, subject in (("first", "Anna"), ("second", "anna"), ("stranger", "Ben")):
        (conditions / name).mkdir()
        (conditions / name / "gait.json").write_text(json.dumps(table | {"subject": subject}))
    for other, told in (("second", False), ("stranger", True)):
        into = conditions / f"with_{other}"
        app(["gait-compare", str(conditions / "first"), str(conditions / other), "-o", str(into)],
            result_action="return_value")  # fmt: skip
        words = "“first” is of Anna, and “stranger” is of Ben"
        said = " ".join(capsys.readouterr().out.split())
        assert (words in said) == (words in (into / "comparison.html").read_text()) == told
        assert "Strides: first" in said
        assert ('<li class="amber">' in (into / "comparison.html").read_text()) == told


def test_what_cannot_be_compared_is_refused(conditions):
    with pytest.raises(KinemarkError, match="with itself"):
        compare_gait(conditions / "slow", conditions / "slow", folder=conditions / "x")
    (conditions / "no.json").write_text("{}")
    with pytest.raises(KinemarkError, match=r"no gait\.json"):
        compare_gait(conditions / "slow", conditions / "no.json", folder=conditions / "x")
    other = json.loads((conditions / "fast/gait.json").read_text())
    earlier = other | {"curves": [other["curves"][0] | {"axes": ["x", "y", "z"]}]}  # as reactions once were
    (conditions / "earlier.json").write_text(json.dumps(earlier))
    with pytest.raises(KinemarkError, match="earlier version"):
        compare_gait(conditions / "slow", conditions / "earlier.json", folder=conditions / "x")
    (conditions / "other.json").write_text(json.dumps(other | {"method": {"name": "plug_in_gait"}}))
    with pytest.raises(KinemarkError, match="computed otherwise"):
        compare_gait(conditions / "slow", conditions / "other.json", folder=conditions / "x")
    assert not (conditions / "x").exists()
