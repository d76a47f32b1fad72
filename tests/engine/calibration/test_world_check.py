"""What shows the world is recorded apart from the wand: cameras and points that are wrong there are left out."""

import numpy as np
import pytest

from kinemark.data import Detections
from kinemark.geometry import project_all
from kinemark.io.detections_csv import read_detections_csv, write_detections_csv
from kinemark.report.words import text_of
from support.calibrations import BY_WAND, L_FRAME, POINTS, SMALL, detected, lay_out_wand, off, points_csv, session
from support.findings import found, kinds
from support.schema import check_findings

CORNER = np.repeat(np.array([[0, 0, 12.5], [800, 0, 12.5], [0, 600, 12.5]], float)[:, None], 10, 1)


@pytest.fixture
def folder(tmp_path):
    lay_out_wand(tmp_path / "s")
    return tmp_path / "s"


def test_a_camera_that_was_moved_after_the_wand_does_not_move_the_world(folder):
    seen = detected(CORNER, noise=0.2)
    uv = seen.uv + np.where((seen.camera == 2)[:, None], [12.0, 5.0], 0.0)
    write_detections_csv(folder / "lframe.csv", Detections.build(seen.cameras, seen.rate, seen.counts, uv))
    made = session(folder, f"{BY_WAND}\n{L_FRAME}").calibrate()
    check_findings(made.figures)
    (said,) = found(made.figures, "world_seen_elsewhere")
    assert (said.severity, said.cameras) == ("amber", (SMALL.names[2],))
    assert said.values["offset_px"] == pytest.approx(13, abs=1)
    assert text_of(said).startswith(f"Camera {SMALL.names[2]} sees the L-frame")
    assert off(made.rig) < 0.3


def test_an_l_frame_that_two_cameras_see_needs_no_rows_of_the_others(folder):
    seen = detected(CORNER, noise=0.2)
    write_detections_csv(folder / "lframe.csv", seen.keep(seen.camera < 2))
    made = session(folder, f"{BY_WAND}\n{L_FRAME}").calibrate()
    assert not {"world_seen_elsewhere", "cameras_upside_down"} & set(kinds(made.figures))
    assert off(made.rig) < 0.5


def test_a_point_of_the_world_that_was_typed_wrongly_is_named_and_left_out(folder):
    points_csv(folder)
    rows = (folder / "points.csv").read_text().splitlines()
    name, x, rest = rows[5].split(",", 2)
    rows[5] = f"{name},{float(x) + 400},{rest}"
    (folder / "points.csv").write_text("\n".join(rows) + "\n")
    made = session(folder, f'{BY_WAND}\nworld_points = {{ points = "points.csv" }}').calibrate()
    check_findings(made.figures)
    (said,) = found(made.figures, "world_points_disagree")
    assert (said.severity, said.values["points_list"]) == ("amber", (name,))
    assert said.values["off_mm"] == pytest.approx(400, abs=3)
    assert off(made.rig) < 0.3
    assert f"Point {name} of the world lies up to 40" in text_of(said)


def test_a_camera_whose_images_of_the_points_are_beside_is_named_and_left_out(folder):
    uv = project_all(SMALL, POINTS) + 0.05 * np.random.default_rng(1).normal(size=(4, len(POINTS), 2))
    uv[1] += [-9.0, 4.0]
    points_csv(folder, uv=uv)
    made = session(folder, f'{BY_WAND}\nworld_points = {{ points = "points.csv" }}').calibrate()
    assert [one.cameras for one in found(made.figures, "world_seen_elsewhere")] == [(SMALL.names[1],)]
    assert "world_points_disagree" not in kinds(made.figures)
    assert off(made.rig) < 0.3


def test_pixels_counted_from_the_bottom_are_told_as_cameras_upside_down(folder):
    for name in ("wand", "lframe"):
        seen = read_detections_csv(folder / f"{name}.csv", rate=50.0, cameras=SMALL.names)
        uv = np.stack([seen.uv[:, 0], 479 - seen.uv[:, 1]], 1)
        write_detections_csv(folder / f"{name}.csv", Detections.build(seen.cameras, 50.0, seen.counts, uv))
    made = session(folder, f"{BY_WAND}\n{L_FRAME}").calibrate()
    check_findings(made.figures)
    assert "cameras_upside_down" in kinds(made.figures)
