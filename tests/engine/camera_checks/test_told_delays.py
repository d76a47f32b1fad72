"""A trial tries the delays that the wand's film told of its cameras, and keeps to what its own images say."""

from types import SimpleNamespace

import numpy as np
import pytest

from kinemark.data import make_finding
from kinemark.engine import tracking_in_time
from kinemark.engine.camera_checks.told_delays import told_delays
from kinemark.engine.tracking_stage import from_detections
from kinemark.reconstruct import LeastSquares
from kinemark.report.words import advice_of, text_of
from kinemark.track.simultaneous.simultaneous_method import DEFAULT
from support.laboratory import observe, ring
from support.motions import dance

RIG, FRAMES, RATE = ring(4), 60, 50.0
MS = 1000 / RATE


def recorded(late):
    """Detections of four cameras at 50 Hz that are late by so many images each, and where the points are in time."""
    ms = np.arange(-500, 1000 * FRAMES // int(RATE) + 500)
    points = dance(n=10, frames=len(ms), rate=1000.0)
    at = [500 + np.rint((np.arange(FRAMES) + by) * MS).astype(int) for by in late]
    each = [observe(RIG.select([one.name]), points[:, own], noise=0.1, rate=RATE, seed=c)[0]
            for c, (one, own) in enumerate(zip(RIG, at, strict=True))]  # fmt: skip
    counts, uv, cov = (np.concatenate([getattr(one, name) for one in each]) for name in ("counts", "uv", "cov"))
    there = points[:, 500 + np.rint(np.arange(FRAMES) * MS).astype(int)]
    return type(each[0]).build(RIG.names, RATE, counts, uv, cov), there


def figures(late):
    """Of a calibration whose film told that cameras were late by so many images of 50 Hz."""
    told = [
        make_finding("camera_late_while_calibrating", cameras=[name], late_images=by, delay_ms=by * MS)
        for name, by in zip(RIG.names, late, strict=True)
        if by
    ]
    return {"findings": [one.as_dict() for one in told]}


def tracked(detections, told, **delays_ms):
    settings = SimpleNamespace(
        track=DEFAULT, reconstruct=LeastSquares(), match=None, cameras=SimpleNamespace(delays_ms=delays_ms)
    )
    source = SimpleNamespace(of=SimpleNamespace(entry=SimpleNamespace(images=None)))
    calibrated = SimpleNamespace(figures=figures(told))
    inputs = SimpleNamespace(rig=RIG, settings=settings, source=source, calibrated=calibrated)
    return from_detections(inputs, {"detect": detections})


def astray(of, points):
    """mm from each point of the tracks to the nearest of its frame, the median."""
    cloud = of.tracks.cloud
    off = np.linalg.norm(cloud.xyz[:, None] - points[:, cloud.frame].transpose(1, 0, 2), axis=2).min(1)
    return float(np.median(off)), len(off)


def test_cameras_that_are_as_late_as_they_were_at_the_wand_are_tracked_so_and_it_is_said():
    late = (0.0, 6.4, -3.3, 6.4)
    seen, points = recorded(late)
    alone, told = tracked(seen, (0.0,) * 4), tracked(seen, late)
    off, n = astray(told, points)
    assert off < 1.0 and n > 0.95 * points.shape[0] * FRAMES
    assert off < astray(alone, points)[0] / 3
    found = {one.cameras[0]: one for one in told.diagnostics if one.kind == "camera_late_as_calibrated"}
    assert {name: one.values["images"] for name, one in found.items()} == {"c1": 6, "c2": -3, "c3": 6}
    assert "128" in text_of(found["c1"]) and "as the film of the calibration told" in text_of(found["c1"])
    assert "delays_ms.c2 = -66 below [cameras]" in advice_of(found["c2"])
    np.testing.assert_allclose(told.cameras.delay * 1000, [0, 8, -6, 8], atol=0.5)


@pytest.mark.parametrize("told", [(0.0, 5.0, 0.0, 0.0), (0.0, 0.0, 0.6, -2.0)])
def test_cameras_that_are_in_time_in_the_trial_are_not_taken_for_late(told):
    seen, points = recorded((0.0,) * 4)
    found = tracked(seen, told)
    assert not found.diagnostics
    assert astray(found, points)[0] < 1.0 and not found.cameras.delay.any()


def test_delays_that_are_stated_are_not_told_again():
    assert told_delays(figures((0.0, 2.0, 1.0, 0.0)), {"c1": 40.0}) == {"c2": 20.0}
    assert told_delays({}, {}) == {}


def scored(images, off, findings=()):
    """Of tracks in which camera c1 has so many images, which are off by px, and `images` beyond two confirm points."""
    return SimpleNamespace(images=images, off=np.sort(off), tracks=None, diagnostics=findings)


@pytest.mark.parametrize(
    ("again", "kept"),
    [
        (scored(156, np.full(160, 0.1)), True),  # 14 fewer of 170 are chance
        (scored(100, np.full(160, 0.1)), False),
        (scored(240, np.full(200, 0.5)), True),
        (scored(170, np.r_[np.full(80, 0.1), np.full(20, 0.2)]), False),  # those that were far are lost
    ],
)
def test_fewer_images_by_chance_do_not_refuse_what_lies_nearer_and_lost_ones_are_no_gain(monkeypatch, again, kept):
    before = scored(170, np.r_[np.full(99, 0.1), np.full(101, 0.4)])
    monkeypatch.setattr(tracking_in_time, "_confirmed", lambda tracks: next(counts))
    monkeypatch.setattr(tracking_in_time, "_offsets", lambda tracked, *_: tracked.off)
    counts = iter((again.images, before.images))
    seen, _ = recorded((0.0,) * 4)
    assert tracking_in_time._fits_better(again, before, seen, {"c1"}) == kept


def test_told_delays_that_the_trial_takes_back_are_not_kept(monkeypatch):
    seen, _ = recorded((0.0,) * 4)
    learned = make_finding("camera_delay_learned", cameras=["c1"], delay_ms=-2.8, delay_se_ms=0.1, state_ms=-2.8)
    before = scored(170, np.full(200, 0.2))
    monkeypatch.setattr(tracking_in_time, "_again", lambda *_: scored(400, np.full(200, 0.1), (learned,)))
    monkeypatch.setattr(tracking_in_time, "_confirmed", lambda tracks: next(counts))
    monkeypatch.setattr(tracking_in_time, "_offsets", lambda tracked, *_: tracked.off)
    for told_ms, kept in ((3.0, False), (20.0, True)):
        counts = iter((400, 170))
        got = tracking_in_time._as_told({"c1": told_ms}, seen, RIG, before, DEFAULT, LeastSquares())
        assert (got is not before) == kept
