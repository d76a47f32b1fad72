"""Cases of the shift law: camera geometry, calibration, sensitivity."""

from dataclasses import replace
from functools import cache

import numpy as np

import kinemark
from kinemark import calibrate, geometry, sensitivity, synth
from kinemark.calibrate import bundle, control_frame, control_points, l_frame, quality, world_check, world_frame
from kinemark.calibrate.quality.halves import halves_ratio
from kinemark.data import MarkerTrajectory, Rig, Trajectories
from kinemark.sensitivity import joints
from support.shift_law import OPEN, Answer, law, moved, on_grid
from support.shift_scene import POINTS, calibrated, frame, observed, rig, tracks, walk


def seen_points(by=0.0):
    """(N, C, 2) px of `POINTS`, noisy, some not seen."""
    uv = geometry.project_all(rig(), POINTS) + np.random.default_rng(6).normal(0, 0.1, (len(rig()), len(POINTS), 2))
    uv[0, ::4] = np.nan
    return uv.swapaxes(0, 1)


@law(geometry.project, geometry.project_all, geometry.to_camera, geometry.sphere_offset, geometry.point_jacobian)
def _(by):
    cameras, xyz = moved(rig(), by), POINTS + by
    one = cameras[0]
    uv = geometry.project(one, xyz), geometry.project_all(cameras, xyz), geometry.to_camera(one, xyz)
    return Answer(rest=(*uv, geometry.sphere_offset(one, xyz, diameter=30.0), geometry.point_jacobian(one, xyz)))


@law(geometry.parameter_jacobian, share=1e-8)
def _(by):
    """A turn about the origin of the world moves what is 10 km away; one about the camera's centre does not."""
    camera = moved(rig()[0], by)
    J = geometry.parameter_jacobian(camera, POINTS + by)
    x, y, z = camera.t
    about_centre = J[..., 9:12] - J[..., 12:] @ np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return Answer(rest=(J[..., :9], J[..., 12:], about_centre))


@law(
    geometry.triangulate,
    geometry.refine,
    geometry.undistort,
    geometry.distort,
    geometry.rays,
    geometry.normalised,
    share=OPEN,
)
def _(by):
    cameras, uv = moved(rig(), by), seen_points()
    ideal = np.stack([geometry.undistort(camera, uv[:, c]) for c, camera in enumerate(cameras)], 1)
    guess = geometry.triangulate(ideal, cameras.P)
    cov = np.broadcast_to(0.01 * np.eye(2), (*uv.shape, 2))
    found = geometry.refine(cameras, guess, uv, cov)
    one = cameras[1]
    rest = geometry.distort(one, ideal[:, 1]), geometry.rays(one, uv[:, 1]), geometry.normalised(one, uv[:, 1])
    return Answer((guess, found.xyz), (found.cov, found.residual, ideal, rest))


@law(
    geometry.camera_about,
    geometry.rig_about,
    geometry.joint_about,
    geometry.origin_near,
    geometry.parameters_about,
    share=OPEN,
)
def _(by):
    cameras, xyz = moved(rig(), by), POINTS + by
    origin = geometry.origin_near(xyz)
    near, joint = geometry.rig_about(cameras, origin), quality.joint_of(cameras)
    one = geometry.camera_about(cameras[0], origin)
    assert np.allclose(one.cov, near[0].cov)
    spread = geometry.joint_about(cameras, joint, origin)
    return Answer(origin, (near.centres, near.volume, geometry.project_all(near, xyz - origin), spread))


@law(geometry.rigid_align, geometry.rigid_poses)
def _(by):
    turn = geometry.nearest_rotations(np.random.default_rng(1).normal(size=(3, 3)))
    there = on_grid(POINTS @ turn.T) + on_grid(np.random.default_rng(2).normal(0, 1, POINTS.shape))
    R, t = geometry.rigid_align(POINTS + by, there + by)
    rotations, centres = geometry.rigid_poses(POINTS, np.stack([there, POINTS]) + by)
    return Answer((POINTS @ R.T + (t + R @ by - by) + by, centres), (R, rotations))


