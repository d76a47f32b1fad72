"""Cameras from a target that was moved about, a wand or a single marker, at places that were not surveyed."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from ...calibrate.bundle import BundleFit, calibrate_points
from ...calibrate.bundle.stick_gaps import places_of
from ...calibrate.quality.calibration_evidence import Evidence
from ...calibrate.quality.halves import halves_ratio
from ...calibrate.quality.wand import LeftOutPoses, image_errors, judge_poses, seen_by
from ...calibrate.wand import calibrate_wand
from ...data import Detections, Finding, KinemarkError, Severity, make_finding
from ...data.array_types import Floats, Ints
from ...data.finding import red_if
from ...data.progress import tell
from .lens_grids import Lenses, lenses_of
from .task import RigWithEvidence, Task
from .world_placement import placed_in_world

FIELD = 0.5  # height of a round marker by its width in a field, which has every other line; by definition
FEWEST_FRAMES = 20
"""In which two cameras each see one marker; chosen."""
SAME_MM = 1e-6  # mm; gaps that differ by less are the same but for rounding; chosen
MOVED_RED_PX = 1.0
"""By which the image of a camera lies beside that was calibrated as it stood before it was moved; chosen: what is
recorded afterwards is off by as much."""
WRONG_GAP = 0.002
"""Of a wand's length; gaps measured with care, from centre to centre, are not off by more; chosen."""


class FittedRig(NamedTuple):
    """A bundle in a world of its own; along (K) mm of the stick, (1) for a marker; how poses left out judge it, and
    both halves of the film (2)."""

    fit: BundleFit
    along: Floats
    judged: LeftOutPoses
    halves: Floats
    lenses: Lenses


def from_wand(task: Task) -> RigWithEvidence:
    """A stick with markers in a row, waved through the volume."""
    way = task.settings.calibration.wand
    assert way is not None  # the settings see to it
    seen, lenses = task.recorded(way, "wand"), lenses_of(task)
    _check_sizes(seen.sizes)
    method = method_of(task, fields=way.images is not None)
    if way.marker_diameter_mm is not None:
        method = replace(method, marker_diameter=way.marker_diameter_mm)
    tell(0, 1)
    fit = calibrate_wand(
        seen.detections, lengths=way.lengths_mm, sizes=seen.sizes, method=method, lenses=lenses.cameras
    )
    stated = np.array(way.lengths_mm)
    gaps = np.diff(places_of(fit.xyz.reshape(seen.detections.n_frames, -1, 3)))
    gaps = np.where(np.abs(gaps - stated) > SAME_MM, gaps, stated)
    along = np.concatenate([[0.0], np.cumsum(gaps)])
    judged = judge_poses(fit, along, method=method.bundle, lens_held=lenses.cameras is not None)
    halves = halves_ratio(fit, along, method=method.bundle, lens_held=lenses.cameras is not None)
    tell(1, 1)
    way_text = f"a wand of {' + '.join(f'{mm:g}' for mm in stated)} mm"
    made = _placed(task, FittedRig(fit, along, judged, halves, lenses), way_text)
    found = (
        *made.evidence.findings,
        *_changed(stated, gaps),
        *_moved_meanwhile(fit, seen.detections),
        *_late(fit, seen.detections.rate),
        *_lost(fit),
    )
    return made._replace(evidence=replace(made.evidence, known=gaps, lengths=judged.lengths, findings=found))


def _changed(stated: Floats, gaps: Floats) -> Iterator[Finding]:
    """Says where the images contradict the gaps that were measured."""
    difference = float(np.abs(gaps - stated).max())
    if difference > 0:
        severity: Severity = "amber" if difference > WRONG_GAP * stated.sum() else "info"
        yield make_finding(
            "wand_gaps_differ", severity=severity, stated_mm_list=stated.tolist(), seen_mm_list=gaps.tolist()
        )


def _moved_meanwhile(fit: BundleFit, detections: Detections) -> Iterator[Finding]:
    """Says that a camera was moved between the first frame and the last."""
    if (step := fit.step) is not None:
        yield make_finding(
            "camera_moved_while_calibrating",
            severity=red_if(step.kept != "after" and step.px > MOVED_RED_PX),
            cameras=[step.camera] if step.alone else [],
            frames=[(step.frame + 1, detections.n_frames)],
            offset_px=step.px,
            kept=step.kept,
            from_s=step.frame / detections.rate,
        )


