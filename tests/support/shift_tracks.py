"""Cases of the shift law: from images to tracks."""

from dataclasses import replace

import numpy as np

import kinemark
from kinemark import digitise, geometry, match, reconstruct
from kinemark.data import MarkerSet
from kinemark.digitise import OtherViews, propose
from kinemark.geometry.weighted_points import usable_points, weighted_points
from kinemark.label import (
    computed_points,
    find_exchanges,
    find_mislabelled,
    find_side_swaps,
    label,
    label_by_location,
    label_subjects,
    label_switching,
    learn_marker_set,
    learn_template,
    named,
    sides_by_name,
    static_template,
)
from kinemark.label.own_exchanges import find_own_exchanges
from kinemark.match import MATCH, NearestEpipolar
from kinemark.reconstruct import RECONSTRUCT, LeastSquares
from kinemark.track import TRACK, Swamidas, blend, swamidas, track, within_volume, without_short
from kinemark.track.simultaneous import FormerTwoCameras, Simultaneous, diagnose_points, track_with_decisions
from support.computed import walker, with_computed
from support.shift_law import OPEN, Answer, law, moved
from support.shift_scene import cloud, matches, observed, rig, tracks, trial, walk


def first_cameras(n):
    seen = observed().detections
    return seen.select(seen.cameras[:n])


@law(match.start_offsets, share=1e-8)
def _(by):
    seen = observed().detections
    return Answer(rest=match.start_offsets(seen, moved(rig(), by), most=10))


@law(match.match, share=1e-8, each={name: declared.kind() for name, declared in MATCH.items()})
def _(by, parameter):
    seen = first_cameras(2) if isinstance(parameter, NearestEpipolar) else observed().detections
    return Answer(rest=match.match(seen, moved(rig().select(seen.cameras), by), method=parameter))


RECONSTRUCTORS = {name: declared.kind() for name, declared in RECONSTRUCT.items()}
RECONSTRUCTORS["spheres"] = LeastSquares(marker_diameter=25.0)


@law(reconstruct.reconstruct, each=RECONSTRUCTORS, mm=1e-6, share=OPEN)
def _(by, parameter):
    found = reconstruct.reconstruct(matches(), observed().detections, moved(rig(), by), method=parameter)
    return Answer(found.xyz, replace(found, xyz=0 * found.xyz))


@law(weighted_points, usable_points, mm=1e-6, share=OPEN)
def _(by):
    cameras = moved(rig(), by)
    guess = weighted_points(matches(), observed().detections, rig()).xyz + by
    found = weighted_points(matches(), observed().detections, cameras, guess=guess)
    return Answer(found.xyz, (found.cov, found.residual, usable_points(found, cameras)))


OF_DETECTIONS = {"simultaneous": Simultaneous(), "former_two_cameras": FormerTwoCameras()}


@law(kinemark.track_detections, each=OF_DETECTIONS, mm=1e-6, share=OPEN)
def _(by, parameter):
    seen = first_cameras(2) if isinstance(parameter, FormerTwoCameras) else observed().detections
    found = kinemark.track_detections(seen, moved(rig().select(seen.cameras), by), method=parameter)
    return Answer(found.cloud.xyz, (found.id, found.cloud.cov, found.cloud.residual, found.cloud.detection))


@law(
    kinemark.track_simultaneously,
    kinemark.ambiguous_decisions,
    kinemark.diagnose,
    kinemark.diagnose_tracks,
    diagnose_points,
    track_with_decisions,
    mm=1e-6,
    share=OPEN,
)
def _(by):
    seen, cameras = observed().detections, moved(rig(), by)
    found = kinemark.track_simultaneously(seen, cameras, Simultaneous())
    tracks, decisions = track_with_decisions(seen, cameras)
    words = kinemark.diagnose(seen, cameras, found), kinemark.diagnose_tracks(seen, cameras, tracks)
    words = *words, diagnose_points(found, Simultaneous(), None)
    again = kinemark.ambiguous_decisions(found, Simultaneous())
    rest = found.id, found.evidence, found.stitches, found.noise, decisions, again, words
    return Answer((found.tracks.cloud.xyz, tracks.cloud.xyz), rest)


TRACKERS = {name: declared.kind() for name, declared in TRACK.items() if name not in OF_DETECTIONS}
TRACKERS["segments"] = Swamidas(segment_tolerance=0.05)


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