@law(geometry.fundamental, geometry.epipolar_lines, geometry.line_distance, geometry.epipolar_constants, share=1e-8)
def _(by):
    cameras, uv = moved(rig(), by), geometry.project_all(rig(), POINTS)
    F = geometry.fundamental(cameras[0].P, cameras[1].P)
    m = geometry.epipolar_constants(geometry.to_dlt(cameras[0].P), geometry.to_dlt(cameras[1].P))
    m = m * np.sign(m[np.abs(m).argmax()])
    lines = geometry.epipolar_lines(F, uv[0])
    return Answer(rest=(F * np.sign(F[2, 2]), m, geometry.line_distance(lines, uv[1])))


@law(geometry.fit_dlt, geometry.to_dlt, geometry.from_dlt, geometry.decompose, geometry.camera_from_dlt)
def _(by):
    ideal = replace(rig()[0], distortion=np.zeros(5))
    uv = geometry.project(ideal, POINTS) + np.random.default_rng(1).normal(0, 0.1, (len(POINTS), 2))
    L = geometry.fit_dlt(POINTS + by, uv)
    again = geometry.to_dlt(geometry.from_dlt(L))
    found = geometry.camera_from_dlt("one", again, front=POINTS[0] + by)
    K, R, _ = geometry.decompose(geometry.from_dlt(L), front=POINTS[0] + by)
    return Answer(found.centre, (found.K, found.R, K, R, geometry.project(found, POINTS + by)))


# ---- Calibration ----


def in_the_world(cameras, by):
    """Cameras without what is about the world's origin: centres, and all else that places and images need."""
    rest = [(camera.K, camera.R, camera.distortion, camera.size, camera.residual) for camera in cameras]
    cov = kinemark.predicted_covariance(cameras, POINTS[:5] + by, centroid_sd=0.1)
    return (cameras.centres, cameras.volume), (rest, cov, geometry.project_all(cameras, POINTS + by))


def of_fit(fit, by):
    """A `ControlFit` without what its rig's covariances are about."""
    places, rest = in_the_world(fit.rig, by)
    return Answer((places, fit.xyz), (rest, fit._replace(rig=None, xyz=None, method=None, lenses=None)))


WAYS = {
    "bundle": {},
    "lens": {"method": calibrate.ControlPoints(radial=2, tangential=True)},
    "spheres": {"diameter": 25.0},
    "dlt": {"method": calibrate.Dlt()},
    "linearised": {"lenses": True},
}


@law(
    calibrate.control_point_quality,
    kinemark.calibrate_control_points,
    calibrate.judge_control_points,
    each=WAYS,
    mm=1e-6,
    share=OPEN,
)
def _(by, parameter):
    options = dict(parameter)
    if "lenses" in options:
        options["lenses"] = [replace(camera, cov=np.zeros((15, 15))) for camera in true_rig()]
    fit = calibrated(true_rig(), by, **options)
    answer = of_fit(fit, by)
    return Answer(answer.places, (answer.rest, calibrate.judge_control_points(fit)))


def true_rig():
    return synth.ring(4, distortion=(-0.1, 0.02, 0.0, 0.0, 0.0))


@law(control_points.fit_camera, mm=1e-6, share=OPEN)
def _(by):
    camera, xyz = true_rig()[0], frame().xyz.reshape(-1, 3)
    uv = geometry.project(camera, xyz) + np.random.default_rng(1).normal(0, 0.1, (len(xyz), 2))
    uv[3] += 30.0
    cov = np.tile(np.eye(2), (len(xyz), 1, 1))
    found = control_points.fit_camera("one", camera.size, xyz + by, uv, cov, method=calibrate.ControlPoints())
    one = found.camera
    return Answer(one.centre, (one.K, one.R, one.distortion, one.residual, found._replace(camera=None)))


@law(
    kinemark.calibrate_control_frame,
    control_frame.control_frame_quality,
    calibrate.identify_markers,
    calibrate.recognise_control_frame,
    mm=1e-6,
    share=OPEN,
)
def _(by):
    there, few = moved(frame(), by), Rig(true_rig().cameras[:2])
    seen = synth.observe(few, synth.rods_subject(frame()), noise_px=0.05, seed=2).detections
    sizes = [camera.size for camera in few]
    fit = control_frame.control_frame_quality(seen, there, sizes=sizes)
    uv = seen.uv[seen.rows(0, 0)]
    found = calibrate.recognise_control_frame(uv, there), calibrate.identify_markers(uv, there)
    answer = of_fit(fit, by)
    return Answer(answer.places, (answer.rest, found))


