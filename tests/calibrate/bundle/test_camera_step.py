"""Laws of a camera that is moved while a wand is waved: it is found, and nothing is where none was moved."""

from dataclasses import replace

import numpy as np
import pytest

from kinemark.calibrate.bundle import calibrate_points
from kinemark.calibrate.bundle.camera_step import BLOCKS, CameraStep, camera_step
from kinemark.calibrate.bundle.images_beside import images_beside
from kinemark.calibrate.bundle.one_side import from_one_side, uncertain
from kinemark.calibrate.wand import calibrate_wand, moved_camera
from kinemark.calibrate.wand.identify import marker_places
from kinemark.data import Detections, KinemarkError, Rig
from kinemark.geometry import project_all
from kinemark.synth import observe, ring, wand

GAPS = [150.0, 350.0]
FRAMES = 480
LENS = (-0.12, 0.0, 0.0, 0.0, 0.0)


def images(cameras, seed, *, noise=0.3):
    """A rig and where it sees a waved wand (C, F, K, 2) px."""
    rig = ring(cameras, distortion=LENS)
    xyz = wand(marker_places(GAPS), duration_s=FRAMES / 25, rate=25, seed=seed, volume=rig.volume).xyz
    uv = project_all(rig, xyz.swapaxes(0, 1))
    return rig, uv + np.random.default_rng(seed).normal(0, noise, uv.shape)


def beside(uv, c, at, px):
    """The images with those of camera c px beside from frame `at` on."""
    uv = uv.copy()
    uv[c, at:] += px
    return uv


