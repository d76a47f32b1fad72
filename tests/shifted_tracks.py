"""Cases of the shift law: from images to tracks."""

from dataclasses import replace

import numpy as np
from kinemark.follow import FormerTwoCameras, Simultaneous, follow_with_doubts

import kinemark
from kinemark import digitise, geometry
from kinemark.digitise import OtherViews, propose
from kinemark.match import EpipolarTriplets, KissTriplets, NearestEpipolar
from kinemark.reconstruct import CameraPairs, LeastSquares, located, wanted
from kinemark.track import (
    DistanceOnly,
    ExtrapolationLadder,
    KissTracking,
    Swamidas,
    blend,
    swamidas,
    track,
    within_volume,
    without_short,
)
from shifted import OPEN, Answer, law, moved
from shifted_scene import cloud, matches, observed, rig, tracks, walk


def first_cameras(n):
    seen = observed().detections
    return seen.select(seen.cameras[:n])


@law(kinemark.match, share=1e-8, each={"n": EpipolarTriplets(), "kiss": KissTriplets(), "nearest": NearestEpipolar()})
def _(by, parameter):
    seen = first_cameras(2) if isinstance(parameter, NearestEpipolar) else observed().detections
    return Answer(rest=kinemark.match(seen, moved(rig().select(seen.cameras), by), method=parameter))


RECONSTRUCTORS = {"squares": LeastSquares(), "spheres": LeastSquares(marker_diameter=25.0), "pairs": CameraPairs()}


@law(kinemark.reconstruct, each=RECONSTRUCTORS, mm=1e-6, share=OPEN)
def _(by, parameter):
    found = kinemark.reconstruct(matches(), observed().detections, moved(rig(), by), method=parameter)
    return Answer(found.xyz, replace(found, xyz=0 * found.xyz))


@law(located, wanted, mm=1e-6, share=OPEN)
def _(by):
    cameras = moved(rig(), by)
    guess = located(matches(), observed().detections, rig()).xyz + by
    found = located(matches(), observed().detections, cameras, guess=guess)
    return Answer(found.xyz, (found.cov, found.residual, wanted(found, cameras)))


FOLLOWERS = {"simultaneous": Simultaneous(), "former": FormerTwoCameras()}


@law(kinemark.follow, each=FOLLOWERS, mm=1e-6, share=OPEN)
def _(by, parameter):
    seen = first_cameras(2) if isinstance(parameter, FormerTwoCameras) else observed().detections
    found = kinemark.follow(seen, moved(rig().select(seen.cameras), by), method=parameter)
    return Answer(found.cloud.xyz, (found.id, found.cloud.cov, found.cloud.residual, found.cloud.view))


@law(kinemark.followed, kinemark.doubts, kinemark.noticed, kinemark.noticed_of, follow_with_doubts, mm=1e-6, share=OPEN)
def _(by):
    seen, cameras = observed().detections, moved(rig(), by)
    found = kinemark.followed(seen, cameras, Simultaneous())
    tracks, doubts = follow_with_doubts(seen, cameras)
    words = kinemark.noticed(seen, cameras, found), kinemark.noticed_of(seen, cameras, tracks)
    rest = found.id, found.evidence, found.joins, found.noise, kinemark.doubts(found, Simultaneous()), doubts, words
    return Answer((found.tracks.cloud.xyz, tracks.cloud.xyz), rest)


TRACKERS = {
    "ladder": ExtrapolationLadder(),
    "kiss": KissTracking(),
    "distance": DistanceOnly(),
    "swamidas": Swamidas(),
    "segments": Swamidas(segment_tolerance=0.05),
}


@law(track, each=TRACKERS)
def _(by, parameter):
    return Answer(rest=track(moved(cloud(), by), method=parameter).id)


@law(swamidas.follow_points, swamidas.track_swamidas, swamidas.track_distance)
def _(by):
    there = moved(cloud(), by)
    found = swamidas.follow_points(there)
    ids = swamidas.track_swamidas(there).id, swamidas.track_distance(there).id
    expected = [(frame.id, frame.half) for frame in found.expected]
    return Answer([frame.xyz for frame in found.expected], (found.by, expected, ids))


@law(swamidas.start, swamidas.predict, swamidas.update)
def _(by):
    past = walk().xyz[:5, 2::-1] + by
    state = swamidas.predict(swamidas.start(past, 0.5, 0.1), 0.1)
    state = swamidas.update(state, walk().xyz[:5, 5:2:-1] + by, np.arange(5) < 3, 0.5, 0.1)
    return Answer(state.x[:, 0], (state.x[:, 1:], state.P))


@law(blend, within_volume, without_short, kinemark.to_trajectories)
def _(by):
    there, cameras = moved(tracks(), by), moved(rig(), by)
    blended = blend(there)
    inside = within_volume(there, np.array([[300.0, 300, 300], [1500, 1000, 1500]]) + by)
    long = without_short(there, shortest=20)
    made = kinemark.to_trajectories(there, cameras)
    assert 0 < (inside.id >= 0).sum() < (there.id >= 0).sum()
    paths = [replace(path, xyz=0 * path.xyz) for path in made]
    return Answer((made.xyz, blended.cloud.xyz), (blended.id, inside.id, long.id, paths))


@law(propose, digitise.called, share=1e-7)
def _(by):
    image = np.full((1024, 1280), 10, np.uint8)
    u, v = (round(float(x)) for x in geometry.project(rig()[0], walk().xyz[2, 0]))
    image[v - 4 : v + 5, u - 4 : u + 5] = 220
    look, uv = digitise.look_at(image), geometry.project_all(rig(), walk().xyz[:, :1])
    views = OtherViews(moved(rig(), by), 0, uv)
    free, still = np.ones(len(look.uv), bool), np.zeros(2)
    method = digitise.SemiAutomatic(walk().names)
    options = {"shift": still, "expected": uv[0, 2, 0], "look": look, "free": free, "method": method}
    found = propose(views, 0, 2, **options), propose(replace(views, uv=np.where(two(uv), uv, np.nan)), 0, 2, **options)
    paths = kinemark.to_trajectories(moved(tracks(), by), moved(rig(), by))
    named = digitise.called(paths, [f"m{k}" for k in range(len(paths) + 1)], paths.n_frames)
    return Answer(named.xyz, (found, named.names))


def two(uv):
    """Of the other cameras only one."""
    return (np.arange(len(uv)) < 2)[:, None, None, None]


@law(kinemark.score)
def _(by):
    return Answer(rest=kinemark.score(moved(tracks(), by), walk().xyz[:, :60] + by))
