"""Lens terms that a calibration does not state, or states of images without, and noise that centroids overstate."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from kinemark.data import Rig
from kinemark.geometry import undistort
from kinemark.geometry.camera import distort
from kinemark.geometry.weighted_points import DEFAULT_ERRORS
from kinemark.report.words import advice_of, text_of
from kinemark.track.simultaneous import diagnose, track_simultaneously
from kinemark.track.simultaneous.facts import tracked_images
from kinemark.track.simultaneous.points.solved_points import solved, solver_for
from kinemark.track.simultaneous.rig import adjusted_rig, missing_lens
from kinemark.track.simultaneous.rig.adjusted_rig import rig_step, with_radial
from kinemark.track.simultaneous.rig.missing_lens import missing_lenses
from kinemark.track.simultaneous.simultaneous_method import DEFAULT
from support.laboratory import camera, observe
from support.scenes import make, scene, tally
from support.wrong_rig import bare


@cache
def made(seed, frames=40):
    whole = scene(seed)
    return make(whole._replace(seconds=frames / whole.rate))


def tracked(one, detections, rig):
    result = track_simultaneously(detections, rig, DEFAULT)
    found = {finding.kind: finding for finding in diagnose(detections, rig, result)}
    return result, tally(one, result.tracks), found


def test_lost_lens_terms_are_learned_and_used():
    one = made(147005)
    result, counts, found = tracked(one, one.detections, bare(one.rig))
    assert counts.two_found + counts.more_found > 0.98 * (counts.two + counts.more)  # 91 % else
    assert counts.ghosts <= 0.05 * counts.frames
    true = np.array([camera.distortion[0] for camera in one.rig])
    assert np.abs(result.lenses.radial - true).max() < 0.04
    finding = found["lens_terms_unstated"]
    assert finding.values["lost"] and finding.severity == "amber" and len(finding.values["k1_list"]) == len(one.rig)
    assert "were learned" in text_of(finding) and "Calibrate again" in advice_of(finding)


def test_what_is_found_later_is_solved_with_the_learned_lenses():
    """By names, by edits: points solved again lie where they were."""
    one = made(147022)
    rig = bare(one.rig)
    result = track_simultaneously(one.detections, rig, DEFAULT)
    tracks = result.tracks
    timed, working, _ = tracked_images(one.detections, result.rig, tracks, DEFAULT)
    solver, cloud = solver_for(timed, np.zeros(len(timed), bool), working, DEFAULT_ERRORS), tracks.cloud
    again = solved(cloud.frame, cloud.detection.T, cloud.xyz.T, solver)
    off = np.linalg.norm(again.xyz - cloud.xyz, axis=1)
    assert np.nanmedian(off) < 0.05 and np.nanpercentile(off, 90) < 0.5  # 0.34, and 3.6 mm of one in twenty, else


def test_a_rig_that_states_lens_terms_keeps_them():
    one = made(147005)
    assert missing_lenses(one.detections, one.rig) is None
    assert "lens_terms_unstated" not in tracked(one, one.detections, one.rig)[2]


def straight(one):
    """Its detections, with the lenses taken out of them before."""
    uv = np.concatenate([undistort(c, one.detections.uv[one.detections.camera == k]) for k, c in enumerate(one.rig)])
    return replace(one.detections, uv=uv)


@pytest.mark.parametrize("seed", [147005, 147022])
def test_lenses_are_not_taken_out_twice(seed):
    """A rig states its lenses, and the images come without distortion: as by the rig that states none."""
    one = made(seed)
    result, counts, found = tracked(one, straight(one), one.rig)
    plain = track_simultaneously(straight(one), bare(one.rig), DEFAULT)
    np.testing.assert_array_equal(result.tracks.cloud.xyz, plain.tracks.cloud.xyz)
    assert counts.two_found + counts.more_found > 0.97 * (counts.two + counts.more)
    assert "without lens terms" in text_of(found["lens_terms_taken_out"])
    assert "lens_terms_unstated" not in found


@pytest.mark.parametrize(("seed", "off"), [(201008, 1.0), (201015, 1.0), (201018, 3.0), (147005, 6.0)])
def test_a_calibration_that_is_off_keeps_its_lenses(seed, off):
    """Also where images are by chance nearer to each other's lines without them, as in the first three."""
    whole = scene(seed)
    one = make(whole._replace(calibration=off, seconds=40 / whole.rate))
    assert missing_lenses(one.detections, one.rig) is None


def test_terms_of_long_lenses_that_are_hardly_determined_were_not_taken_out():
    """Four lenses of 600 mm at 20 m, without distortion, and terms as a wand gave them, up to .6 px off."""
    rng, true, stated = np.random.default_rng(311), [], []
    for k, (k1, k2) in enumerate([(13.7, -7.2e5), (7.7, -1.9e5), (-1.0, 3.2e4), (30.4, -1.2e6)]):
        turn = 0.4 + 1.1 * k
        place = (20000 * np.cos(turn), 20000 * np.sin(turn), 3000 + 1500 * k)
        one = camera(f"c{k}", place, (0.0, 0.0, 1000.0), focal=109000.0, lens=np.zeros(5), size=(2048, 2048))
        true.append(one)
        stated.append(replace(one, distortion=np.array([k1, k2, 0, 0, 0])))
    xyz = rng.normal((0, 0, 1000), 70, (6, 1, 3)) + np.cumsum(rng.normal(0, 1, (6, 100, 3)), 1)
    detections = observe(Rig(tuple(true)), xyz, noise=0.1, seed=311)[0]
    assert missing_lenses(detections, Rig(tuple(stated))) is None


