"""Laws of the wand: which blob is which marker, and what the rig that follows from it is worth."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest

from kinemark.calibrate.bundle import Bundle, calibrate_sticks, from_sizes
from kinemark.calibrate.bundle.from_sizes import odd_one
from kinemark.calibrate.bundle.initial import growth
from kinemark.calibrate.wand import Wand, calibrate_wand, thinned
from kinemark.calibrate.wand.calibrate import _to_ask
from kinemark.calibrate.wand.completion import completed
from kinemark.calibrate.wand.ends import best_signs, pair_evidence
from kinemark.calibrate.wand.identify import (
    at_rows,
    identify_wand,
    marker_places,
    read_wand,
    wand_points,
    wanted,
    wrong_gaps,
)
from kinemark.calibrate.wand.lengths import wand_lengths
from kinemark.calibrate.wand.rows import read_rows
from kinemark.data import Detections, KinemarkError, Rig
from kinemark.detect import detect
from kinemark.geometry import project, rigid_align, triangulate, undistort
from kinemark.geometry.sphere_offset import sphere_offset
from kinemark.synth import film, look_at, observe, ring, truth, walking, wand
from support.films import Film

LENS = (-0.12, 0.0, 0.0, 0.0, 0.0)
WANDS = ([500.0], [150.0, 350.0], [250.0, 250.0], [230.0, 270.0], [100.0, 150.0, 250.0], [150.0, 150.0, 150.0],
         [60.0, 110.0, 90.0, 240.0])  # fmt: skip


def waved(lengths, *, cameras=6, frames=200, seed=0, rig=None, **faults):
    """A rig and what it saw of a wand."""
    rig = rig or ring(cameras, distortion=LENS)
    subject = wand(marker_places(lengths), duration_s=frames / 25, rate=25, seed=seed, volume=rig.volume)
    return rig, observe(rig, subject, **{"noise_px": 0.1, "seed": seed, **faults})


def off_truth(observed, uv, symmetric):
    """Distances (C, F, K) px of markers from where they truly are; a symmetric wand may be turned in whole frames."""
    true = observed.sight.uv.transpose(0, 2, 1, 3)
    d = np.linalg.norm(uv - true, axis=-1)
    if symmetric:
        turned = np.linalg.norm(uv - true[:, :, ::-1], axis=-1)
        d = np.where((np.nansum(turned, (0, 2)) < np.nansum(d, (0, 2)))[None, :, None], turned, d)
    return d


def symmetric(lengths):
    return np.allclose(lengths, lengths[::-1])


def renewed(detections, uv):
    """The detections at other places."""
    return Detections.build(
        detections.cameras, detections.rate, detections.counts, uv, detections.cov, width=detections.width
    )


@pytest.mark.parametrize("lengths", WANDS, ids=str)
def test_every_marker_is_the_same_in_all_cameras(lengths):
    _, observed = waved(lengths, false_per_frame=0.2, dropout=0.02, merge_px=5.0, seed=3)
    uv, cov = wand_points(observed.detections, lengths=lengths)
    off = off_truth(observed, uv, symmetric(lengths))
    seen = np.isfinite(off)
    assert (off[seen] > 1).mean() < 0.002
    assert seen.mean() > (0.7 if len(lengths) == 1 else 0.85)  # a stray beside two markers cannot be told from them
    assert (np.isfinite(cov).all((-1, -2)) == seen).all()


@pytest.mark.parametrize("rig", [ring(6, distortion=(-0.3, 0.08, 0, 0, 0)), ring(3, sweep_deg=60.0),
                                 ring(2, sweep_deg=50.0), ring(5, radius=2200.0, focal_px=700.0)],
                         ids=["strong lens", "three on an arc", "two", "close"])  # fmt: skip
@pytest.mark.parametrize("lengths", [[500.0], [230.0, 270.0]], ids=str)
def test_ends_are_told_apart_whatever_the_cameras(rig, lengths):
    _, observed = waved(lengths, rig=rig, frames=100, seed=1, false_per_frame=0.05)
    uv, _ = wand_points(observed.detections, lengths=lengths)
    off = off_truth(observed, uv, symmetric(lengths))
    assert (off[np.isfinite(off)] < 1).mean() > 0.995
    assert np.isfinite(off).mean() > 0.7


def test_few_neighbouring_frames_tell_two_cameras_that_face_each_other_the_ends():
    """The wand's images are long, and their middles are far from the image of its middle."""
    rig = [
        look_at(n, [x, y, 1500.0], [0.0, 0.0, 800.0], focal_px=1000.0)
        for n, x, y in (("a", -500, -2000), ("b", 1200, 2000))
    ]
    for seed in range(10):
        rng, time = np.random.default_rng(seed), np.linspace(0, 1, 24)[:, None]
        middle, along = (np.sin(2 * np.pi * (time * rng.uniform(0.3, 1.2, 3) + rng.random(3))) for _ in range(2))
        along *= 400 / np.linalg.norm(along, axis=1, keepdims=True)
        xyz = (np.array([200.0, 0.0, 900.0]) + middle * [500, 400, 400])[:, None] + np.stack([-along, along], 1)
        a, b = (project(camera, xyz.reshape(-1, 3)).reshape((*xyz.shape[:2], 2)) for camera in rig)
        turned = rng.random(len(time)) < 0.5
        a, b = a + 0.1 * rng.normal(size=a.shape), np.where(turned[:, None, None], b[:, ::-1], b)
        evidence = pair_evidence(a, b)
        sure = np.abs(evidence) > 3
        assert sure.mean() > 0.5
        np.testing.assert_array_equal((evidence < 0)[sure], turned[sure])


