"""Cases of the shift law: filling, kinematics, signals."""

from dataclasses import replace

import numpy as np

import kinemark
from kinemark import geometry, kinematics, signal
from kinemark.data import MarkerTrajectory, Trajectories
from kinemark.fill import (
    FILL,
    Filling,
    LimbAngles,
    MarkerArray,
    Rays,
    StaticShape,
    fill,
    fill_recording,
    find_gaps,
    fit_model,
    place_absent,
    trim_edges,
    usual_limit,
)
from kinemark.fill.methods import angles
from kinemark.kinematics import Butterworth, WoltringSpline
from kinemark.signal.filters import butterworth, residual_analysis
from kinemark.signal.kalman import initial_state, predict, update_position
from kinemark.signal.smoother import smooth_positions
from kinemark.signal.woltring import woltring
from support.shift_law import Answer, law, moved, on_grid
from support.shift_scene import found_gaps, motion, observed, rig, tracks, trial, walk


def jumps(gaps, by):
    """The jumps of gaps as places so far from the origin, since the rounding of places is theirs; the gaps without."""
    places = np.array([[gap.jump_mm] * 3 for gap in gaps]).reshape(-1, 3) + by
    return places, [replace(gap, jump_mm=0.0) for gap in gaps]


@law(fill, each=FILL, mm=1e-6, share=1e-7)
def _(by, parameter):
    filled, gaps = fill(moved(trial(), by), method=parameter.kind(), ends=True, limit_mm=np.inf)
    places, gaps = jumps(gaps, by)
    return Answer((filled.xyz, places), ([p.cov for p in filled], [p.origin for p in filled], gaps))


@law(trim_edges)
def _(by):
    found = trim_edges(moved(motion(), by), found_gaps())
    return Answer(found.motion.xyz, (found.gaps, found.before, found.after))


@law(usual_limit)
def _(by):
    return Answer(rest=[usual_limit(0.1 * moved(motion(), 10 * by).xyz)])


@law(find_gaps)
def _(by):
    return Answer(rest=find_gaps(moved(motion(), by), ends=True))


@law(place_absent, mm=1e-6, share=1e-7)
def _(by):
    xyz = motion().xyz.copy()
    xyz[3] = np.nan
    static = StaticShape.of(MarkerArray(motion(False).xyz[:, :20] + by, 50.0, motion().names))
    placed = place_absent(MarkerArray(xyz + by, 50.0, motion().names), static)
    return Answer(([p.xyz for p in placed], static.xyz), ([p._replace(xyz=None) for p in placed], static.sd))


@law(fill_recording, mm=1e-6, share=1e-7)
def _(by):
    rays = Rays.left_by(moved(tracks(), by), observed().detections, moved(rig(), by))
    paths = tuple(MarkerTrajectory.measured(p.name, p.xyz[:60], cov=p.cov[:60]) for p in trial())
    short = replace(trial(), paths=paths)
    filled, gaps = fill_recording(moved(short, by), rays, method=Filling(limit_mm=1e9))
    places, gaps = jumps(gaps, by)
    return Answer((filled.xyz, places), ([p.cov for p in filled], [p.cameras for p in filled], gaps))


@law(fit_model, angles.connect, angles.directions, angles.learn_model, angles.learned_of, share=1e-7)
def _(by):
    xyz, names = motion().xyz + by, motion().names
    segments = angles.connect(xyz, names=names)
    model = angles.learn_model(xyz, rate=50.0, names=names, segments=segments)
    fitted = fit_model(moved(motion(), by))
    learned = angles.learned_of(moved(motion(), by), method=LimbAngles())
    return Answer(rest=(segments, angles.directions(xyz, segments.link), model, fitted.model, fitted.phase, learned))


@law(angles.fill_limb_angles, angles.fill_kalman_angles, mm=1e-6, share=1e-7)
def _(by):
    said = [f(moved(motion(), by), found_gaps()) for f in (angles.fill_limb_angles, angles.fill_kalman_angles)]
    return Answer([p.xyz for each in said for p in each], [p._replace(xyz=None) for each in said for p in each])


def bodies(model):
    """Every point that a shipped model asks for, each on its own sway."""
    rng = np.random.default_rng(len(model.name))
    names = list(dict.fromkeys([*model.markers, *(m for c in model.clusters for m in (*c.markers, *c.points))]))
    time = np.linspace(0, 2, 80)
    base = on_grid(np.array([500.0, 400.0, 900.0]) + rng.uniform(-300, 300, (len(names), 1, 3)))
    sway = on_grid(
        rng.uniform(20, 60, (len(names), 1, 3)) * np.sin(3 * time[:, None] + rng.uniform(0, 6, (len(names), 1, 1)))
    )
    return names, base + sway


def paths(names, xyz, sd=1.0):
    cov = np.broadcast_to(sd**2 * np.eye(3), (xyz.shape[1], 3, 3))
    made = (MarkerTrajectory.measured(name, at, cov=cov) for name, at in zip(names, xyz, strict=True))
    return Trajectories(tuple(made), 50.0)