def pushed(seed, px, *, cameras=4, at=FRAMES // 2, gaps=GAPS):
    """Detections of a wand, the last camera's image px beside from frame `at` on; the sizes of the images."""
    rig = ring(cameras, distortion=LENS)
    subject = wand(marker_places(gaps), duration_s=FRAMES / 25, rate=25, seed=seed, volume=rig.volume)
    seen = observe(rig, subject, noise_px=0.3, seed=seed).detections
    after = (seen.camera == cameras - 1) & (seen.frame >= at)
    moved = Detections.build(
        seen.cameras, seen.rate, seen.counts, seen.uv + np.where(after[:, None], px, 0.0), seen.cov
    )
    return moved, np.array([camera.size for camera in rig])


@pytest.mark.parametrize("at", [60, 240, 400])
@pytest.mark.parametrize(("cameras", "c"), [(3, 0), (6, 5)])
def test_a_camera_that_is_moved_is_named_with_the_frame_and_by_how_much(cameras, c, at):
    rig, uv = images(cameras, at)
    step = camera_step(rig, beside(uv, c, at, (2.0, -1.0)))
    assert (step.camera, step.alone) == (rig.names[c], True)
    assert abs(step.frame - at) <= FRAMES / BLOCKS
    assert step.px == pytest.approx(np.hypot(2, 1), rel=0.1)


@pytest.mark.parametrize("cameras", [2, 3, 5])
@pytest.mark.parametrize("seed", range(4))
def test_where_no_camera_is_moved_none_is_named(cameras, seed):
    assert camera_step(*images(cameras, seed)) is None


@pytest.mark.parametrize("seed", range(3))
def test_a_lens_that_is_known_wrongly_is_no_move(seed):
    rig, uv = images(4, seed, noise=0.1)
    sharp = Rig(tuple(replace(camera, distortion=np.array([-0.1, 0.0, 0.002, 0.0, 0.0])) for camera in rig))
    assert camera_step(sharp, uv) is None


def test_of_two_cameras_either_may_have_been_moved():
    rig, uv = images(2, 0)
    assert not camera_step(rig, beside(uv, 1, 200, (9.0, 9.0))).alone


def test_of_few_frames_nothing_is_said():
    rig, uv = images(3, 0)
    assert camera_step(rig, beside(uv, 0, 25, 9.0)[:, :50]) is None


def test_a_move_is_found_in_a_film_of_few_frames():
    rig, uv = images(3, 0)
    assert camera_step(rig, beside(uv, 0, 60, (2.0, -1.0))[:, :100]).camera == rig.names[0]


@pytest.mark.parametrize("cameras", [2, 4])
def test_images_that_all_lie_far_beside_are_a_move_where_the_others_fit(cameras):
    rig, uv = images(cameras, 2)
    step = camera_step(rig, beside(uv, 1, 160, (60.0, 45.0)))
    assert (step.camera == rig.names[1] and step.alone) == (cameras == 4)
    assert abs(step.frame - 160) <= FRAMES / BLOCKS


def test_images_beside_are_told_by_blocks_of_time():
    medians = np.where(np.eye(3, dtype=bool)[..., None], np.nan, np.full((3, 3, 24), 0.2))
    medians[0, 1:, 15:] = medians[1:, 0, 15:] = 6.0
    assert images_beside(medians, side=2) == (0, 15, pytest.approx(12.0), True)
    assert images_beside(medians[:2, :2], side=2)[1:] == (15, pytest.approx(12.0), False)
    medians[medians > 1] = 0.6  # another part of a lens
    assert images_beside(medians, side=2) is None


def test_strays_are_no_move():
    rig, uv = images(4, 1)
    wild = np.random.default_rng(0).random(uv.shape[:3]) < 0.03
    wild[:, : FRAMES // 2] = False
    assert camera_step(rig, np.where(wild[..., None], uv + 200.0, uv)) is None


def test_a_calibration_says_that_a_camera_was_moved():
    moved, sizes = pushed(1, (2.0, 1.0))
    fit = calibrate_wand(moved, lengths=GAPS, sizes=sizes)
    assert (fit.step.camera, fit.step.alone, fit.step.kept) == (moved.cameras[3], True, "after")
    assert f"Camera {moved.cameras[3]} was probably moved: from about frame" in fit.rig.method
    assert not fit.kept[3, : 2 * fit.step.frame].any()  # two gaps are three markers
    assert fit.kept[:3, : 2 * fit.step.frame].any()


@pytest.mark.parametrize("px", [(2.0, 1.0), (15.0, 6.0)])  # the second fits nothing where all images are asked
def test_cameras_are_as_they_stood_after_one_was_moved(px):
    moved, sizes = pushed(2, px)
    fit = calibrate_wand(moved, lengths=GAPS, sizes=sizes)
    late = moved.frames(FRAMES // 2, FRAMES)
    found = calibrate_wand(late, lengths=GAPS, sizes=sizes)
    beside = np.abs(fit.rig[3].centre - found.rig[3].centre).max()
    assert beside < 4 * np.sqrt(np.trace(found.rig[3].cov[-3:, -3:]))
    assert np.sqrt((fit.residual[fit.kept] ** 2).mean()) < 0.35  # of 0.3 px


def test_a_move_that_leaves_the_ends_of_a_wand_open_is_told():
    """No fundamental matrix fits both sides of it, so that the images of one side were left out without a word."""
    moved, sizes = pushed(3, (30.0, 18.0), cameras=2, at=300, gaps=[500.0])
    fit = calibrate_wand(moved, lengths=[500.0], sizes=sizes)
    assert abs(fit.step.frame - 300) <= FRAMES / BLOCKS


def test_where_too_few_images_follow_the_camera_is_as_uncertain_as_it_was_moved():
    moved, sizes = pushed(1, (3.0, 1.0), at=400)
    step = calibrate_wand(moved, lengths=GAPS, sizes=sizes).step
    still = calibrate_wand(moved.frames(0, 300), lengths=GAPS, sizes=sizes)

    def again(images):
        if images[3, -1]:
            raise KinemarkError("too few")
        assert images[3, :350].all()
        return still

    fit = from_one_side(step, moved.cameras, FRAMES, again)
    more = [fit.rig[c].cov - still.rig[c].cov for c in range(4)]
    assert fit.step.kept == "before"
    assert not np.any(more[:3])
    assert np.sqrt(np.diag(more[3])[9:11] * 2) * fit.rig[3].K[0, 0] == pytest.approx([step.px] * 2, rel=1e-3)
    assert fit.joint[-15:, -15:] == pytest.approx(fit.rig[3].cov, rel=1e-9, abs=1e-15)


def test_where_nobody_knows_which_camera_was_moved_each_is_as_uncertain():
    rig, uv = images(3, 3)
    still = calibrate_points(rig.names, [camera.size for camera in rig], uv[:, :, 0])
    fit = uncertain(still, CameraStep(rig.names[0], False, 200, 2.0, 180, 220))
    for before, camera in zip(still.rig, fit.rig, strict=True):
        more = np.diag(camera.cov - before.cov)[9:11]
        assert np.sqrt(2 * more) * camera.K[0, 0] == pytest.approx([2.0] * 2, rel=0.02)


def test_a_single_marker_is_calibrated_by_what_was_seen_after_the_move():
    rig, uv = images(4, 3)
    marker = beside(uv, 2, 200, (2.0, 1.0))[:, :, 0]
    fit = calibrate_points(rig.names, [camera.size for camera in rig], marker)
    assert (fit.step.camera, fit.step.kept) == (rig.names[2], "after")
    assert not fit.kept[2, :200].any()
    assert fit.kept[2, 300:].any()


def test_where_neither_side_of_a_move_is_a_calibration_the_cause_is_said(monkeypatch):
    monkeypatch.setattr(moved_camera, "from_one_side", lambda *_: None)
    moved, sizes = pushed(2, (15.0, 6.0))
    with pytest.raises(KinemarkError, match=rf"Camera {moved.cameras[3]} was probably moved: from about frame 2\d\d"):
        calibrate_wand(moved, lengths=GAPS, sizes=sizes)