def test_few_poses_that_two_halves_of_a_room_share_are_not_thinned_out():
    rig, observed = waved([500.0], rig=ring(4, sweep_deg=180.0), frames=630)
    seen, link = observed.detections, np.repeat([0, 1, 2], [300, 30, 300])[observed.detections.frame]
    kept, counts = (link == seen.camera) | (link == seen.camera - 1), np.zeros_like(seen.counts)
    np.add.at(counts, (seen.camera[kept], seen.frame[kept]), 1)
    pairwise = Detections.build(seen.cameras, seen.rate, counts, seen.uv[kept], seen.cov[kept])
    fit = calibrate_wand(pairwise, lengths=[500.0], sizes=[camera.size for camera in rig])
    far, found = (np.linalg.norm(r.centres[0] - r.centres[3]) for r in (rig, fit.rig))
    assert abs(found - far) < 30


def test_a_wand_given_from_its_other_end_is_the_same():
    _, observed = waved([150.0, 350.0], frames=60, false_per_frame=0.5)
    uv, _ = wand_points(observed.detections, lengths=[150.0, 350.0])
    other, _ = wand_points(observed.detections, lengths=[350.0, 150.0])
    np.testing.assert_array_equal(uv, other[:, :, ::-1])


def test_strobes_are_dropped_and_crowded_frames_counted():
    lengths = [150.0, 350.0]
    rig, observed = waved(lengths, frames=80)
    seen = observed.detections
    rng = np.random.default_rng(0)
    strobes = rng.uniform(100, 900, (len(rig), 3, 2))
    counts, rows = np.zeros_like(seen.counts), []
    for c, f in product(range(len(rig)), range(80)):
        crowd = rng.uniform(0, 1000, (30 if c == 1 and f < 20 else 0, 2))
        frame = np.concatenate([strobes[c] + rng.normal(0, 0.3, (3, 2)), seen[c, f], crowd])
        counts[c, f] = len(frame)
        rows.append(frame)
    both = Detections.build(seen.cameras, seen.rate, counts, np.concatenate(rows))
    want = wanted(both)
    assert want.crowded.tolist() == [0, 20, 0, 0, 0, 0]
    assert (want.still >= 3 * 80 - 60).all() and (want.still <= 3 * 80 + 20).all()
    uv, cov = wand_points(both, lengths=lengths)
    alone, _ = wand_points(seen, lengths=lengths)
    common = np.isfinite(uv) & np.isfinite(alone)
    assert (uv[common] == alone[common]).mean() > 0.99
    assert common[[0, 2, 3, 4, 5]].mean() > 0.85
    assert np.isnan(uv[1, :20]).all() and np.isnan(cov).all()


