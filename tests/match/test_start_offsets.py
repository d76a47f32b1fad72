"""Recordings that were started at different times are put together by what their markers show."""

import json

import numpy as np
import pytest

from kinemark.apps.cli import app
from kinemark.data import Detections, KinemarkError
from kinemark.engine.camera_checks.start_files import starts_of_files
from kinemark.io.detections_csv import write_detections_csv
from kinemark.io.rig_toml import write_rig_toml
from kinemark.match import start_offsets
from kinemark.synth import observe, ring, stationary, walking


def shifted(detections, late, frames):
    """Detections of which camera c was started late[c] frames after the first of all, of so many frames."""
    uv, counts = [], []
    for c, first in enumerate(late):
        rows = [detections[c, f] for f in range(first, first + frames)]
        uv += rows
        counts.append([len(row) for row in rows])
    return Detections.build(detections.cameras, detections.rate, counts, np.concatenate(uv))


@pytest.mark.parametrize(
    ("late", "cameras", "noise", "seed"),
    [((30, 0, 55, 12), 4, 0.3, 0), ((0, 70, 3, 0, 41, 20), 6, 0.1, 1), ((18, 60), 2, 0.2, 2), ((5, 5, 5), 3, 0.2, 3)],
)
def test_starts_are_found_to_the_image(late, cameras, noise, seed):
    rig = ring(cameras, distortion=(-0.1, 0, 0, 0, 0), sweep_deg=360.0 if cameras > 2 else 70.0)
    seen = observe(rig, walking(duration_s=3.0, seed=seed), noise_px=noise, false_per_frame=0.5, dropout=0.1, seed=seed)
    found = start_offsets(shifted(seen.detections, late, 75), rig, most=80)
    assert found.images.tolist() == [first - late[0] for first in late]
    assert len(found.disagreeing) <= 1 and (found.clearness[1:] >= 1.4).all()


def test_what_does_not_move_tells_nothing():
    rig = ring(3)
    still = stationary(("a", "b", "c"), np.array([[1000.0, 600, 800], [1300, 900, 500], [900, 500, 1200]]), radius_mm=7)
    frames = [observe(rig, still, noise_px=0.2, seed=k).detections for k in range(40)]
    uv = np.concatenate([one[c, 0] for c in range(3) for one in frames])
    counts = [[len(one[c, 0]) for one in frames] for c in range(3)]
    with pytest.raises(KinemarkError, match="must move"):
        start_offsets(Detections.build(rig.names, 50.0, counts, uv), rig, most=20)


def test_a_start_farther_off_than_asked_for_is_refused():
    rig = ring(3)
    seen = observe(rig, walking(duration_s=3.0), noise_px=0.2).detections
    with pytest.raises(KinemarkError, match="cam2"):
        start_offsets(shifted(seen, (0, 60, 0), 80), rig, most=20)


def test_the_command_says_what_to_write(tmp_path, capsys):
    rig = ring(3)
    seen = observe(rig, walking(duration_s=3.0), noise_px=0.2).detections
    write_detections_csv(tmp_path / "d.csv", shifted(seen, (10, 40, 0), 90))
    write_rig_toml(tmp_path / "rig.toml", rig)
    command = ["starts", str(tmp_path / "d.csv"), str(tmp_path / "rig.toml"), "--most-s", "1", "--rate-hz", "50"]
    app([*command, "--json"], result_action="return_value")
    assert json.loads(capsys.readouterr().out)["delays_ms"] == {"cam1": 0.0, "cam2": 600.0, "cam3": -200.0}
    app(command, result_action="return_value")
    assert "delays_ms = { cam1 = 0, cam2 = 600, cam3 = -200 }" in capsys.readouterr().out
    with pytest.raises(KinemarkError, match="no cameras"):
        starts_of_files(tmp_path / "d.csv", tmp_path / "d.csv", most_s=1.0, rate_hz=50.0)
    silent = (tmp_path / "rig.toml").read_text("utf-8").replace('units = "mm"\n', "")
    (tmp_path / "rig.toml").write_text(silent, "utf-8")
    with pytest.raises(KinemarkError, match="--length-unit"):
        app(command, result_action="return_value")
    app([*command, "--length-unit", "mm"], result_action="return_value")
    assert "cam2 = 600" in capsys.readouterr().out
