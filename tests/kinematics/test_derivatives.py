"""Velocities and accelerations against motions whose derivatives are known, and against their own deviations."""

import csv
import json

import numpy as np
import pytest

from kinemark.apps.cli import app
from kinemark.data import KinemarkError, MarkerTrajectory, Trajectories
from kinemark.engine.derivative_files import derivatives_of_file
from kinemark.io.trajectories_csv import write_trajectories_csv
from kinemark.kinematics import marker_derivatives

RATE = 100.0


def swing(n=300, rate=RATE, noise=0.0, seed=0, amplitude=200.0, hz=1.0):
    """Markers on a circle and on a swing, and their exact velocity and acceleration, (2, F, 3)."""
    t = np.arange(n) / rate
    w = 2 * np.pi * hz
    parts = []
    for order in range(3):
        turn = w**order
        s, c = (np.sin(w * t + order * np.pi / 2), np.cos(w * t + order * np.pi / 2))
        flat = np.stack([s, c, 0 * t], -1)
        parts.append(amplitude * turn * np.stack([flat, flat[:, [2, 0, 1]] * [1, 1, 0.5]]))
    rng = np.random.default_rng(seed)
    return parts[0] + rng.normal(0, noise, parts[0].shape) if noise else parts[0], parts[1], parts[2]


def markers(xyz, rate=RATE):
    return Trajectories(tuple(MarkerTrajectory.measured(f"m{k}", path) for k, path in enumerate(xyz)), rate, 1)


def test_without_noise_the_derivatives_are_exact():
    xyz, velocity, acceleration = swing()
    found = marker_derivatives(markers(xyz))
    inner = slice(10, -10)
    assert np.abs(found.velocity - velocity)[:, inner].max() < 0.002 * np.abs(velocity).max()
    assert np.abs(found.acceleration - acceleration)[:, inner].max() < 0.005 * np.abs(acceleration).max()


@pytest.mark.parametrize("rate", [50.0, 100.0, 200.0])
@pytest.mark.parametrize("noise", [0.2, 1.0])
def test_noise_is_found_and_errors_are_within_what_is_stated(rate, noise):
    xyz, velocity, acceleration = swing(n=round(4 * rate), rate=rate, noise=noise, seed=int(rate))
    found = marker_derivatives(markers(xyz, rate))
    np.testing.assert_allclose(found.noise_sd, noise, rtol=0.2)
    for got, true, sd in (
        (found.velocity, velocity, found.velocity_sd),
        (found.acceleration, acceleration, found.acceleration_sd),
    ):
        off = (got - true) / sd[..., None]
        assert 0.2 < np.sqrt((off**2).mean()) < 1.3
        assert (np.abs(off) < 1.96).mean() > 0.88
    central = np.gradient(xyz, 1 / rate, axis=1)
    assert np.std(found.velocity - velocity) < 0.8 * np.std(central - velocity)


def test_a_still_marker_does_not_move():
    still = np.zeros((1, 400, 3)) + np.random.default_rng(4).normal(0, 0.5, (1, 400, 3))
    found = marker_derivatives(markers(still))
    assert np.abs(found.velocity[0, 20:-20]).max() < 10 and found.velocity_sd[0, 20:-20].max() < 10
    np.testing.assert_allclose(found.noise_sd, 0.5, rtol=0.1)


def test_missing_samples_stay_missing_and_few_samples_tell_nothing():
    xyz, velocity, _ = swing(noise=0.2, seed=2)
    xyz[0, 100:108], xyz[1, 7:] = np.nan, np.nan
    found = marker_derivatives(markers(xyz))
    gone = np.isnan(xyz[0, :, 0])
    assert (np.isnan(found.velocity[0, :, 0]) == gone).all() and (np.isnan(found.acceleration_sd[0]) == gone).all()
    assert found.velocity_sd[0, 99] > found.velocity_sd[0, 50]  # less is known beside a gap
    assert np.abs(found.velocity[0, 90:100] - velocity[0, 90:100]).max() < 60
    assert np.isnan(found.velocity[1]).all() and np.isnan(found.noise_sd[1])
    assert marker_derivatives(Trajectories((), RATE, 1)).velocity.shape[0] == 0


def test_units_follow_the_length_and_time_and_nothing_hangs_on_the_axes():
    xyz, _, _ = swing(noise=0.3, seed=3)
    first, scaled = marker_derivatives(markers(xyz)), marker_derivatives(markers(10 * xyz, 2 * RATE))
    np.testing.assert_allclose(scaled.velocity, 20 * first.velocity, rtol=1e-4, atol=0.1)
    np.testing.assert_allclose(scaled.acceleration_sd, 40 * first.acceleration_sd, rtol=1e-3)
    R = np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))[0]
    turned = marker_derivatives(markers(xyz @ R.T))
    np.testing.assert_allclose(turned.velocity, first.velocity @ R.T, atol=0.05)
    np.testing.assert_allclose(turned.acceleration_sd, first.acceleration_sd, rtol=1e-3)


def test_the_command_writes_what_the_function_finds(tmp_path, capsys):
    xyz, _, _ = swing(n=120, noise=0.3, seed=5)
    source, target = tmp_path / "swing.csv", tmp_path / "velocities.csv"
    write_trajectories_csv(source, markers(xyz))
    app(["velocities", str(source), str(target), "--json"], result_action="return_value")
    said = json.loads(capsys.readouterr().out)
    assert [one["name"] for one in said["markers"]] == ["m0", "m1"] and said["markers"][0]["frames"] == 120
    with target.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    found = marker_derivatives(markers(xyz))
    assert len(rows) == 120
    assert float(rows[60]["m1_vy_mm_s"]) == pytest.approx(found.velocity[1, 60, 1], abs=1e-4)
    assert float(rows[60]["m0_a_sd_mm_s2"]) == pytest.approx(found.acceleration_sd[0, 60], abs=1e-4)
    with pytest.raises(KinemarkError, match="exists"):
        derivatives_of_file(source, target)
