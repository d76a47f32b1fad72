"""The tracks through all frames (Swamidas 1997, 3.3.2, 3.4 and figures 3.9 and 3.12).

In each frame every track predicts, `constraints` say which point it takes, and the predictor goes on with that point
or, for as long as none is found, with its own prediction; so the identity outlives the gap.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ...data import Cloud, Tracks
from ...data.array_types import Bools, Floats, Ints
from ...data.progress import tell
from ..stage import CLOUD, TRACK
from .active_tracks import ActiveSwamidasTracks, advance, initiate, no_tracks, predict_points
from .angle_guide import AngleGuide, Corrected
from .constraints import Constraint, PredictedPoints, in_region, match_points
from .guided_meeting import guides_of
from .learning import LearnedParameters, stated_parameters
from .meeting import Guides, Join, Piece, joined, joins, pieces_of, without_coasting
from .own_model import own_model
from .predictions import ModelUse, PredictedFrame, SwamidasResult
from .reversal import numbered_as_they_begin, reversed_cloud, reversed_rows
from .segments import allowed_points
from .swamidas_method import DEFAULT, Swamidas

INITIATION_FRAMES = (
    3  # frames with points in which tracks begin where begin = "first": the first three measurements; chosen
)


@TRACK.method("swamidas", Swamidas, source="Swamidas 1997, 3.3 and 3.4", takes=CLOUD)
def track_swamidas(cloud: Cloud, *, method: Swamidas = DEFAULT) -> Tracks:
    """The cloud with identities, numbered in the order in which the tracks begin; within a frame, that of its points.

    Points that no constraint gives to a track, and that begin none, have no identity.
    """
    return follow_points(cloud, method=method).tracks


def follow_points(cloud: Cloud, *, method: Swamidas = DEFAULT) -> SwamidasResult:
    """As `track_swamidas`, with all predictions and the constraints that decided.

    Raises:
        KinemarkError: no model can be made of the trial itself, where it is asked for.
        ValueError: the method names a model's file that was not read.
    """
    if method.direction == "backward":
        return _backward(cloud, method)
    if method.direction == "meeting":
        return _meeting(cloud, method)
    return _forward(cloud, method)


def _backward(cloud: Cloud, method: Swamidas) -> SwamidasResult:
    """The recording reversed, followed forwards; its model is of the motion reversed."""
    model = method.model and method.model.reversed()
    found = _forward(reversed_cloud(cloud), replace(method, direction="forward", model=model))
    back = np.argsort(reversed_rows(cloud))
    identity, new = numbered_as_they_begin(found.tracks.id[back])
    expected = [frame._replace(id=new[frame.id]) for frame in found.expected[::-1]]
    return SwamidasResult(Tracks(cloud, identity), found.by[back], expected, found.model)


def _meeting(cloud: Cloud, method: Swamidas) -> SwamidasResult:
    """Pieces without a gap, joined where the predictions from both ends meet; a model guides these."""
    guides, use = None, None
    if method.angle_model is not None or method.model is not None:
        guides, use = _guides(cloud, method)
    first = _forward(cloud, without_coasting(method, cloud.rate))
    sd, process_sd = stated_parameters(cloud, method).sd, method.jerk / cloud.rate**3
    pieces = pieces_of(first.tracks, sd, process_sd)
    longest = np.inf if method.max_coasting is None else method.max_coasting * cloud.rate
    found = joins(pieces, process_sd, longest=longest, guides=guides)
    with_points = np.flatnonzero(np.diff(cloud.start))[:INITIATION_FRAMES]
    begun_by = int(with_points.max(initial=-1)) if method.initiate_from == "first" else None
    identity, _ = numbered_as_they_begin(joined(cloud, pieces, found, begun_by=begun_by))
    by = np.where(identity >= 0, first.by, int(Constraint.NONE))
    for join in found:
        by[pieces[join.next].rows[0]] = Constraint.MEETING
    return SwamidasResult(Tracks(cloud, identity), by, _expected_in_gaps(cloud, identity, pieces, found), use)


def _guides(cloud: Cloud, method: Swamidas) -> tuple[Guides, ModelUse]:
    """Both passes with the model; the trial's own is made of what meets without one."""
    method = replace(method, direction="forward")
    if method.angle_model == "own":
        alone = _meeting(cloud, replace(method, angle_model=None)).tracks
        method = replace(method, angle_model=None, model=own_model(alone, method.links))
    forward, backward = _forward(cloud, method), _backward(cloud, method)
    assert forward.model is not None and backward.model is not None
    passes = forward.model, backward.model
    recognised = any(one.recognised for one in passes)
    use = ModelUse(recognised, sum(one.missing for one in passes), sum(one.placed for one in passes))
    return guides_of(forward, backward), use


def _expected_in_gaps(cloud: Cloud, identity: Ints, pieces: list[Piece], found: list[Join]) -> list[PredictedFrame]:
    """What was predicted of the frames of gaps; there are no boxes."""
    rows: list[list[tuple[int, Floats]]] = [[] for _ in range(cloud.n_frames)]
    for join in found:
        own = int(identity[pieces[join.next].rows[0]])
        for f, xyz in enumerate(join.xyz, join.last + 1):
            rows[f].append((own, xyz))
    frames = [(np.array([i for i, _ in own], np.int64), np.array([x for _, x in own]).reshape(-1, 3)) for own in rows]
    return [PredictedFrame(id, xyz, np.full_like(xyz, np.nan), np.zeros(len(id), bool)) for id, xyz in frames]


