"""Rules of the ranking: what is disturbed, which of two words on a calibration counts, what a lost camera costs."""

from dataclasses import replace

import numpy as np
import pytest

from kinemark.data import Cloud, Detections, MarkerTrajectory, Tracks, Trajectories
from kinemark.geometry import project
from kinemark.sensitivity import angle_jacobian, gather_named, rank, typical
from support.captures import ring
from support.error_budget import RATE, dance, moved_cameras, recorded, shown_by


def hidden(share, px=5.0):
    """Moves this share of images by so many px in random directions."""

    def bend(uv):
        rng = np.random.default_rng(7)
        theta = rng.uniform(0, 2 * np.pi, uv.shape[:3])
        off = px * np.stack([np.cos(theta), np.sin(theta)], -1)
        return np.where(rng.random(uv.shape[:3])[..., None] < share, off, 0.0)

    return bend


@pytest.mark.parametrize("graded", [False, True])
def test_noise_is_found_though_half_of_all_points_are_disturbed(graded):
    """Also by all amounts between noise and 5 px: what is usual is that of the good ones."""
    rig, rng = ring(4), np.random.default_rng(5)

    def bend(uv):
        size = 10 ** (-2.3 * rng.random((*uv.shape[:3], 1))) if graded else 1.0
        return size * hidden(0.15)(uv)

    there = recorded(rig, noise=0.005, xyz=dance(frames=200), bend=bend, hide=0.0)
    found = shown_by(rig, there)
    assert found.noise_px == pytest.approx(0.005, rel=0.4 if graded else 0.15)
    assert found.used.mean() == pytest.approx(0.85**4, abs=0.08)


def test_points_of_two_cameras_are_taken_to_be_disturbed_as_often():
    rig = ring(5)
    there = recorded(rig, noise=0.05, xyz=dance(frames=200), bend=hidden(0.1), hide=0.5)
    views = there.seen.reshape(-1, 5).sum(1)
    found = shown_by(rig, there)
    assert (views == 2).sum() > 100
    said = found.disturbed[views == 2]
    assert (said == said[0]).all() and said[0] == pytest.approx(found.disturbed[views >= 3].mean(), rel=1e-6)


def test_of_what_is_stated_and_what_residuals_show_the_greater_counts():
    """A camera that was knocked after a calibration which states next to nothing."""
    believed = ring(5)
    sure = replace(believed, cameras=tuple(replace(camera, cov=1e-12 * np.eye(15)) for camera in believed))
    ranking = rank(sure, recorded(sure, moved_cameras(believed), noise=0.05))
    source = next(s for s in ranking.sources if s.name == "calibration")
    assert source.evidence == "residuals_of_cameras"
    assert typical(source.mm) == pytest.approx(ranking.shown_mm) and ranking.shown_mm > 100 * ranking.stated_mm


def test_a_lost_camera_costs_what_it_adds():
    """By squares: with what was there before it is what is there after."""
    rig = ring(5)
    for lost in rank(rig, recorded(rig, hide=0.0)).lost:
        for unit, after, before in (("mm", lost.mm, lost.all_mm), ("deg", lost.deg, lost.all_deg)):
            assert 0 < lost.cost(unit) < typical(after)
            assert lost.cost(unit) ** 2 + typical(before) ** 2 == pytest.approx(typical(after) ** 2)


def test_a_named_part_of_a_recording_begins_at_its_first_frame():
    rig, xyz = ring(3), dance(frames=60)
    uv = np.stack([project(camera, xyz) for camera in rig], 2)  # (M, F, C, 2)
    seen = Detections.build(rig.names, RATE, np.full((3, 60), 8), uv.transpose(2, 1, 0, 3).reshape(-1, 2))
    frame, marker = (each.ravel() for each in np.mgrid[:60, :8])
    detection = np.stack([c * 480 + frame * 8 + marker for c in range(3)], 1)
    places = xyz[marker, frame]
    cloud = Cloud(RATE, np.arange(61) * 8, places, np.tile(np.eye(3), (480, 1, 1)), np.zeros(480), detection)
    part = Trajectories(
        tuple(MarkerTrajectory.measured(f"M{m}", p[20:50]) for m, p in enumerate(xyz)), RATE, first_frame=21
    )
    there = gather_named(part, Tracks(cloud, marker.astype(np.int64)), seen, frames=30)
    np.testing.assert_allclose(there.uv, uv[:, 20:50])
    np.testing.assert_allclose(there.time_s, np.arange(20, 50) / RATE)


def test_a_jump_of_a_whole_turn_is_no_derivative():
    """An angle of 179.999° that goes on to −179.999°."""

    def angle(xyz):
        return ((180.0 + 0.1 * xyz[0, :, :1] + 180) % 360) - 180

    slope = angle_jacobian(angle, np.zeros((1, 3, 3)))
    np.testing.assert_allclose(slope[:, 0, 0], np.tile([0.1, 0, 0], (3, 1)), atol=1e-9)
