"""Every page of the report, with names of our choice everywhere; what is in a page, and its drawings."""

import json
import re
from dataclasses import replace

import numpy as np

from kinemark.data import MarkerTrajectory, Rig, Step, Trajectories, Trial, make_finding
from kinemark.engine.angles.of_trial import AngleSettings, trial_angles
from kinemark.fill import Linear, fill
from kinemark.findings.calibration_quality import calibration_figures
from kinemark.findings.gaps import filling_figures
from kinemark.findings.plan_figures import plan_figures
from kinemark.findings.sensitivity_figures import sensitivity_figures
from kinemark.io.model_toml import load_model
from kinemark.planning import Planning, Room, Sensor, plan_cameras
from kinemark.report.angles_page import angles_page
from kinemark.report.calibration_page import calibration_page
from kinemark.report.filling_page import filling_page
from kinemark.report.page import page as report_page
from kinemark.report.plan_page import plan_page
from kinemark.report.sensitivity_page import sensitivity_page
from kinemark.sensitivity import rank
from kinemark.synth import arm
from support.calibrations import POINTS, RIG, of_control_points, seen
from support.captures import capture, judge, ring, walk
from support.error_budget import recorded


def report(name):
    """The report of a trial in which everything is called so."""
    rig = replace(ring(names=[f"{name}{c}" for c in range(4)]), method=name)
    records = capture(rig, walk(), names=[f"{name}{m}" for m in range(3)])
    steps = [Step(name, name, {name: name}, name, name, 1.0)]
    findings = [
        make_finding("grid_image_unused", cameras=[name], reason=name),
        make_finding("angle_beyond_normal", joint=name, angle=name, frames_share=0.5, most_deg=3.0),
    ]
    figures = judge(rig, records, session=name, trial=name, steps=steps, findings=findings)
    return report_page(quality=figures, rig=rig, **records)


def calibration(name):
    """The page of a calibration by control points."""
    rig, evidence = of_control_points(seen(RIG, POINTS, 0.05, np.random.default_rng(1)))
    rig = Rig(tuple(replace(camera, name=f"{name}{camera.name}") for camera in rig), name, rig.volume)
    evidence = replace(evidence, names=tuple(f"{name}{point}" for point in evidence.names))
    return calibration_page(figures=calibration_figures(rig, evidence, session=name), rig=rig, evidence=evidence)


def gaps(name):
    """The page of a filled trial: one gap is filled, and one stayed open."""
    xyz = walk(frames=120)
    xyz[0, 40:60] = xyz[1, 50:55] = np.nan
    before = capture(ring(), xyz, names=[f"{name}{m}" for m in range(3)])["trajectories"]
    filled = fill(before, method=Linear(), limit_mm=np.inf)
    first, *others = filled.gaps
    odd = replace(first, method="", state="not_predicted", reason=name, reference_markers=(f"{name}2",))
    filled = filled._replace(gaps=(odd, *others))
    figures = filling_figures(filled, before, source=name, method=name, limit_mm=np.inf)
    return filling_page(figures=figures, trajectories=filled.trajectories, before=before)


def angles(name):
    """The page of joint angles with cycles."""
    subject = arm(duration_s=2.0, seed=2)
    paths = [MarkerTrajectory.measured(*one) for one in zip(subject.names, subject.xyz, strict=True)]
    trial = Trial(name, Trajectories(tuple(paths), 50.0))
    model = load_model("um2as")
    model = replace(
        model,
        name=name,
        source=name,
        aliases={},
        joints=tuple(replace(joint, name=name + joint.name) for joint in model.joints),
    )
    found = trial_angles(trial, model=model, settings=AngleSettings(cycle=("0-1", "1-1.9"), marker_sd_mm=0.7))
    return angles_page(
        figures=found.figures, angles=found.angles, model=found.model, points=found.points, cycles=found.cycles
    )


def sensitivity(name):
    """The page of what limits a trial."""
    rig = ring(names=[f"{name}{c}" for c in range(4)])
    there = recorded(rig)
    ranking = rank(rig, there._replace(names=tuple(f"{name}{marker}" for marker in there.names)))
    figures = sensitivity_figures(ranking, session=name, trial=name)
    return sensitivity_page(figures=figures, ranking=ranking, rig=rig)


def plan(name):
    """The page of a plan, whose cameras have such names."""
    room = Room(np.array([[0.0, 0.0, 0.0], [1500.0, 1000.0, 1500.0]]), (2000.0, 2000.0), (1800.0, 1800.0))
    found = plan_cameras(room, Sensor(), Planning(cameras=3))
    cameras = tuple(replace(camera, name=f"{name}{c}") for c, camera in enumerate(found.rig))
    found = found._replace(rig=Rig(cameras, name, found.rig.volume))
    return plan_page(figures=plan_figures(found), plan=found)


PAGES = {
    "report": report,
    "calibration": calibration,
    "gaps": gaps,
    "angles": angles,
    "sensitivity": sensitivity,
    "plan": plan,
}
"""Every page that Kinemark writes: a function of the name that everything in it has."""


def data_of(html):
    """What the page's scripts read, by the place where it is drawn."""
    return {place: json.loads(text) for place, text in raw_data_of(html).items()}


def raw_data_of(html):
    """The same as it stands in the page."""
    return dict(
        re.findall(r'<script type="application/json" (?:data-for|id)="([\w-]+)">(.*?)</script>', html, re.DOTALL)
    )


def texts(value):
    """All texts in a value of JSON."""
    if isinstance(value, str):
        yield value
    elif isinstance(value, dict):
        for key, part in value.items():
            yield key
            yield from texts(part)
    elif isinstance(value, list):
        for part in value:
            yield from texts(part)