def _forward(cloud: Cloud, method: Swamidas) -> SwamidasResult:
    """As `follow_points`, frame by frame."""
    method = _with_model(cloud, method)
    identity, by = np.full(len(cloud), -1), np.full(len(cloud), int(Constraint.NONE))
    process_sd = method.jerk / cloud.rate**3
    max_missed = np.inf if method.max_coasting is None else method.max_coasting * cloud.rate
    learning_frames = max(round(method.learning_time * cloud.rate), INITIATION_FRAMES)
    known, active, frames, with_points = stated_parameters(cloud, method), no_tracks(), [], 0
    guide = None if method.model is None else AngleGuide(method.model, method, cloud.rate, learning_frames)
    missing = placed = 0
    for f in range(cloud.n_frames):
        tell(f, cloud.n_frames)
        rows = cloud.rows(f)
        points, mine, why = cloud.xyz[rows], identity[rows], by[rows]
        expected = predict_points(active, known.error, method.velocity_share)
        allowed = _allowed(active, expected, points, known, method)
        by_model = np.zeros(len(active.id), bool)
        if guide and guide.missing(active).any():
            corrected, taken, reason = _guided(guide, active, expected, points, allowed, known)
            missing += int(guide.missing(active).sum())
            active, expected, by_model = corrected.active, corrected.expected, corrected.placed
            placed += int(by_model.sum())
        else:
            taken, reason = match_points(expected, points, allowed)
        frames.append(PredictedFrame(active.id, expected.xyz, expected.half, by_model))
        hit = taken >= 0
        mine[taken[hit]], why[taken[hit]] = active.id[hit], reason[hit]
        active = advance(active, taken, points, sd=known.sd, process_sd=process_sd)
        with_points += len(points) > 0
        if method.initiate_from == "any" or with_points <= INITIATION_FRAMES:
            active = _begun(active, mine, why, points, int(identity.max(initial=-1)) + 1)
        active = active.keep(active.missed <= max_missed)
        known.learn(mine, points, learning_frames, method)
        if guide:
            said = np.where(hit[:, None], points[taken], expected.xyz) if len(points) else expected.xyz
            guide.advance(frames[-1].id, said, mine, points)
    use = ModelUse(guide.track is not None, missing, placed) if guide else None
    return SwamidasResult(Tracks(cloud, identity), by, frames, use)


def _begun(active: ActiveSwamidasTracks, mine: Ints, why: Ints, points: Floats, first: int) -> ActiveSwamidasTracks:
    """The tracks and those that points of no track begin, numbered from `first`; noted in mine and why (n)."""
    new = np.flatnonzero(mine < 0)
    mine[new], why[new] = first + np.arange(len(new)), Constraint.BEGIN
    return initiate(active, mine[new], points[new])


def _with_model(cloud: Cloud, method: Swamidas) -> Swamidas:
    """With the model that is asked for: the trial's own is learned from the tracks that are found without one."""
    if method.angle_model is None or method.model is not None:
        return method
    if method.angle_model != "own":
        raise ValueError(f"angle_model names {method.angle_model}, which was not read; give its content as model")
    alone = replace(method, angle_model=None)
    return replace(alone, model=own_model(_forward(cloud, alone).tracks, method.links))


def _guided(
    guide: AngleGuide,
    active: ActiveSwamidasTracks,
    expected: PredictedPoints,
    points: Floats,
    allowed: Bools,
    known: LearnedParameters,
) -> tuple[Corrected, Ints, Ints]:
    """Tracks and what they expect, corrected, and the point and constraint (T) of each: markers that are visible first,
    then those that the model has placed as seen from these, and last those that it cannot place."""
    visible = ~guide.missing(active)
    taken, by = np.full(len(visible), -1), np.full(len(visible), int(Constraint.NONE))
    taken[visible], by[visible] = match_points(expected.keep(visible), points, allowed[visible])
    observed = np.full_like(expected.xyz, np.nan)
    observed[taken >= 0] = points[taken[taken >= 0]]
    corrected = guide.correct(active, expected, observed, known.error, known.sd)
    for own, chosen in ((corrected.placed, guide.match), (~visible & ~corrected.placed, None)):
        left = np.setdiff1d(np.arange(len(points)), taken)
        if not own.any() or not len(left):
            continue
        if chosen:
            inside = in_region(corrected.expected, points[left]) & allowed[:, left]
            found = chosen(corrected, points[left], inside)[own]
            why = np.full(len(found), int(Constraint.MODEL))
        else:
            found, why = match_points(corrected.expected.keep(own), points[left], allowed[np.ix_(own, left)])
        taken[own], by[own] = np.where(found >= 0, left[found], -1), np.where(found >= 0, why, 0)
    return corrected, taken, by


def _allowed(
    active: ActiveSwamidasTracks, expected: PredictedPoints, points: Floats, known: LearnedParameters, method: Swamidas
) -> NDArray[np.bool_]:
    """(T, N) pairs that the segments do not forbid; before they are learned, all."""
    if not (method.segment_tolerance and len(known.segments.link)):
        return np.ones((len(active.id), len(points)), bool)
    place = np.full(max(int(known.segments.link.max()), int(active.id.max(initial=0))) + 1, -1)
    place[active.id] = np.arange(len(active.id))
    here = known.segments._replace(link=place[known.segments.link])
    sure = active.going & (active.missed == 0) & (active.seen == 3)
    return allowed_points(points, expected.xyz, sure, here, method.segment_tolerance)