@law(
    kinematics.joint_angles,
    kinematics.joint_matrices,
    kinematics.segment_axes,
    kinematics.static_template,
    each={name: name for name in ("isb_shoulder", "isb_upper_limb", "um2as")},
    mm=1e-6,
    share=1e-7,
)
def _(by, parameter):
    model = kinemark.load_model(parameter)
    names, xyz = bodies(model)
    there = moved(paths(names, xyz), by)
    template = kinematics.static_template(moved(paths(names, xyz[:, :1]), by), model) if model.clusters else None
    found = kinemark.joint_angles(there, model=model, template=template)
    points = {path.name: path.xyz for path in there}
    if template is not None:
        return Answer(rest=(found.deg, found.cov, template))
    axes = kinematics.segment_axes(points, model, template), kinematics.joint_matrices(points, model, template)
    return Answer(rest=(found.deg, found.cov, axes))


@law(
    kinematics.body_pose,
    kinematics.rotation_covariance,
    kinematics.angular_velocity,
    kinematics.joint_centre,
    share=1e-8,
)
def _(by):
    rng, shape = np.random.default_rng(0), on_grid(np.random.default_rng(1).normal(0, 60, (4, 3)))
    R = geometry.nearest_rotations(np.eye(3) + rng.normal(0, 0.5, (30, 3, 3)))
    xyz = on_grid(np.einsum("fij,kj->kfi", R, shape) + rng.normal(0, 0.2, (4, 30, 3)) + [300, 200, 900])
    xyz[3, 4] = np.nan
    pose = kinematics.body_pose(shape, xyz + by)
    still = kinematics.body_pose(shape, np.broadcast_to(shape[:, None] + [300, 200, 900.0], xyz.shape) + by)
    spread = kinematics.rotation_covariance(shape, pose, 0.2), kinematics.angular_velocity(pose.R, rate=50.0)
    return Answer(pose.t, (pose._replace(t=None), spread, kinematics.joint_centre(pose, still)))


@law(kinematics.helical_axis, kinematics.helical_axes, kinematics.knee_motion, mm=1e-4, share=1e-6)
def _(by):
    turns = np.linspace(0, 40, 12)[:, None] * [1.0, 0.4, -0.2]
    R, t = kinematics.turned(turns, "xyz"), np.linspace(0, 300, 12)[:, None] * [1.0, 0.5, 0.2] + by
    one = kinematics.helical_axis(R[:6], t[:6], R[6:], t[6:])
    many = kinematics.helical_axes(R, t, step=2, near=by + np.array([100.0, 50.0, 0.0]))
    knee = kinematics.knee_motion(R, t, R[::-1], t[::-1], side="left")
    return Answer((one.point, many.point), (one._replace(point=None), many._replace(point=None), knee))


@law(
    kinematics.smooth,
    kinematics.residual_cutoff,
    kinematics.estimated_sd,
    kinematics.with_marker_sd,
    mm=1e-6,
    share=1e-8,
)
def _(by):
    there = moved(replace(trial(), paths=trial().paths[:3]), by)
    methods = (Butterworth(), Butterworth(cutoff_hz=6.0), WoltringSpline(), WoltringSpline(cutoff_hz=6.0))
    smoothed = [kinematics.smooth(there, method=method) for method in methods]
    cutoff = [kinematics.residual_cutoff(path, rate=50.0) for path in there]
    bare = replace(there, paths=tuple(MarkerTrajectory.measured(path.name, path.xyz) for path in there))
    sd = kinematics.with_marker_sd(bare)
    return Answer(
        [s.xyz for s in smoothed],
        ([p.cov for s in smoothed for p in s], cutoff, [p.cov for p in sd], kinematics.estimated_sd(there.xyz[0])),
    )


@law(kinematics.marker_derivatives, mm=1e-6, share=1e-6)
def _(by):
    there = moved(replace(trial(), paths=trial().paths[:2]), by)
    found = kinematics.marker_derivatives(there)
    return Answer(
        None,
        (found.velocity, found.velocity_sd, found.acceleration, found.acceleration_sd, found.noise_sd),
    )


# ---- Signals ----


@law(woltring, butterworth, residual_analysis, smooth_positions, initial_state, predict, update_position)
def _(by):
    y, ones = walk().xyz[3] + by, np.ones(3)
    y[40:45] = np.nan
    spline, free, part = woltring(y, cutoff=0.1), woltring(y), y[:40]
    filtered = butterworth(part, rate=50.0, cutoff_hz=6.0)
    smoothed = smooth_positions(y.T, sd=0.5 * ones, process_sd=0.1 * ones)
    state = predict(initial_state(part[None, 2::-1], 0.5, 0.1), 0.1)
    at, state = update_position(state, part[None, 4], ones[:1], 0.1)
    rest = (
        free.cutoff,
        residual_analysis(part, rate=50.0),
        smoothed.x[..., 1:],
        smoothed.P,
        state.x[:, 1:],
    )
    places = spline.values, free.values, filtered, smoothed.x[..., 0].T, at, state.x[:, 0]
    return Answer(places, rest)


@law(signal.extrapolate, signal.smoothing_spline, mm=1e-6, share=1e-8)
def _(by):
    y = walk().xyz[3, :40] + by
    t = np.arange(40.0)
    spline = signal.smoothing_spline(t, y, t + 0.5)
    fixed = signal.smoothing_spline(t, y, t + 0.5, smoothing=1.0)
    ahead = signal.extrapolate(y[None, -5:], np.array([5]))
    return Answer((spline.values, fixed.values, ahead), (spline.variance, fixed.variance, spline.smoothing))