def test_rows_are_read_in_the_direction_of_their_gaps():
    rig = ring(1)
    along, rng = marker_places([100.0, 150.0, 250.0]), np.random.default_rng(5)
    ahead = rng.normal(size=(100, 3))
    ahead /= np.linalg.norm(ahead, axis=1, keepdims=True)
    xyz = np.array([1200.0, 700.0, 850.0]) + rng.uniform(-500, 500, (100, 1, 3)) + along[:, None] * ahead[:, None]
    uv = project(rig[0], xyz)
    mixed = np.argsort(rng.random((100, 4)), axis=1)
    read = read_rows(np.take_along_axis(uv, mixed[..., None], 1), along)
    found = read.points[:, 0] >= 0
    assert found.mean() > 0.9
    np.testing.assert_array_equal(
        np.take_along_axis(mixed, read.points, 1)[found], np.tile(np.arange(4), (found.sum(), 1))
    )
    assert (read.lead[found] > 0).all()


def test_signs_are_the_best_of_all():
    rng = np.random.default_rng(2)
    evidence = rng.normal(0, 1, (50, 5, 5)) + 3 * np.sign(np.einsum("fi,fj->fij", *2 * [rng.choice([-1, 1], (50, 5))]))
    evidence = np.triu(evidence, 1) + np.swapaxes(np.triu(evidence, 1), 1, 2)
    sign, support = best_signs(evidence)
    every = np.array(list(product([-1, 1], repeat=5)))
    worth = np.einsum("fij,si,sj->fs", evidence, every, every)
    np.testing.assert_allclose(np.einsum("fij,fi,fj->f", evidence, sign, sign), worth.max(1))
    turned = sign * (1 - 2 * np.eye(5)[2])
    np.testing.assert_allclose(worth.max(1) - np.einsum("fij,fi,fj->f", evidence, turned, turned), 4 * support[:, 2])


def test_a_rig_finds_what_the_first_reading_left_out_or_mistook():
    lengths = [500.0]
    rig, observed = waved(lengths, false_per_frame=1.0, dropout=0.02, merge_px=5.0)
    along, want = marker_places(lengths), wanted(observed.detections)
    rows = identify_wand(observed.detections, want, along)
    first = (rows >= 0).sum()
    rng = np.random.default_rng(0)
    swapped = rng.random(rows.shape[:2]) < 0.05
    rows = np.where(swapped[..., None], rows[..., ::-1], rows)
    found, xyz = completed(rig, observed.detections, want.use, rows, along, search_radius=3.0)
    off = off_truth(observed, at_rows(observed.detections, found)[0], True)
    assert np.nanmax(off) < 3.0 and (off[np.isfinite(off)] > 0.6).mean() < 0.003
    assert (found >= 0).sum() > 1.8 * first
    np.testing.assert_allclose(np.linalg.norm(xyz[:, 1] - xyz[:, 0], axis=1)[np.isfinite(xyz[:, 0, 0])], 500.0)


