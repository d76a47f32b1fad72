"""Residuals that go with the place in the image: a lens term that was not fitted."""

from dataclasses import replace

import numpy as np
import pytest

from kinemark.calibrate.bundle import Bundle, calibrate_sticks
from kinemark.calibrate.quality.calibration_evidence import Evidence
from kinemark.calibrate.quality.lens_trend import FEWEST, NONE, lens_trend
from kinemark.findings.calibration_quality import calibration_figures
from kinemark.geometry import project_all
from kinemark.report.words import advice_of, text_of
from kinemark.synth import ring, wand
from support.findings import found

ALONG = np.array([0.0, 500.0])
POSES = wand(ALONG, duration_s=48.0, rate=2.5).xyz.transpose(1, 0, 2).reshape(-1, 3)
LENS = (-0.12, 0.06, 1.5e-3, -1.5e-3, 0.0)
PLAIN = (-0.12, 0.06, 0.0, 0.0, 0.0)


def trends(lens, seed, noise=0.2, **method):
    """What is said of each of four cameras, and the figures, of a wand seen through a lens."""
    true = ring(4, distortion=lens)
    uv = project_all(true, POSES) + noise * np.random.default_rng(seed).normal(size=(4, len(POSES), 2))
    inside = ((uv > 0) & (uv < true[0].size)).all(-1)
    uv = np.where(inside[..., None], uv, np.nan)
    fit = calibrate_sticks(
        true.names,
        [c.size for c in true],
        uv.reshape(4, -1, 2, 2),
        along=ALONG,
        method=Bundle(usual_lens=False, **method),
    )
    residual = np.where(fit.kept[..., None], fit.residual, np.nan)
    evidence = Evidence(
        "a wand", xyz=fit.xyz, uv=uv, residual=fit.residual, kept=fit.kept, joint=fit.joint, freedom=fit.freedom,
        surveyed=False,
    )  # fmt: skip
    said = [lens_trend(camera, fit.xyz, r) for camera, r in zip(fit.rig, residual, strict=True)]
    return said, replace(fit.rig, volume=np.full((2, 3), np.nan)), evidence


@pytest.mark.parametrize(
    ("lens", "method", "terms"),
    [(LENS, {}, "sideways"), ((-0.12, 0.5, 0.0, 0.0, 0.0), {"radial": 1}, "radial")],
)
def test_a_lens_term_that_is_missing_is_told_with_its_remedy(lens, method, terms):
    said, rig, evidence = trends(lens, 0, noise=0.05, **method)
    assert sum(one.terms == terms for one in said) >= 2
    figures = calibration_figures(rig, evidence)
    (one,) = found(figures, "lens_term_missing")
    assert one.severity == "amber" and figures["verdict"]["grade"] == "amber"
    assert one.values["sideways" if terms == "sideways" else "radial"]
    assert "terms that were not fitted" in text_of(one)
    assert ("tangential = true" if terms == "sideways" else "radial = 2") in advice_of(one)


@pytest.mark.parametrize("seed", range(2))
def test_a_lens_that_was_fitted_leaves_none(seed):
    said, rig, evidence = trends(PLAIN, seed)
    assert said == [NONE] * 4
    assert not found(calibration_figures(rig, evidence), "lens_term_missing")


def test_few_images_or_nothing_held_say_nothing():
    camera = ring(2)[0]
    few = np.full((FEWEST - 1, 2), 0.1)
    assert lens_trend(camera, POSES[: FEWEST - 1], few) is None
    free = replace(camera, cov=np.eye(15))
    assert lens_trend(free, POSES, np.full((len(POSES), 2), 0.1)) is None
