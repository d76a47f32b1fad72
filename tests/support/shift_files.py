"""Cases of the shift law: files, the virtual laboratory, reports."""

import re
import tempfile
from dataclasses import replace
from pathlib import Path as Folder

import numpy as np

import kinemark
from kinemark import geometry, planning, synth
from kinemark.data import Trial
from kinemark.engine.calibration import calibrate, rig_of_dlt
from kinemark.fill import Linear
from kinemark.findings.gaps import filling_figures
from kinemark.io import c3d, um2as
from kinemark.io.control_points import read_control_points
from kinemark.io.rods_toml import read_rods
from kinemark.report import AboutTrial, TrialRecords, quality, summary
from kinemark.report.figures import trajectories_figure
from kinemark.report.scene3d import scene
from kinemark.synth import rods_toml
from support.calibrations import BY_POINTS, HEAD, points_csv, session
from support.shift_law import OPEN, Answer, law, moved
from support.shift_scene import POINTS, frame, observed, rig, tracks, trial, walk

VOLUME = np.array([[0.0, 0.0, 0.0], [2400.0, 1400.0, 2000.0]])

# ---- Files ----


def written(write, read, name, *what):
    """What comes back from a file."""
    with tempfile.TemporaryDirectory() as folder:
        write(Folder(folder) / name, *what)
        return read(Folder(folder) / name)


@law(
    kinemark.write_trajectories_csv,
    kinemark.read_trajectories_csv,
    kinemark.write_trc,
    kinemark.read_trc,
    kinemark.write_trial,
    kinemark.read_trial,
)
def _(by):
    before = moved(trial(), by)
    csv = written(kinemark.write_trajectories_csv, kinemark.read_trajectories_csv, "a.csv", before)
    trc = written(kinemark.write_trc, kinemark.read_trc, "a.trc", before)
    whole = written(
        lambda path, t: kinemark.write_trial(Trial("a", t), path), kinemark.read_trial, "a.h5", before
    ).trajectories
    return Answer((csv.xyz, trc.xyz, whole.xyz), (csv.names, trc.names, whole.names, csv.rate, trc.rate, whole.rate))


@law(kinemark.write_c3d, kinemark.read_c3d, c3d.document_of, c3d.stored, c3d.trial_of, mm=0.501)
def _(by):
    """C3D has single precision: a coordinate of 10 km is kept to half a millimetre."""
    before = Trial("walk", moved(trial(), by))
    after = written(kinemark.write_c3d, kinemark.read_c3d, "a.c3d", before)
    again = c3d.trial_of(c3d.document_of(before), name="walk").trajectories
    paths = [(path.name, path.origin) for path in after.trajectories]
    return Answer((after.trajectories.xyz, again.xyz), paths)


@law(c3d.encode_document, c3d.decode_document, c3d.write_document, c3d.read_document, mm=0.501)
def _(by):
    doc = c3d.document_of(Trial("walk", moved(trial(), by)))
    after = written(c3d.write_document, c3d.read_document, "a.c3d", doc)
    same = c3d.decode_document(c3d.encode_document(doc), name="walk")
    return Answer([c3d.trial_of(each, name="walk").trajectories.xyz for each in (after, same)])


@law(kinemark.save, kinemark.load, kinemark.write_rig_toml, kinemark.read_rig_toml, share=OPEN)
def _(by):
    kept = written(kinemark.save, kinemark.load, "a.h5", moved(tracks(), by))
    cameras = written(kinemark.write_rig_toml, kinemark.read_rig_toml, "rig.toml", moved(rig(), by))
    spread = kinemark.predicted_covariance(cameras, POINTS + by, centroid_sd=0.1)
    seen = geometry.project_all(cameras, POINTS + by)
    return Answer((kept.cloud.xyz, cameras.centres, cameras.volume), (seen, spread, kept.id))


