"""A walk of which one leg has no markers: the other one's numbers are those of the whole set."""

from dataclasses import replace

import numpy as np
import pytest

from kinemark.data import KinemarkError, MarkerTrajectory
from kinemark.data.laboratory_axes import up_shown
from kinemark.data.model_markers import LEG_MARKERS
from kinemark.data.subject_measures import LETTER
from kinemark.engine.gait.files import gait_of_files
from kinemark.engine.gait.settings import GaitSettings
from kinemark.engine.gait.trial_files import SubjectFiles
from kinemark.gait import marker_points
from kinemark.io.trial import write_trial
from kinemark.report.gait_page import harmonics_table, key_values_table, time_distance_table
from kinemark.report.gait_text import gait_summary
from kinemark.synth import WalkingBody, gait_laboratory
from support.shift_gait import MEASURES

SETTINGS = GaitSettings(uncertainty=False, smoothing="none")  # else its cut-off is learned from all markers


def bare(trial, *sides):
    gone = {LETTER[side] + name for side in sides for name in LEG_MARKERS}
    paths = tuple(path for path in trial.trajectories if path.name not in gone)
    return replace(trial, trajectories=replace(trial.trajectories, paths=paths))


@pytest.fixture(scope="module")
def lab():
    return gait_laboratory(WalkingBody(MEASURES), duration_s=3.0)


def gait(folder, lab, *sides, measures=MEASURES):
    walk, static = folder / "walk.c3d", folder / "static.c3d"
    write_trial(bare(lab.walk, *sides), walk)
    write_trial(bare(lab.static, *sides), static)
    return gait_of_files(
        SubjectFiles([walk], static=static, measures=measures),
        folder=folder / "gait",
        settings=SETTINGS,
        self_contained=False,
    )


@pytest.mark.parametrize("side", ["left", "right"])
def test_the_leg_that_is_there_has_the_numbers_of_both_legs(tmp_path, lab, side):
    """The whole report was refused: the model wants the markers LTHI, LKNE, ..."""
    other = {"left": "right", "right": "left"}[side]
    (tmp_path / "both").mkdir()
    (tmp_path / "one").mkdir()
    both, one = gait(tmp_path / "both", lab), gait(tmp_path / "one", lab, side)
    was, now = (each.trials[0].gait.signals for each in (both, one))
    for name in ("KneeAngles", "HipAngles", "AnkleAngles", "KneeMoment"):
        a, b = (each[LETTER[other] + name].values for each in (now, was))
        known = np.isfinite(a) & np.isfinite(b)  # of moments the last frame before a strike goes by the events
        assert known.sum() > 0.95 * np.isfinite(b).sum() > 0
        np.testing.assert_allclose(a[known], b[known], atol=1e-9)
    assert any(curve.side == other for curve in one.curves) and not any(curve.side == side for curve in one.curves)
    averages = one.figures["time_distance"]
    assert averages[other]["stride_length"]["mean"] == pytest.approx(
        both.figures["time_distance"][other]["stride_length"]["mean"], rel=0.01
    )  # events by the markers of both feet are a few ms others
    widths = averages[other]["step_width"]
    assert widths["mean"] is None and widths["sd"] is None  # it had a deviation of nothing
    told = [found for found in one.figures["findings"] if found["kind"] == "gait_one_leg"]
    assert [found["values"]["side"] for found in told] == [side] and f"{side} leg" in told[0]["text"]
    assert not any(found["kind"] in ("contact_left_out", "file_events_not_found") for found in one.figures["findings"])


def test_measures_of_a_leg_without_markers_are_the_others(tmp_path, lab):
    found = gait(tmp_path, lab, "left", measures=None).figures
    assert found["measures"]["left"]["leg_mm"] == found["measures"]["right"]["leg_mm"]


@pytest.mark.parametrize("side", ["left", "right"])
def test_tables_of_one_leg_have_no_columns_of_dashes(tmp_path, lab, side):
    """Time and distance and the key values kept the columns of the other leg, and the difference of both, empty."""
    found = gait(tmp_path, lab, side).figures
    assert found["key_values"]
    tables = [time_distance_table(found), key_values_table(found, angles=True), key_values_table(found, angles=False)]
    for table in tables:
        assert not any(side in head or "left − right" in head for head in table.head) and table.head[1:]
        assert all(set(cells) != {"–"} for cells in zip(*table.rows, strict=True))
    assert side not in gait_summary(found).split("walking speed")[0].splitlines()[-1]
    note = harmonics_table(found).note
    assert f"Hz on the {side}" not in note and note.count(" Hz") == 1