@cache
def waved():
    """A stick waved about in the cameras' middle: markers (F, 2, 3) mm, and their images (C, F, 2, 2) px."""
    xyz = on_grid(synth.wand((0.0, 500.0), duration_s=20.0, rate=2.5).xyz).swapaxes(0, 1)
    return xyz, geometry.project_all(rig(), xyz) + np.random.default_rng(4).normal(
        0, 0.1, (len(rig()), *xyz.shape[:2], 2)
    )


@law(bundle.bundle, bundle.sticks_through, quality.judge_poses, mm=1e-6, share=OPEN)
def _(by):
    xyz, uv = waved()
    sticks = bundle.sticks_through(xyz + by, np.array([0.0, 500.0]))
    fit = bundle.bundle(moved(rig(), by), [sticks], uv.reshape(len(uv), -1, 2))
    judged = quality.judge_poses(fit, np.array([0.0, 500.0]), method=bundle.Bundle(), folds=2)
    halves = halves_ratio(fit, np.array([0.0, 500.0]), method=bundle.Bundle())
    rest = [(camera.K, camera.R, camera.distortion, camera.residual) for camera in fit.rig]
    spread = kinemark.predicted_covariance(fit.rig, POINTS[:5] + by, centroid_sd=0.1, joint=fit.joint)
    return Answer(
        (fit.xyz, fit.rig.centres), (rest, spread, fit.residual, fit.kept, fit.chi2, fit.freedom, judged, halves)
    )


@law(calibrate.wand_lengths, share=OPEN)
def _(by):
    found = calibrate.wand_lengths(moved(rig(), by), waved()[1], along=[0.0, 500.0])
    return Answer(found.place, found._replace(place=None))


@law(calibrate.assign_points)
def _(by):
    xyz = frame().xyz.reshape(-1, 3)
    uv = geometry.project(true_rig()[1], xyz)
    return Answer(rest=calibrate.assign_points(uv[::-1], xyz + by, picked=np.arange(0, 24, 4), at=uv[::4]))


VOLUME = np.array([[200.0, 200.0, 100.0], [2200.0, 1200.0, 1800.0]])


@law(quality.map_volume, quality.volume_grid, quality.points_of, quality.view_volume, mm=1e-6, share=OPEN)
def _(by):
    cameras = moved(rig(), by)
    found = calibrate.map_volume(cameras, VOLUME + by, centroid_sd=0.1, places=60)
    axes = quality.volume_grid(VOLUME + by, places=60)
    grid = np.stack([axis[:4] for axis in found.axes], -1)
    return Answer((grid, quality.points_of(axes), quality.view_volume(cameras)), found._replace(axes=None))


@law(
    kinemark.predicted_covariance,
    quality.apart_from_frame,
    quality.joint_of,
    quality.visible,
    quality.views,
    quality.covariance_from,
    quality.world_pose,
    share=OPEN,
)
def _(by):
    cameras, xyz = moved(rig(), by), POINTS + by
    joint = quality.joint_of(cameras)
    said = quality.views(cameras, xyz, centroid_sd=0.1)
    apart = quality.apart_from_frame(cameras, joint, xyz, centroid_sd=0.1)
    spread = [quality.covariance_from(said, each) for each in (joint, apart)]
    alone = kinemark.predicted_covariance(cameras, xyz, centroid_sd=0.1, without=(1,))
    world = quality.world_pose(cameras, joint, xyz, centroid_sd=0.1)
    common = (world.cov, world.spread, world.at(xyz))
    return Answer(
        world.centre, rest=(spread, alone, common, said.information, said.noise, quality.visible(cameras, xyz))
    )


@law(quality.compare, quality.image_coverage, mm=1e-6, share=OPEN)
def _(by):
    other = true_rig_of_five()
    change = quality.compare(moved(other, by), moved(rig(), by), POINTS + by)
    cover = quality.image_coverage(moved(rig()[0], by), 1.01 * geometry.project(rig()[0], POINTS[::2]), POINTS + by)
    return Answer(rest=(change, cover))