def test_images_without_distortion_lack_no_lens():
    """Pixels from which a lens was taken out before."""
    one = made(147005)
    uv = np.concatenate([undistort(c, one.detections.uv[one.detections.camera == k]) for k, c in enumerate(one.rig)])
    assert missing_lenses(replace(one.detections, uv=uv), bare(one.rig)) is None


@pytest.mark.parametrize(("seed", "off", "frames"), [(148003, 1.0, 20), (148009, 3.0, 100), (148006, 1.0, 20)])
def test_a_calibration_that_is_off_lacks_no_lens(seed, off, frames):
    """Few images of it fit any lens, and a fit without a lens needs as many rounds."""
    whole = scene(seed)
    optics = whole.optics._replace(noise=0.2)
    one = make(whole._replace(calibration=off, optics=optics, seconds=frames / whole.rate))
    uv = np.concatenate([undistort(c, one.detections.uv[one.detections.camera == k]) for k, c in enumerate(one.rig)])
    assert missing_lenses(replace(one.detections, uv=uv), bare(one.rig)) is None


def test_a_rig_calibrated_as_if_without_lens_is_told_and_kept():
    """Longer focal lengths make up for a part of the lens."""
    one = made(147005)
    lens = with_radial(one.rig, np.full(len(one.rig), -0.1))
    uv = np.concatenate(
        [_through(lens.cameras[k], c, one.detections.uv[one.detections.camera == k]) for k, c in enumerate(one.rig)]
    )
    cameras = [replace(c, K=c.K * [[0.985, 0.985, 1], [0.985, 0.985, 1], [1, 1, 1]]) for c in bare(one.rig)]
    detections, rig = replace(one.detections, uv=uv), replace(one.rig, cameras=tuple(cameras))
    lenses = missing_lenses(detections, rig)
    assert lenses is not None and not lenses.lost
    result, _, found = tracked(one, detections, rig)
    assert found["lens_terms_unstated"].values["lost"] is False
    assert (found["lens_terms_unstated"].severity == "red") == (result.lenses.sd > 1)
    assert "were not used" in text_of(found["lens_terms_unstated"])


def _through(lens, camera, uv):
    """Pixels of a camera as another lens would draw them."""
    return distort(lens, undistort(camera, uv))


@pytest.mark.parametrize(("times", "spread"), [(1, 0.0), (20, 0.0), (20, 0.5)])
def test_noise_that_is_stated_far_too_large_is_not_believed(times, spread):
    """Nor are the images of more than the usual noise."""
    one = made(147003, 60)
    stated = times * one.scene.optics.noise
    share = np.exp(spread * np.random.default_rng(0).normal(size=len(one.detections)))
    detections = replace(one.detections, cov=np.eye(2) * (stated * share[:, None, None]) ** 2)
    result, counts, found = tracked(one, detections, one.rig)
    assert counts.two_found + counts.more_found > 0.97 * (counts.two + counts.more)  # 45 % of 20 times else
    sd = np.sqrt(np.trace(result.tracks.cloud.cov, axis1=1, axis2=2))
    assert np.median(sd) < 3  # mm; errors of positions are those of the images
    assert ("noise_overstated" in found) == (times > 1)
    if times > 1:
        values = found["noise_overstated"].values
        assert values["stated_px"] == pytest.approx(stated, rel=0.03) and 0.25 < values["seen_px"] < 0.4
        text = text_of(found["noise_overstated"])
        assert f"{values['stated_px']:.2f}" in text and "0.3" in text


def test_right_noise_of_many_pixels_is_believed():
    """No peak of residuals is seen of 3 px, but a few that meet by chance."""
    whole = scene(148023)
    one = make(whole._replace(optics=whole.optics._replace(noise=3.0, stated=True), seconds=150 / whole.rate))
    _, counts, found = tracked(one, one.detections, one.rig)
    assert "noise_overstated" not in found
    assert counts.two_found + counts.more_found > 0.98 * (counts.two + counts.more)  # 88 % else


@pytest.mark.parametrize("off", [0.0, 1.0])
def test_lenses_are_not_fitted_where_turns_leave_little(monkeypatch, off):
    """Nor is anything fitted that has settled: most of the time of a short recording was spent so."""
    steps = []
    monkeypatch.setattr(missing_lens, "_fitted", None)
    monkeypatch.setattr(adjusted_rig, "rig_step", lambda *given: steps.append(rig_step(*given)) or steps[-1])
    whole = scene(147008)
    one = make(whole._replace(calibration=off, seconds=40 / whole.rate))
    assert missing_lenses(straight(one), bare(one.rig)) is None
    assert 1 < len(steps) < missing_lens.ROUNDS and steps[-1].gain <= adjusted_rig.SETTLED < steps[0].gain