def test_poses_are_spread_over_the_images():
    rig, observed = waved([500.0], frames=400)
    rows = identify_wand(observed.detections, wanted(observed.detections), marker_places([500.0]))
    sizes = [camera.size for camera in rig]
    chosen = thinned(observed.detections, rows, sizes, 40)
    assert (chosen >= 0).any((0, 2)).sum() == 40
    assert ((chosen == rows) | (chosen == -1)).all()

    def cells(rows):
        uv = observed.detections.uv[rows[rows >= 0]]
        camera = np.nonzero(rows >= 0)[0]
        return len(np.unique(np.column_stack([camera, uv // 100]), axis=0))

    first = np.where(np.arange(400)[None, :, None] % 10 == 0, rows, -1)
    assert cells(chosen) > 1.05 * cells(first)


def test_lengths_scatter_as_predicted():
    rig, observed = waved([500.0], frames=400, noise_px=0.2, dropout=0.3)
    uv, cov = wand_points(observed.detections, lengths=[500.0])
    came = wand_lengths(rig, uv, along=[0.0, 500.0], cov=cov)
    seen = np.isfinite(came.error)
    assert np.std(came.error[seen] / came.sd[seen]) == pytest.approx(1.0, abs=0.1)
    assert np.median(came.sd[seen & (came.cameras <= 3)]) > 1.1 * np.median(came.sd[seen & (came.cameras >= 4)])


def wrong(observed, share, seed=0):
    """The detections with a share of them somewhere near but wrong."""
    rng = np.random.default_rng(seed)
    uv = observed.detections.uv.copy()
    bad = rng.random(len(uv)) < share
    uv[bad] += rng.uniform(5, 30, (bad.sum(), 1)) * np.exp(2j * np.pi * rng.random((bad.sum(), 1))).view(float)
    return renewed(observed.detections, uv)


def walking_error(rig, fitted):
    """RMS distance, mm, of a walking subject's markers reconstructed with a fitted rig, from where they are."""
    subject = walking()
    sight = truth(rig, subject)
    uv = np.where((sight.visible > 0.5)[..., None], sight.uv, np.nan).reshape(len(rig), -1, 2)
    xyz = triangulate(np.stack([undistort(c, x) for c, x in zip(fitted, uv, strict=True)], 1), fitted.P)
    R, t = rigid_align(xyz, subject.xyz.reshape(-1, 3))
    off = np.linalg.norm(xyz @ R.T + t - subject.xyz.reshape(-1, 3), axis=1)
    return float(np.sqrt(np.nanmean(off**2)))


def test_from_the_image_size_alone():
    rig, observed = waved([500.0], frames=400, false_per_frame=0.02, merge_px=5.0)
    sizes = [camera.size for camera in rig]
    fit = calibrate_wand(wrong(observed, 0.02), lengths=[500.0], sizes=sizes)
    assert walking_error(rig, fit.rig) < 0.08  # the bar is 0.15
    assert fit.kept.shape == (6, 800) and fit.xyz.shape == (800, 3)
    np.testing.assert_allclose(fit.rig[0].R, np.eye(3), atol=1e-12)
    np.testing.assert_allclose(fit.rig[0].t, 0, atol=1e-9)
    assert "400 frames" in fit.rig.method
    focal = np.array([camera.K[0, 0] for camera in fit.rig])
    sd = np.sqrt([camera.cov[0, 0] for camera in fit.rig])
    assert (np.abs(focal - 1300) < 4 * sd).all()
    _, other = waved([500.0], frames=200, seed=9)  # a recording that the calibration has not seen
    uv, cov = wand_points(other.detections, lengths=[500.0])
    came = wand_lengths(fit.rig, uv, along=[0.0, 500.0], cov=cov, joint=fit.joint)
    assert np.sqrt(np.nanmean((came.error / came.sd) ** 2)) == pytest.approx(1.0, abs=0.2)


def test_fields_of_interlaced_video_have_pixels_half_as_high():
    rig = ring(4, distortion=LENS, focal_px=(1300.0, 650.0), size=(1280, 512))
    rig, observed = waved([500.0], rig=rig, frames=300, seed=5)
    sizes, method = [camera.size for camera in rig], Wand(aspect=0.5)
    fit = calibrate_wand(observed.detections, lengths=[500.0], sizes=sizes, method=method)
    assert walking_error(rig, fit.rig) < 0.3
    np.testing.assert_allclose([camera.K[1, 1] / camera.K[0, 0] for camera in fit.rig], 0.5, atol=0.001)


def test_big_spheres_are_corrected():
    rig, observed = waved([400.0], cameras=4, frames=120, noise_px=0.005)
    diameter, seen = 120.0, observed.detections
    subject = wand(marker_places([400.0]), duration_s=120 / 25, rate=25, seed=0, volume=rig.volume)
    uv = seen.uv.copy()
    for c, camera in enumerate(rig):
        mine = slice(seen.start[c, 0], seen.start[c, -1])
        centres = subject.xyz[observed.marker[mine], seen.frame[mine]]
        uv[mine] += sphere_offset(camera, centres, diameter=diameter)
    sizes = [camera.size for camera in rig]
    plain, corrected = (
        calibrate_wand(renewed(seen, uv), lengths=[400.0], sizes=sizes, method=Wand(radial=1, marker_diameter=d))
        for d in (None, diameter)
    )
    assert walking_error(rig, corrected.rig) < 0.5 * walking_error(rig, plain.rig)


def test_from_images_to_a_rig():
    rig = ring(4, size=(480, 384), focal_px=490.0, distortion=LENS)
    subject = wand((0.0, 200.0, 500.0), duration_s=60 / 5, rate=5, seed=4, volume=rig.volume, radius_mm=20.0)
    sources = [Film(np.stack(list(film(camera, subject, seed=c)))) for c, camera in enumerate(rig)]
    detections = detect(sources, cameras=rig.names, rate=5.0)
    method = Wand(radial=1, marker_diameter=40.0)
    fit = calibrate_wand(detections, lengths=[200.0, 300.0], sizes=[c.size for c in rig], method=method)
    assert walking_error(rig, fit.rig) < 0.5
    assert max(camera.residual for camera in fit.rig) < 0.1


def blind(detections, c, keep):
    """The detections of which camera c has those where `keep` says so."""
    return detections.keep((detections.camera != c) | keep)


def test_what_cannot_be_is_told():
    lengths = [150.0, 350.0]
    rig, observed = waved(lengths, frames=100)
    seen = observed.detections
    sizes = [camera.size for camera in rig]
    with pytest.raises(KinemarkError, match=r"Camera cam3 sees the wand's 3 markers in 0 of 100 .* fewer than 3"):
        wand_points(blind(seen, 2, np.zeros(len(seen), bool)), lengths=lengths)
    with pytest.raises(KinemarkError, match=r"come out as 180\.\d \+ 4(19|20)\.\d mm, .* given as 250\.0 \+ 350"):
        calibrate_wand(seen, lengths=[250.0, 350.0], sizes=sizes)
    with pytest.raises(KinemarkError, match=r"come out as 1(49|50)\.\d \+ .* given as 165\.5 \+ 334\.5 mm"):
        calibrate_wand(seen, lengths=[165.5, 334.5], sizes=sizes)
    with pytest.raises(KinemarkError, match=r"Camera cam1 .* more than 2 points.*wand with three"):
        wand_points(seen, lengths=[500.0])
    rng = np.random.default_rng(0)
    counts = np.full_like(seen.counts, 40)
    crowd = Detections.build(seen.cameras, 25.0, counts, rng.uniform(0, 1000, (counts.sum(), 2)))
    with pytest.raises(KinemarkError, match="more than 12 points that move"):
        wand_points(crowd, lengths=lengths)
    with pytest.raises(ValueError, match="sizes has shape"):
        calibrate_wand(seen, lengths=lengths, sizes=sizes[:2])


@pytest.mark.parametrize(
    "frames, words",
    [(8, "has 8 frames; 12 are needed"), (14, r"at most 14 frames together .* 16 are needed .*longer")],
)
def test_recordings_that_are_too_short(frames, words):
    rig, observed = waved([500.0], frames=frames, cameras=3)
    with pytest.raises(KinemarkError, match=words):
        calibrate_wand(observed.detections, lengths=[500.0], sizes=[camera.size for camera in rig])


def test_a_wand_held_still_is_told_from_reflections():
    rig, observed = waved([500.0], frames=60, cameras=3)
    seen, first = observed.detections, [observed.detections[c, 0] for c in range(3)]
    uv = np.concatenate([np.tile(first[c], (60, 1)) for c in range(3)])
    counts = np.repeat([[len(points)] for points in first], 60, axis=1)
    still = Detections.build(seen.cameras, seen.rate, counts, uv)
    with pytest.raises(KinemarkError, match=r"120 points that stand still .* without rest"):
        calibrate_wand(still, lengths=[500.0], sizes=[camera.size for camera in rig])


def test_a_wand_that_never_turns_says_how_little_it_tells():
    """Its focal lengths come out, and their standard deviations hold."""
    rig = ring(4, distortion=LENS)
    xyz = wand((0.0, 500.0), duration_s=120 / 25, rate=25, seed=0, volume=rig.volume).xyz.mean(0)[:, None]
    upright = xyz + np.array([[0.0, 0.0, -250.0], [0.0, 0.0, 250.0]])
    uv = np.stack([project(camera, upright) for camera in rig])
    uv += np.random.default_rng(0).normal(0.0, 0.1, uv.shape)
    seen = Detections.build(rig.names, 25.0, np.full((4, 120), 2), uv.reshape(-1, 2))
    fit = calibrate_wand(seen, lengths=[500.0], sizes=[camera.size for camera in rig])
    sd = np.sqrt([camera.cov[0, 0] for camera in fit.rig])
    assert (np.abs([camera.K[0, 0] - 1300 for camera in fit.rig]) < 4 * sd).all()


def test_a_frame_that_a_camera_lost_is_told():
    """From there on its images are those of the next frame."""
    fit = of_film_with_lost({90: 1}, frames=150)
    (one,) = fit.lost
    assert (one.camera, one.images) == ("cam3", 1)
    assert 88 <= one.first <= one.last <= 92
    assert "cam3 lost 1 image before image" in fit.rig.method


def test_losses_in_both_halves_of_a_film_are_told():
    fit = of_film_with_lost({60: 1, 180: 6}, frames=240)
    assert [(one.camera, one.images) for one in fit.lost] == [("cam3", 1), ("cam3", 6)]


def of_film_with_lost(lost, frames):
    """The rig of four cameras, the third of which lost so many images at some frames."""
    rig, observed = waved([150.0, 350.0], cameras=4, frames=frames)
    seen, frame = observed.detections, np.arange(frames)
    shown = np.minimum(frame + sum(n * (frame >= f) for f, n in lost.items()), frames - 1)
    parts = [seen[c, f] for c in range(4) for f in (shown if c == 2 else frame)]
    counts = np.reshape([len(part) for part in parts], seen.counts.shape)
    film = Detections.build(seen.cameras, seen.rate, counts, np.concatenate(parts))
    return calibrate_wand(film, lengths=[150.0, 350.0], sizes=[camera.size for camera in rig])


@pytest.mark.parametrize("lengths", [[500.0], [150.0, 350.0]], ids=str)
def test_cameras_that_are_late_are_found_out(lengths):
    """One by images and a part, one by so little that cameras fit all the same; the error is that of a wand in time."""
    frames, finer, late = 120, 25, [0.0, 7.64, 0.0, -0.04, 0.0]
    rig = ring(5, distortion=LENS)
    subject = wand(marker_places(lengths), duration_s=frames / 25 + 1, rate=25 * finer, seed=4, volume=rig.volume)
    seen = observe(rig, subject, noise_px=0.1, seed=4).detections
    parts = [seen[c, round((f + late[c] + 1) * finer)] for c in range(5) for f in range(frames)]
    counts = np.reshape([len(part) for part in parts], (5, frames))
    film = Detections.build(rig.names, 25.0, counts, np.concatenate(parts))
    fit = calibrate_wand(film, lengths=lengths, sizes=[camera.size for camera in rig])
    np.testing.assert_allclose(fit.delay, late, atol=0.005)
    assert max(camera.residual for camera in fit.rig) < 0.17
    assert walking_error(rig, fit.rig) < 0.5


def test_cameras_in_time_are_not_moved():
    rig, observed = waved([500.0], cameras=4, frames=120, seed=5, noise_px=0.3)
    fit = calibrate_wand(observed.detections, lengths=[500.0], sizes=[camera.size for camera in rig])
    assert not fit.delay.any()


def test_cameras_on_one_side_do_not_mistake_the_ends_of_nearly_equal_gaps():
    """Depth makes the gaps more unequal than they are, in all images of a frame alike."""
    lengths = [257.0, 243.0]
    rig, observed = waved(lengths, rig=ring(4, radius=2200.0, focal_px=700.0, sweep_deg=50.0), frames=150, seed=3)
    fit = calibrate_wand(observed.detections, lengths=lengths, sizes=[camera.size for camera in rig])
    assert "gaps seen" not in fit.rig.method
    assert max(camera.residual for camera in fit.rig) < 0.16
    assert np.isfinite(fit.residual[..., 0]).sum() - fit.kept.sum() < 10


def mirrored(detections, c, width):
    """The detections of which camera c's images are seen in a mirror."""
    uv = detections.uv.copy()
    mine = detections.camera == c
    uv[mine, 0] = width - 1 - uv[mine, 0]
    return renewed(detections, uv)


def backwards(detections, c):
    """The detections of which camera c's frames come from the last to the first: those of another recording."""
    parts = [detections[i, f] for i in range(len(detections.cameras)) for f in range(detections.n_frames)]
    n = detections.n_frames
    parts[c * n : (c + 1) * n] = parts[c * n : (c + 1) * n][::-1]
    counts = np.reshape([len(part) for part in parts], detections.counts.shape)
    return Detections.build(detections.cameras, detections.rate, counts, np.concatenate(parts))


@pytest.mark.parametrize("lengths", [[500.0], [150.0, 350.0]], ids=str)
@pytest.mark.parametrize("c", [0, 2])
@pytest.mark.parametrize("wrong", ["mirrored", "another recording"])
def test_the_camera_that_is_mirrored_or_another_one_is_named(lengths, c, wrong):
    rig, observed = waved(lengths, cameras=4, frames=120, seed=2)
    seen = observed.detections
    bad = mirrored(seen, c, rig[c].size[0]) if wrong == "mirrored" else backwards(seen, c)
    with pytest.raises(KinemarkError) as error:
        calibrate_wand(bad, lengths=lengths, sizes=[camera.size for camera in rig])
    named = {camera.name for camera in rig if camera.name in str(error.value)}
    assert named == {rig[c].name}


def row_of_eight():
    """Cameras side by side."""
    at = [(1200.0 + 700.0 * c, 1000.0 + 100.0 * (c % 3), 1200.0 + 80.0 * c) for c in np.arange(-3.5, 4.0)]
    looking = [([x, -3000.0, z], [to, 700.0, 850.0]) for x, z, to in at]
    cameras = [look_at(f"cam{c + 1}", *each, focal_px=1000.0) for c, each in enumerate(looking)]
    return Rig(tuple(cameras), "row", ring(4).volume)


@pytest.mark.parametrize("c", [2, 4])
def test_a_mirrored_camera_in_a_row_is_named_by_three_pairs(monkeypatch, c):
    """By a pair with it any other camera seems mirrored; by pairs without it, always this one."""
    rig, observed = waved([150.0, 350.0], rig=row_of_eight(), frames=120, seed=2)
    uv = observed.sight.uv.transpose(0, 2, 1, 3) + np.random.default_rng(c).normal(0, 0.1, (8, 120, 3, 2))
    uv[c, ..., 0] = rig[c].size[0] - 1 - uv[c, ..., 0]
    begun = []
    monkeypatch.setattr(growth, "grow", lambda *of, grow=growth.grow: begun.append(of) or grow(*of))
    with pytest.raises(KinemarkError, match=f"Camera cam{c + 1} sees the others' points mirrored"):
        calibrate_sticks(rig.names, [camera.size for camera in rig], uv, along=[0.0, 150.0, 500.0])
    assert len(begun) < growth.SEEDS


def test_another_ones_images_are_told_before_anything_is_adjusted_to_them(monkeypatch):
    rig, observed = waved([150.0, 350.0], cameras=5, frames=120, seed=4)
    uv = observed.sight.uv.transpose(0, 2, 1, 3) + np.random.default_rng(0).normal(0, 0.1, (5, 120, 3, 2))
    uv[3] = uv[3, ::-1]
    monkeypatch.setattr(from_sizes, "adjusted", None)
    with pytest.raises(KinemarkError, match=r"Camera cam4 does not fit the others: .* of its points lie beside"):
        calibrate_sticks(rig.names, [camera.size for camera in rig], uv, along=[0.0, 150.0, 500.0])


@pytest.mark.parametrize("mirrored_too", [False, True])
def test_of_three_cameras_that_any_two_of_fit_none_is_odd(mirrored_too):
    """Of three that all fit each other any could be left out: none is to blame."""
    rig, observed = waved([150.0, 350.0], cameras=3, frames=120, seed=3)
    seen = observed.detections if not mirrored_too else mirrored(observed.detections, 1, rig[1].size[0])
    uv, along = wand_points(seen, lengths=[150.0, 350.0])[0], marker_places([150.0, 350.0])
    odd = odd_one(rig.names, [camera.size for camera in rig], uv, along=along, method=Bundle())
    assert odd == (rig[1].name if mirrored_too else None)


def held_alike(lengths, axis, **of):
    """A wand whose far end is never towards the side (3) on which the cameras are."""
    subject = wand(marker_places(lengths), rate=25, **of)
    first, last = subject.xyz[0], subject.xyz[-1]
    towards = (last - first) @ axis
    last = last - ((towards + np.abs(towards))[:, None] * axis)  # length and smoothness stay
    share = marker_places(lengths)[:, None, None] / sum(lengths)
    return replace(subject, xyz=first + share * (last - first))


def test_right_gaps_that_depth_changes_in_all_images_are_no_wrong_gaps():
    """A wand that is always held alike: its near gap looks longer in nearly all images of all cameras."""
    lengths, axis = [560.0, 280.0], np.array([np.cos(np.pi / 6), np.sin(np.pi / 6), 0.0])
    rig = ring(4, radius=2000.0, focal_px=600.0, sweep_deg=50.0)
    observed = observe(rig, held_alike(lengths, axis, duration_s=8, seed=5, volume=rig.volume), noise_px=0.1, seed=5)
    fit = calibrate_wand(observed.detections, lengths=lengths, sizes=[camera.size for camera in rig])
    assert max(camera.residual for camera in fit.rig) < 0.16
    assert "gaps seen" not in fit.rig.method
    seen = read_wand(observed.detections, wanted(observed.detections), marker_places(lengths)).ratio
    assert "Measure" in wrong_gaps(seen, marker_places(lengths))  # so it would be said were there no cameras


def test_equal_gaps_that_depth_makes_unequal_are_no_wrong_gaps():
    """A long stick near the cameras: the gaps of most images differ, and none says from which end."""
    rig, observed = waved([500.0, 500.0], rig=ring(4, radius=2200.0, focal_px=700.0), seed=1)
    uv, _ = wand_points(observed.detections, lengths=[500.0, 500.0])
    gap = np.linalg.norm(np.diff(uv, axis=2), axis=-1)
    assert np.nanmedian(np.abs(np.log(gap[..., 0] / gap[..., 1]))) > 0.15
    fit = calibrate_wand(observed.detections, lengths=[500.0, 500.0], sizes=[camera.size for camera in rig])
    assert max(camera.residual for camera in fit.rig) < 0.3


@pytest.mark.parametrize("lengths", [[], [0.0], [1.0, -2.0], [1.0] * 5, [np.nan]], ids=str)
def test_lengths_that_are_none(lengths):
    with pytest.raises(ValueError, match="lengths are"):
        marker_places(lengths)


@pytest.mark.parametrize("bad", [{"radial": 4}, {"reject": 1.0}, {"most_poses": 2}, {"search_radius": 0.0},
                                 {"marker_diameter": -1.0}], ids=str)  # fmt: skip
def test_methods_that_are_none(bad):
    with pytest.raises(ValueError, match=next(iter(bad))):
        Wand(**bad)


def test_of_labelled_markers_a_lost_frame_is_named():
    """`calibrate_sticks` puts nothing in time."""
    rig, observed = waved([150.0, 350.0], cameras=4, frames=150)
    uv = observed.sight.uv.transpose(0, 2, 1, 3)
    uv = uv + np.random.default_rng(0).normal(0.0, 0.1, uv.shape)
    uv[2, 90:-1] = uv[2, 91:]
    with pytest.raises(KinemarkError, match=r"Camera cam3 .*begin at about frame (8|9)\d: it may have lost a frame"):
        calibrate_sticks(rig.names, [camera.size for camera in rig], uv, along=[0.0, 150.0, 500.0])


@pytest.mark.parametrize("turn", [0.3, 1.9, 4.0])
def test_the_bar_of_a_wand_like_a_t_is_read_beside_its_stem(turn):
    flat = np.array([[0.0, 0.0], [80.0, 0.0], [240.0, 0.0], [80.0, 70.0], [80.0, 150.0]])
    across = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    read = read_rows((flat @ across + 300.0)[None], np.array([0.0, 130.0, 390.0]))
    assert read.points[0].tolist() == [0, 1, 2]


def test_cameras_of_parts_of_a_film_are_looked_for_also_where_nobody_is_suspect():
    rows, names = np.zeros((7, 30, 2), np.int64), tuple("abcdefg")
    rows[2, 10:] = -1
    assert _to_ask(rows[:3], names[:3], None).tolist() == [0, 1, 2]
    assert _to_ask(rows, names, None).size == 0  # too many for all
    asked = _to_ask(rows, names, "f").tolist()
    assert 5 in asked and 2 not in asked and len(asked) == 5