def _late(fit: BundleFit, rate: float) -> Iterator[Finding]:
    """Says which cameras took their images, at `rate` Hz, later than the others."""
    for name, images in zip(fit.rig.names, fit.delay.tolist(), strict=True):
        if images:
            yield make_finding(
                "camera_late_while_calibrating", cameras=[name], late_images=images, delay_ms=1000 * images / rate
            )


def _lost(fit: BundleFit) -> Iterator[Finding]:
    """Says which cameras lost images in the course of the film."""
    for one in fit.lost:
        yield make_finding(
            "camera_lost_images_while_calibrating",
            cameras=[one.camera] if one.alone else [],
            frames=[(one.first + 1, one.last + 1)],
            images=one.images,
        )


def from_single_marker(task: Task) -> RigWithEvidence:
    """One marker moved through the volume, and a known distance for the scale."""
    way = task.settings.calibration.single_marker
    assert way is not None
    seen, lenses = task.recorded(way, "marker"), lenses_of(task)
    _check_sizes(seen.sizes)
    uv, cov = _single(seen.detections)
    tell(0, 1)
    method = method_of(task, fields=way.images is not None)
    known = cov if np.isfinite(cov[np.isfinite(uv[..., 0])]).all() else None
    fit = calibrate_points(task.names, seen.sizes, uv, cov=known, method=method, lenses=lenses.cameras)
    judged = judge_poses(fit, np.zeros(1), method=method, lens_held=lenses.cameras is not None)
    halves = halves_ratio(fit, np.zeros(1), method=method, lens_held=lenses.cameras is not None)
    tell(1, 1)
    made = _placed(task, FittedRig(fit, np.zeros(1), judged, halves, lenses), "a single marker")
    found = (*made.evidence.findings, *_moved_meanwhile(fit, seen.detections))
    return made._replace(evidence=replace(made.evidence, findings=found))


def method_of(task: Task, *, fields: bool) -> Any:
    """The session's, with the shape of pixels that interlaced video has where frames are its `fields`."""
    method: Any = task.settings.calibrate
    fields = fields and bool(task.settings.cameras.first_field)
    return replace(method, aspect=FIELD) if fields and method.aspect is None else method


def _check_sizes(sizes: Ints) -> None:
    if (sizes < 1).any():
        raise KinemarkError(
            "The size of the images is not known, and without it nothing of the lenses. Set size_px = [width, height] "
            "in [cameras]; of cameras that differ, size_px = { cam1 = [width, height], … }."
        )


def _single(detections: Detections) -> tuple[Floats, Floats]:
    """Where each camera sees the one marker of a frame, (C, F, 2) px, NaN where it sees none or more; covariance."""
    rows = np.flatnonzero(detections.valid)
    c, f = detections.camera[rows], detections.frame[rows]
    count = np.zeros(detections.counts.shape, np.int64)
    np.add.at(count, (c, f), 1)
    alone = count[c, f] == 1
    uv = np.full((*count.shape, 2), np.nan)
    cov = np.full((*count.shape, 2, 2), np.nan)
    uv[c[alone], f[alone]], cov[c[alone], f[alone]] = detections.uv[rows[alone]], detections.cov[rows[alone]]
    both = int((np.isfinite(uv[..., 0]).sum(0) >= 2).sum())
    if both < FEWEST_FRAMES:
        raise KinemarkError(
            f"In {both} frames do two cameras see exactly one marker, and {FEWEST_FRAMES} are the least. Mask "
            "reflections and lamps, see [masks], and move one marker only."
        )
    return uv, cov


def _placed(task: Task, fitted: FittedRig, way: str) -> RigWithEvidence:
    """The rig in the world that the session wants, with the evidence of the bundle."""
    k = len(fitted.along)
    placed = placed_in_world(task, fitted.fit, unscaled=k == 1)
    fit = placed.fit
    errors = image_errors(fitted.judged.residual.reshape(len(fit.rig), -1, 2))
    nowhere = np.full((2, 3), np.nan)
    evidence = Evidence(
        way=way,
        xyz=fit.xyz,
        uv=seen_by(fit, k).reshape(len(fit.rig), -1, 2),
        residual=fit.residual,
        kept=fit.kept,
        left_out=errors,
        place=fit.xyz.reshape(-1, k, 3).mean(1),
        halves=fitted.halves,
        checks=placed.checks,
        joint=fit.joint,
        world=placed.world,
        freedom=fit.freedom,
        straight=fitted.lenses.straight,
        findings=(*fitted.lenses.findings, *placed.findings),
        surveyed=False,
    )
    return RigWithEvidence(replace(fit.rig, volume=nowhere), evidence)