def test_a_pelvis_without_legs_is_refused(tmp_path, lab):
    with pytest.raises(KinemarkError, match="LTHI"):
        gait(tmp_path, lab, "left", "right")


@pytest.mark.parametrize("side", ["left", "right"])
def test_a_standing_trial_without_a_leg_that_the_walk_has_is_refused(tmp_path, lab, side):
    """The ankle's angles were 9° off, and nothing said why."""
    refused = refusal(tmp_path, lab.walk, bare(lab.static, side))
    assert f"walk: The standing trial static never shows the {side} leg" in refused and OR_NONE in refused
    assert gait_of_files(
        SubjectFiles([tmp_path / "walk.c3d"], measures=MEASURES), settings=SETTINGS
    ).curves  # what it says is so


OR_NONE = "Or leave the standing trial out"


def refusal(folder, walk, static, measures=MEASURES):
    """What is said where nothing can be made of both."""
    write_trial(walk, folder / "walk.c3d")
    write_trial(static, folder / "static.c3d")
    with pytest.raises(KinemarkError) as refused:
        gait_of_files(
            SubjectFiles([folder / "walk.c3d"], static=folder / "static.c3d", measures=measures), settings=SETTINGS
        )
    return str(refused.value)


def without(trial, *names):
    paths = tuple(path for path in trial.trajectories if path.name not in names)
    return replace(trial, trajectories=replace(trial.trajectories, paths=paths))


@pytest.mark.parametrize("measures", [MEASURES, None])
def test_a_standing_trial_without_markers_is_named_and_may_be_left_out(tmp_path, lab, measures):
    """Without measures neither the file nor the markers were named: the left leg cannot be measured."""
    foot = ("LANK", "LHEE", "LTOE")
    refused = refusal(tmp_path, lab.walk, without(lab.static, *foot), measures)
    assert refused.startswith("static: ") and ", ".join(foot) in refused and OR_NONE in refused


def test_a_standing_trial_that_a_walk_has_its_heels_from_is_not_said_to_be_left_out(tmp_path, lab):
    refused = refusal(tmp_path, without(lab.walk, "LHEE"), without(lab.static, "RTOE"))
    assert refused.startswith("static: ") and OR_NONE not in refused


def test_markers_at_one_place_show_nothing(lab):
    """A file with the same numbers for all markers ended in a `ValueError`."""
    points = {name: np.full((3, 3), 70.0) for name in marker_points(lab.walk)}
    np.testing.assert_array_equal(up_shown(points), [0, 0, 1])


def test_one_leg_shows_what_is_up(lab):
    points = marker_points(bare(lab.walk, "left"))
    turned = {name: xyz[:, [1, 2, 0]] for name, xyz in points.items()}  # y goes up
    np.testing.assert_array_equal(up_shown(turned), [0, 1, 0])


def unseen(trial, *names):
    """A trial that names these markers and never shows them."""
    nowhere = np.full((trial.trajectories.n_frames, 3), np.nan)
    gone = [MarkerTrajectory.measured(p.name, nowhere) if p.name in names else p for p in trial.trajectories]
    return replace(trial, trajectories=replace(trial.trajectories, paths=tuple(gone)))


def test_a_heel_that_a_walk_names_and_never_shows_comes_from_the_standing_trial(tmp_path, lab):
    """The left side had no strides, and nothing said why."""
    write_trial(unseen(lab.walk, "LHEE"), tmp_path / "walk.c3d")
    write_trial(lab.static, tmp_path / "static.c3d")
    found = gait_of_files(
        SubjectFiles([tmp_path / "walk.c3d"], static=tmp_path / "static.c3d", measures=MEASURES), settings=SETTINGS
    )
    assert found.figures["time_distance"]["left"]["stride_time"]["strides"] > 0
    kinds = {one["kind"]: one for one in found.figures["findings"]}
    assert "LHEE" in kinds["gait_heels_from_static"]["text"] and "gait_markers_never_seen" not in kinds


def test_a_toe_that_a_walk_names_and_never_shows_is_told(tmp_path, lab):
    write_trial(unseen(lab.walk, "LTOE"), tmp_path / "walk.c3d")
    write_trial(lab.static, tmp_path / "static.c3d")
    found = gait_of_files(
        SubjectFiles([tmp_path / "walk.c3d"], static=tmp_path / "static.c3d", measures=MEASURES), settings=SETTINGS
    )
    told = [one["text"] for one in found.figures["findings"] if one["kind"] == "gait_markers_never_seen"]
    assert len(told) == 1 and "LTOE is never seen" in told[0]
