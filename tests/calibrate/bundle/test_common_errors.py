"""What cameras' errors have in common: modes of a joint covariance, and points placed along a corridor."""

from dataclasses import replace

import numpy as np
import pytest

from kinemark.calibrate.bundle import bundle, sticks_through
from kinemark.calibrate.bundle.common_errors import MOST, common_errors
from kinemark.calibrate.quality import joint_of, predicted_covariance
from kinemark.data import Rig
from kinemark.geometry import project_all, refine, rig_about
from kinemark.io.rig_toml import read_rig_toml, write_rig_toml
from support.laboratory import camera

NOISE = 0.2  # px
ALONG = np.array([0.0, 180.0, 500.0])


def seen(rig, xyz, rng):
    uv = project_all(rig, xyz) + NOISE * rng.normal(size=(len(rig), len(xyz), 2))
    size = np.array([c.size for c in rig])[:, None]
    return np.where(((uv > 0) & (uv < size - 1)).all(-1, keepdims=True), uv, np.nan)


@pytest.fixture(scope="module")
def corridor():
    """A corridor of 9 m of which no camera sees all: its bundle adjustment, and places along it (N, 3) mm."""
    rng, x = np.random.default_rng(0), np.linspace(-4500, 4500, 8)
    sides = [(each, (-1) ** i * 2000.0, 1600.0) for i, each in enumerate(x)]
    rig = Rig(tuple(camera(f"c{i}", at, (0.95 * at[0], 0.0, 900.0)) for i, at in enumerate(sides)))
    middle = rng.uniform([-4800, -500, 500], [4800, 500, 1400], (240, 3))
    way = rng.normal(size=(240, 1, 3))
    way /= np.linalg.norm(way, axis=2, keepdims=True)
    sticks = middle[:, None] + (ALONG[:, None] - 250) * way
    places = rng.uniform([-4500, -500, 500], [4500, 500, 1400], (80, 3))
    places = places[np.isfinite(seen(rig, places, rng)).all(2).sum(0) >= 2]
    return bundle(rig, (sticks_through(sticks, ALONG),), seen(rig, sticks.reshape(-1, 3), rng)), places


def stated(rig, xyz):
    """(N, 3, 3) mm² that a reconstruction states of places (N, 3) mm."""
    uv = seen(rig, xyz, np.random.default_rng(1)).transpose(1, 0, 2)
    return refine(rig, xyz, uv, np.broadcast_to(NOISE**2 * np.eye(2), (*uv.shape, 2)), steps=0).cov


def size(cov):
    return np.sqrt(np.trace(cov, axis1=1, axis2=2))


def test_points_along_a_corridor_have_the_covariance_of_all_cameras_together(corridor):
    fit, places = corridor
    alone = Rig(tuple(replace(c, common=np.zeros((15, 0))) for c in fit.rig))
    whole = size(predicted_covariance(fit.rig, places, centroid_sd=NOISE, joint=fit.joint))
    off, off_alone = (np.abs(np.log(size(stated(rig, places)) / whole)) for rig in (fit.rig, alone))
    assert np.median(off) < 0.02 < 0.1 < np.median(off_alone)
    assert off.max() < 0.1 < 0.5 < off_alone.max()
    rest = size(predicted_covariance(fit.rig, places, centroid_sd=NOISE))  # by `joint_of`
    assert np.abs(np.log(rest / size(stated(fit.rig, places)))).max() < 1e-6


def test_no_camera_errs_less_than_by_what_it_shares(corridor):
    joint = corridor[0].joint
    F = common_errors(joint)
    assert F.shape == (8, 15, MOST)
    for c, own in enumerate(F):
        block = joint[15 * c : 15 * c + 15, 15 * c : 15 * c + 15]
        sd = np.sqrt(np.where(np.diag(block) > 0, np.diag(block), 1.0))
        rest = (block - own @ own.T) / sd / sd[:, None]
        assert np.linalg.eigvalsh(rest).min() > -1e-9


def test_cameras_that_err_by_themselves_have_nothing_in_common(corridor):
    alone = Rig(tuple(replace(c, common=np.zeros((15, 0))) for c in corridor[0].rig))
    assert common_errors(joint_of(alone)).shape == (8, 15, 0)
    assert common_errors(np.zeros((30, 30))).shape == (2, 15, 0)


def test_common_errors_are_kept_in_the_file_and_move_with_the_world(corridor, tmp_path):
    rig, places = corridor[0].rig, corridor[1]
    write_rig_toml(tmp_path / "rig.toml", rig)
    again = read_rig_toml(tmp_path / "rig.toml")
    assert all((a.common == b.common).all() for a, b in zip(rig, again, strict=True))
    by = np.array([3000.0, -2000.0, 500.0])
    assert np.allclose(stated(rig_about(again, by), places - by), stated(rig, places), rtol=1e-6)


def test_cameras_of_two_calibrations_are_refused(corridor):
    rig = corridor[0].rig
    with pytest.raises(ValueError, match="those of one calibration"):
        Rig((rig[0], replace(rig[1], common=np.zeros((15, 3)))))