def true_rig_of_five():
    return synth.ring(5, distortion=(-0.1, 0.02, 0.0, 0.0, 0.0), sweep_deg=300.0, radius=4100.0)


@law(world_frame.moved_to, l_frame.l_frame, l_frame.resting_l_frame, world_frame.fit_moved_to, mm=1e-6, share=OPEN)
def _(by):
    """A rig found in a world 10 km away is moved here, and one found here is moved there."""
    corner = np.array([[0, 0, 12.5], [800, 0, 12.5], [0, 600, 12.5]])
    arms = {"long": 800.0, "short": 600.0, "height": 12.5}
    known = l_frame.l_frame(moved(rig(), by), corner[[2, 0, 1]] + by, **arms)
    resting = l_frame.resting_l_frame(moved(rig(), by), [corner + by, corner[[2, 0, 1]] + by], **arms)
    here = world_frame.moved_to(moved(rig(), by), corner[[2, 0, 1]] + by, known)
    there = world_frame.moved_to(rig(), corner, corner + by)
    places = np.concatenate([in_the_world(there, by)[0][0], resting.seen])
    rest = (known, resting.known, in_the_world(here, 0.0), in_the_world(there, by)[1])
    return Answer(places, rest)


@law(
    world_check.odd_camera, world_check.images_of_resting, world_check.seen_within, world_check.wrong_points,
    world_frame.laid_on,
)  # fmt: skip
def _(by):
    """What is seen and the rig that sees it are 10 km away."""
    corner = np.array([[0, 0, 12.5], [800, 0, 12.5], [0, 600, 12.5], [1200, 900, 1000], [300, 1200, 700]])
    far = moved(rig(), by)
    uv = geometry.project_all(rig(), corner)
    uv[1] += [9.0, 4.0]
    seen = corner + by
    wrong = corner + np.eye(5, 3) * 40.0
    checked = world_check.wrong_points(seen, wrong + by)
    A, b, s = world_frame.laid_on(seen, corner)
    resting = world_check.images_of_resting(far, observed().detections, corner + by)
    within = world_check.seen_within(far, seen, uv)
    rest = (world_check.odd_camera(far, uv), checked, resting, within, A, seen @ A.T + b - corner, s)
    return Answer(rest=rest)


# ---- Sensitivity ----


@law(
    sensitivity.rank,
    sensitivity.gather,
    sensitivity.gather_named,
    sensitivity.rig_points,
    sensitivity.segments,
    sensitivity.segment_jacobian,
    sensitivity.shown,
    share=1e-5,
)
def _(by):
    cameras, there = moved(rig(), by), sensitivity.gather(moved(tracks(), by), observed().detections, frames=40)
    paths = (MarkerTrajectory.measured(n, xyz[:60] + by) for n, xyz in zip(walk().names, walk().xyz, strict=True))
    names = Trajectories(tuple(paths), walk().rate)
    named = sensitivity.gather_named(names, moved(tracks(), by), observed().detections, frames=40)
    pairs = sensitivity.segments(there)
    ranking = sensitivity.rank(cameras, there, method=sensitivity.ErrorBudget(frames=40))
    points = sensitivity.rig_points(cameras, there.xyz, centroid_sd=0.1)
    seen = sensitivity.shown(cameras, there.xyz[0], there.uv[0], there.time_s)
    rest = named._replace(xyz=None), pairs, sensitivity.segment_jacobian(there.xyz, pairs), ranking, points.cov, seen
    return Answer((there.xyz, named.xyz), rest)


@law(sensitivity.angle_jacobian, sensitivity.angle_spread, sensitivity.mean_spread, share=OPEN)
def _(by):
    model = kinemark.load_model("um2as")
    xyz = walk().xyz[: len(model.markers), :20]
    _, angles = joints.kinematics_of(model, model.markers)
    J = sensitivity.angle_jacobian(angles, xyz + by)
    points = sensitivity.rig_points(moved(rig(), by), xyz + by, centroid_sd=0.1)
    spread = sensitivity.angle_spread(points, J)
    weights = sensitivity.cycle_weights([0, 10, 19], 20, points=5)
    return Answer(rest=(J, spread.cov, sensitivity.mean_spread(spread, weights).cov))
