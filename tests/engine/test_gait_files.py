"""`kinemark gait`: from files to results."""

import csv
import json

import numpy as np
import pytest

from kinemark.data import KinemarkError, Trial
from kinemark.engine.gait_files import GaitSettings, gait_of_files
from kinemark.io.c3d import write_c3d
from kinemark.io.trial import read_trial
from kinemark.synth import walking
from support.plug_in_gait import ADULT
from support.shared import shared_data

MEASURES = """
mass_kg = 70
[left]
leg_mm = 890
knee_mm = 105
ankle_mm = 72
[right]
leg_mm = 890
knee_mm = 105
ankle_mm = 72
"""
QUICK = GaitSettings(uncertainty=False)


@pytest.fixture
def walk(tmp_path):
    """A simulated walk without plates, and measures."""
    subject = walking(duration_s=5.0, rate=100.0, seed=1)
    write_c3d(tmp_path / "walk.c3d", Trial("walk", subject.trajectories))
    (tmp_path / "anna.toml").write_text(MEASURES, encoding="utf-8")
    return tmp_path


def test_a_walk_gives_page_tables_figures_and_a_file(walk):
    found = gait_of_files([walk / "walk.c3d"], measures=walk / "anna.toml", settings=QUICK)
    assert found.folder == walk / "walk_gait"
    figures = json.loads((found.folder / "gait.json").read_text())
    speed = figures["time_distance"]["left"]["speed"]["mean"]
    assert speed == pytest.approx(1100, rel=0.02)
    page = (found.folder / "gait.html").read_text()
    assert "Knee flexion" in page and "walking speed" in page
    with (found.folder / "curves.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 101 and 50 < max(float(r["LKneeAngles_flexion_deg"]) for r in rows) < 75
    back = read_trial(found.folder / "walk_gait.c3d")
    assert "LKneeAngles" in back.signals.names and len(back.events) > 8
    assert {f["kind"] for f in figures["findings"]} >= {"gait_without_moments", "foot_offsets_unknown"}


def test_error_bars_are_on_every_curve(walk):
    found = gait_of_files(
        [walk / "walk.c3d"], static=walk / "walk.c3d", measures=walk / "anna.toml", folder=walk / "out"
    )
    knee = next(c for c in found.curves if c.name == "LKneeAngles")
    assert (knee.measurement_sd[:, 0] > 0.5).all()
    assert {"placement", "hip centre"} <= set(found.figures["uncertainty"][0]["by_cause"])


def test_several_walks_count_together(walk):
    two = gait_of_files([walk / "walk.c3d"] * 2, measures=walk / "anna.toml", folder=walk / "two", settings=QUICK)
    one = gait_of_files([walk / "walk.c3d"], measures=walk / "anna.toml", folder=walk / "one", settings=QUICK)
    assert len(two.curves[0].values) == 2 * len(one.curves[0].values)


def test_without_measures_it_is_said_what_to_give(walk):
    with pytest.raises(KinemarkError, match="--measures"):
        gait_of_files([walk / "walk.c3d"], settings=QUICK)
    with pytest.raises(KinemarkError, match="one or more"):
        gait_of_files([])


def test_nothing_that_was_given_is_changed(walk):
    before = (walk / "walk.c3d").read_bytes()
    gait_of_files([walk / "walk.c3d"], measures=walk / "anna.toml", settings=QUICK)
    assert (walk / "walk.c3d").read_bytes() == before


def test_a_foot_beside_the_plates_has_no_moments(tmp_path):
    found = gait_of_files(
        [shared_data(f"mocap3d/{ADULT}Motion3_FF.c3d")], static=shared_data(f"mocap3d/{ADULT}Calibration3_FF.c3d"),
        folder=tmp_path, settings=QUICK,
    )  # fmt: skip
    right = next(c for c in found.curves if c.name == "RAnkleMoment")
    stance = right.values[:, 20:50, 0]
    whole = np.isfinite(stance).all(1)
    assert whole.any() and not whole.all()
    assert np.nanmin(np.nanmax(stance[whole], axis=1)) > 1.0  # N·m/kg of push-off, in every stride that has one