@law(kinemark.write_dlt_csv, kinemark.read_dlt_csv, rig_of_dlt, geometry.cameras_from_dlt, mm=1e-5, share=1e-7)
def _(by):
    """Some cameras have the origin 10 km away before them, others behind."""
    ideal = replace(rig(), cameras=tuple(replace(camera, distortion=np.zeros(5)) for camera in rig()))
    L = geometry.to_dlt(moved(ideal, by).P)

    def read(path):
        return kinemark.read_dlt_csv(path), rig_of_dlt(path, rig().names, "mm")

    after, cameras = written(kinemark.write_dlt_csv, read, "a.csv", L)
    seen = geometry.project_all(cameras, POINTS + by)
    return Answer(cameras.centres, (np.array_equal(after, L), seen, [(camera.K, camera.R) for camera in cameras]))


@law(calibrate)
def _(by):
    """A session whose control points were surveyed 10 km from the origin."""
    with tempfile.TemporaryDirectory() as name:
        folder = Folder(name)
        points_csv(folder, by=by)
        low, high = (VOLUME + by).tolist()
        head = re.sub("volume_mm = .*", f"volume_mm = [{low}, {high}]", HEAD)
        found = calibrate(folder, folder / "results", session(folder, BY_POINTS, head).settings)
    return Answer((found.rig.centres, found.rig.volume), geometry.project_all(found.rig, POINTS + by))


@law(um2as.write_msr, um2as.read_msr, um2as.write_tdc, um2as.read_tdc, um2as.trajectories_of_tdc, mm=1e-3)
def _(by):
    """The files have centimetres with three or four decimals."""
    msr = written(um2as.write_msr, um2as.read_msr, "a.msr", POINTS + by)
    tdc = written(um2as.write_tdc, um2as.read_tdc, "a.tdc", trial().xyz + by)
    names = written(um2as.write_tdc, lambda path: um2as.trajectories_of_tdc(path, rate=50.0), "a.tdc", trial().xyz + by)
    return Answer((msr, tdc, names.xyz))


@law(read_control_points, read_rods, rods_toml)
def _(by):
    def write_points(path, xyz):
        rows = ["name,x_mm,y_mm,z_mm,a_u_px,a_v_px", *(f"p,{x!r},{y!r},{z!r},1,2" for x, y, z in xyz.tolist())]
        path.write_text("\n".join(rows))

    points = written(write_points, lambda path: read_control_points(path, ["a"]), "points.csv", POINTS + by)
    hung = moved(replace(frame(), xyz=np.round(frame().xyz)), by)
    rods = written(lambda path, rods: path.write_text(rods_toml(rods)), read_rods, "rods.toml", hung)
    return Answer((points.xyz, rods.xyz), (points.uv, rods.along))


# ---- The virtual laboratory ----


@law(synth.truth, synth.observe, synth.sphere_ellipse, share=1e-7)
def _(by):
    cameras, subject = moved(rig(), by), moved(walk(), by)
    ellipse = synth.sphere_ellipse(cameras[0], POINTS + by, 12.5)
    found = synth.observe(cameras, subject, noise_px=0.1, false_per_frame=0.3, merge_px=2.0, seed=1)
    return Answer(rest=(synth.truth(cameras, subject), found, ellipse))


@law(synth.film, synth.render, synth.interlace)
def _(by):
    camera, subject, limbs = moved(rig()[0], by), moved(walk(), by), moved(walk().capsules, by)
    limbs = replace(limbs, a=limbs.a[:, :2], b=limbs.b[:, :2])
    few = replace(subject, xyz=subject.xyz[:, :2], capsules=limbs)
    images = list(synth.film(camera, few))
    alone = synth.render(camera, subject.xyz[:, 0], subject.radius_mm, capsules=subject.capsules)
    return Answer(rest=(images, alone, list(synth.interlace(images))))


