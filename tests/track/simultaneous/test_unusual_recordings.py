"""Recordings of subjects who leave the view and come back: nothing is said of the cameras that is not so."""

import numpy as np
import pytest

from kinemark.report.words import advice_of, text_of
from kinemark.track.simultaneous import Simultaneous, diagnose, track_simultaneously
from support.laboratory import observe, ring
from support.scenes.bodies import walker
from support.scenes.imaging import Optics, images
from support.scenes.placements import off, rig

METHOD = Simultaneous()
OPTICS = Optics(noise=0.15, stated=False, merge=4, marked=False, dropout=0.0, false=0.2)


def walks_past(seed, kind="walk", rate=100.0, frames=450, gone=(150, 300)):
    """Six cameras and someone who walks out of their common view, with nothing to be seen in frames `gone`."""
    rng = np.random.default_rng([seed, 5])
    body = walker(kind, 20, np.arange(frames) / rate, rng, False)
    true = rig("ring", 6, 4200, rng)
    hidden = np.zeros((20, frames, 1), bool)
    hidden[:, slice(*gone)] = True
    body = body._replace(xyz=np.where(hidden, 1e7, body.xyz))
    return images(true, body, rate, OPTICS, rng)[0], off(true, 0.1, rng)


@pytest.mark.parametrize(
    "seed, other",
    [
        (1, {}),  # two cameras "stood otherwise": at the edges of their images lenses fit less well
        (2, {}),  # a camera "was moved": it saw the subject's back, and some of the markers
        (2, {"kind": "run", "rate": 500.0, "frames": 800, "gone": (0, 0)}),  # as before, of a runner
    ],
)
def test_nothing_is_said_of_cameras_which_a_subject_leaves(seed, other):
    detections, calibrated = walks_past(seed, **other)
    assert diagnose(detections, calibrated, track_simultaneously(detections, calibrated, METHOD)) == []


def test_a_wheel_that_turns_too_fast_for_the_rate_need_not_be_of_another_rate():
    """Ten turns a second at 50 Hz, radius .3 m."""
    rng, rig = np.random.default_rng(312), ring(6)
    angle = 2 * np.pi * 10 * np.arange(100) / 50 + rng.uniform(0, 6, (8, 1))
    r = rng.uniform(180, 300, (8, 1))
    xyz = np.stack([r * np.cos(angle), 0 * angle, 900 + r * np.sin(angle)], -1)
    detections = observe(rig, xyz, noise=0.1, rate=50.0)[0]
    found = diagnose(detections, rig, track_simultaneously(detections, rig, Simultaneous()))
    (said,) = (one for one in found if one.kind == "nothing_goes_on")
    assert "or too low for what was recorded" in text_of(said) and "record at a higher one" in advice_of(said)