@law(swamidas.initial_state, swamidas.predict, swamidas.update)
def _(by):
    past = walk().xyz[:5, 2::-1] + by
    state = swamidas.predict(swamidas.initial_state(past, 0.5, 0.1), 0.1)
    state = swamidas.update(state, walk().xyz[:5, 5:2:-1] + by, np.arange(5) < 3, 0.5, 0.1)
    return Answer(state.x[:, 0], (state.x[:, 1:], state.P))


@law(blend, within_volume, without_short, kinemark.to_trajectories)
def _(by):
    there, cameras = moved(tracks(), by), moved(rig(), by)
    blended = blend(there)
    inside = within_volume(there, np.array([[300.0, 300, 300], [1500, 1000, 1500]]) + by)
    long = without_short(there, min_points=20)
    made = kinemark.to_trajectories(there, cameras)
    assert 0 < (inside.id >= 0).sum() < (there.id >= 0).sum()
    paths = [replace(path, xyz=0 * path.xyz) for path in made]
    return Answer((made.xyz, blended.cloud.xyz), (blended.id, inside.id, long.id, paths))


@law(propose, digitise.called, share=1e-7)
def _(by):
    image = np.full((1024, 1280), 10, np.uint8)
    u, v = (round(float(x)) for x in geometry.project(rig()[0], walk().xyz[2, 0]))
    image[v - 4 : v + 5, u - 4 : u + 5] = 220
    markers, uv = digitise.find_markers(image), geometry.project_all(rig(), walk().xyz[:, :1])
    views = OtherViews(moved(rig(), by), 0, uv)
    free, still = np.ones(len(markers.uv), bool), np.zeros(2)
    method = digitise.SemiAutomatic(walk().names)
    options = {"shift": still, "expected": uv[0, 2, 0], "image_markers": markers, "free": free, "method": method}
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


@law(learn_template, label, label_switching, label_subjects, named, find_exchanges, share=1e-6)
def _(by):
    """Places are float32 about one of the points."""
    learnt, seen = learn_template(moved(trial(gaps=False), by)), moved(trial(), by)
    found = label(seen, learnt)
    first, second = seen.paths[:2]
    turned = replace(first, name=second.name), replace(second, name=first.name), *seen.paths[2:]
    cut = label_switching(seen, learnt)
    whose = label_subjects(seen, {"A": learnt}).labels
    rest = learnt, found, cut.labels, cut.switches, whose, find_exchanges(replace(seen, paths=turned), learnt)
    return Answer(named(seen, found).xyz, rest)


@law(computed_points)
def _(by):
    return Answer(rest=computed_points(moved(with_computed(walker(duration_s=1.0)), by)))


@law(find_own_exchanges)
def _(by):
    """Two names are exchanged in the second half."""
    whole = moved(trial(gaps=False), by)
    half, (first, second, *rest) = whole.n_frames // 2, whole.paths
    xyz = np.concatenate([first.xyz[:half], second.xyz[half:]]), np.concatenate([second.xyz[:half], first.xyz[half:]])
    turned = replace(whole, paths=(replace(first, xyz=xyz[0]), replace(second, xyz=xyz[1]), *rest))
    return Answer(rest=(find_own_exchanges(whole), find_own_exchanges(turned)))


@law(label_by_location, share=1e-6)
def _(by):
    """The vertical and the way of the subject alone are read."""
    shown = moved(trial(gaps=False), by)
    return Answer(rest=[tuple(one) for one in label_by_location(moved(trial(), by), shown)])


@law(learn_marker_set, static_template, find_side_swaps, find_mislabelled, share=1e-6)
def _(by):
    """Left and right of all markers but one swapped; that one is moved by half a metre."""
    whole = moved(trial(gaps=False), by)
    learnt, names = learn_template(whole), whole.names
    sides = sides_by_name(names)
    other = {a: b for pair in sides for a, b in (pair, pair[::-1])}
    turned = replace(whole, paths=tuple(replace(path, name=other.get(path.name, path.name)) for path in whole))
    off = replace(
        whole, paths=(replace(whole.paths[0], xyz=whole.paths[0].xyz + np.array([500.0, 0, 0])), *whole.paths[1:])
    )
    worn = MarkerSet(names, {"all": names})
    swaps, wrong = find_side_swaps(turned, learnt, sides), find_mislabelled(off, learnt)
    return Answer(rest=(learn_marker_set(whole), static_template(whole, worn), swaps, wrong))