@law(planning.plan_cameras, planning.predict, planning.walks, mm=1e-6, share=1e-5)
def _(by):
    """One height and distance, so that few candidates are judged."""
    room = planning.Room(VOLUME + by, (2000.0, 2000.0), (2000.0, 2000.0))
    plan = planning.plan_cameras(room, planning.Sensor(), planning.Planning(cameras=3))
    bodies = planning.walks(room, diameter_mm=14.0)
    sizes = {"diameter_mm": 14.0, "least_px": 2.5, "centroid_sd": 0.1}
    again = planning.predict(plan.rig, room, bodies, **sizes)
    rest = (plan.prediction.body, again.volume.sd, again.body, [camera.R for camera in plan.rig])
    return Answer((plan.rig.centres, plan.following.centre, bodies[0].xyz, bodies[1].xyz), rest)


@law(synth.ring, synth.look_at, synth.place_camera, mm=1e-6)
def _(by):
    target = np.array([1200.0, 700.0, 850.0])
    around = synth.ring(3, target=target + by, volume=VOLUME + by, height=(1100.0 + by[2], 2300.0 + by[2]))
    one = synth.look_at("a", np.array([3000.0, 100.0, 900.0]) + by, target + by)
    two = synth.place_camera("b", np.array([3000.0, 100.0, 900.0]) + by, (10.0, 80.0, 5.0))
    cameras = replace(around, cameras=(*around.cameras, one, two))
    return Answer((cameras.centres, cameras.volume), [camera.R for camera in cameras])


@law(
    synth.walking,
    synth.arm,
    synth.wand,
    synth.control_frame,
    synth.calibration_box,
    synth.dot_grid,
    synth.thrown_ball,
    synth.rods_subject,
    synth.stationary,
    synth.with_markers,
    synth.combined_subjects,
    synth.from_trajectories,
    mm=1e-6,
    share=1e-7,
)
def _(by):
    level = np.array([by[0], by[1], 0.0])  # a person walks on the floor, z = 0
    volume = VOLUME + by
    person = synth.walking(middle=np.array([1200.0, 700.0]) + by[:2], duration_s=0.4)
    subjects = [
        synth.arm(shoulder=np.array([300.0, 250.0, 750.0]) + by, duration_s=0.4),
        synth.wand(volume=volume, duration_s=0.4),
        synth.rods_subject(synth.control_frame(volume)),
        synth.calibration_box(corner=by),
        synth.dot_grid(3, 4, middle=by),
        synth.thrown_ball(start=np.array([100.0, 700.0, 900.0]) + by),
        synth.stationary(("a",), POINTS[:1] + by, radius_mm=5.0),
        synth.with_markers(moved(walk(), by), 18),
        synth.combined_subjects(moved(walk(), by), moved(walk(), by)),
        synth.from_trajectories(moved(trial(), by)),
    ]
    return Answer([person.xyz - level + by, *(s.xyz for s in subjects)], [s.names for s in subjects])


# ---- Reports ----


def figures(by):
    trajectories = kinemark.to_trajectories(moved(tracks(), by), moved(rig(), by))
    records = TrialRecords(moved(rig(), by), observed().detections, moved(tracks(), by), trajectories)
    return quality(records, about=AboutTrial("S", "T"), steps=())


@law(quality, summary, share=1e-5)
def _(by):
    found = figures(by)
    text = summary(found)
    places = [found["volume"].pop(key) for key in ("given_mm", "spanned_mm")]
    places += [camera.pop("position_mm") for camera in found["cameras"]]
    return Answer([np.array(place) for place in places], (found, text))


@law(scene, trajectories_figure, filling_figures, mm=0.01)
def _(by):
    paths = kinemark.to_trajectories(moved(tracks(), by), moved(rig(), by))
    traces = [t for t in scene(moved(rig(), by), moved(tracks(), by), paths).data if t["type"] != "mesh3d"]
    lines = [np.stack([np.asarray(t[axis], float) for axis in "xyz"], -1) for t in traces]
    curves = [np.asarray(t["y"], float) for t in trajectories_figure(paths).data]
    filled = kinemark.fill(moved(trial(), by), method=Linear())
    told = filling_figures(filled, moved(trial(), by), source="s", method="linear", limit_mm=20.0)
    return Answer((lines, [np.stack(curves[k : k + 3], -1) for k in range(0, len(curves), 3)]), told)
