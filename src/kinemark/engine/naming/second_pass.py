"""The second pass over the tracks of a trial, once its markers have names: the tracker profits from the body.

Points are judged by where the others say that each marker is (`label.by_body`): those that changed places change back,
pieces without a name join their marker, and a point far off is put aside where the marker's own images are found.
Markers that have no point in a frame are looked for where the body expects them (`label.carried_places`), in the images
that nobody has (`track.simultaneous.points.expected_places`). Each goes on from what the other found. At last, tracks
without a name that are beside a named marker all along are its twins, made of others of its images, and no tracks any
more.

Nothing is lost: points put aside stay in the cloud without a track, and what became of how many is a finding.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
import scipy

from ...data import Cloud, Detections, Finding, Rig, Tracks, make_finding
from ...data.array_types import Bools, Floats, Ints
from ...geometry.weighted_points import DEFAULT_ERRORS, ImageErrors
from ...label.body_places import Figure, places_by
from ...label.body_places import figures as figures_of
from ...label.by_body import ASIDE_POINT, NamedPoints, judged
from ...label.carried_places import carried_places
from ...numerics.runs import equal_runs
from ...track.simultaneous import Simultaneous
from ...track.simultaneous.points.expected_places import Looked, points_where_expected, searched
from ...track.simultaneous.points.neighbouring_points import TrackPoints
from ...track.simultaneous.simultaneous_tracking import VOLUME_MARGIN
from .named_tracks import NamedTracks
from .naming import ghost_tracks, renumbered, tracker_names
from .templates import SessionTemplate, prefix_of

ROUNDS = 4
"""Of judging and looking, at most; chosen: most trials need two."""
FEWEST = 4
"""Named markers, below which there is no body; by definition: three others foretell a place."""
TWIN_MM = 6.0
"""mm from a named marker within which a track is its twin; chosen: the smallest markers in use are wider, and twins of
merged images lie 4 to 5 mm apart."""
TWIN_SHARE = 0.8
"""Of a track's points, at least, that lie so; chosen."""


class Search(NamedTuple):
    """What the tracker has of a trial: detections and rig, its method, errors and the volume's margin, mm or None."""

    detections: Detections
    rig: Rig
    method: Simultaneous
    errors: ImageErrors = DEFAULT_ERRORS
    volume_margin: float | None = VOLUME_MARGIN


class _Points(NamedTuple):
    """All P points: their cloud; marker, −1 for a track without a name, ASIDE_POINT for none; track and row that each
    was of, −1 for points found; whether a person said what it is."""

    cloud: Cloud
    marker: Ints
    track: Ints
    row: Ints
    fixed: Bools

    def places(self, M: int) -> Floats:
        """(M, F, 3) mm of the markers, NaN where they have no point."""
        out = np.full((M, self.cloud.n_frames, 3), np.nan)
        own = self.marker >= 0
        out[self.marker[own], self.cloud.frame[own]] = self.cloud.xyz[own]
        return out


def second_pass(
    found: NamedTracks,
    tracks: Tracks,
    by: Mapping[str, SessionTemplate],
    search: Search,
    *,
    fixed: Bools | None = None,
) -> NamedTracks:
    """Named tracks judged by the body, and markers looked for where it expects them.

    Args:
        found: by `name_tracks`, of the tracks and by the templates of subjects that are given.
        fixed: (P) points of which a person said what they are; they stay as they are.
    """
    M = sum(not name.startswith("*") for name in found.names)
    if M < FEWEST or not by:
        return found
    P, id = len(found.tracks.cloud), found.tracks.id
    marker = np.select([id < 0, id < M], [ASIDE_POINT, id], -1)
    fixed = np.zeros(P, bool) if fixed is None else fixed
    points = _Points(found.tracks.cloud, marker, id, np.arange(P), fixed)
    for _ in range(ROUNDS):
        body = _figures(points, found.names[:M], by)
        again = _found(_judged(points, body, M), points.marker, body, M, search)
        same = len(again.row) == len(points.row) and (again.marker == points.marker).all()
        points = again
        if same:
            break
    return _renamed(found, tracks, points, M)


def _figures(points: _Points, names: tuple[str, ...], by: Mapping[str, SessionTemplate]) -> list[Figure]:
    """Those of the markers of all subjects."""
    xyz, out = points.places(len(names)), []
    for subject, one in by.items():
        labels = {prefix_of(subject) + name: a for a, name in enumerate(one.template.names)}
        own = np.array([m for m, name in enumerate(names) if name in labels], np.int64)
        index = np.array([labels[names[m]] for m in own.tolist()], np.int64)
        for figure in figures_of(xyz[own], index, one.template, points.cloud.rate) if len(own) else ():
            out.append(figure._replace(marker=int(own[figure.marker]), near=own[figure.near]))
    return out


def _judged(points: _Points, body: list[Figure], M: int) -> _Points:
    """The points as the body says they are."""
    cloud = points.cloud
    said = NamedPoints(cloud.frame, points.track, points.marker, cloud.xyz, cloud.cov, points.fixed)
    return points._replace(marker=judged(said, places_by(body, points.places(M))))


def _found(points: _Points, before: Ints, body: list[Figure], M: int, search: Search) -> _Points:
    """With the points that are found; those that were put aside for nothing are again what they were `before` (P)."""
    cloud, marker = points.cloud, points.marker
    own = marker >= 0
    empty = np.ones((M, cloud.n_frames), bool)
    empty[marker[own], cloud.frame[own]] = False
    expected = carried_places(body, points.places(M), empty, cloud.rate)
    named = Tracks(cloud, np.where(own, marker, -1))
    at = searched(search.detections, search.rig, named, own | (marker == -1), method=search.method)
    known = TrackPoints(cloud.frame[own], marker[own], cloud.xyz[own], cloud.cov[own])
    where = TrackPoints(expected.frame, expected.marker, expected.xyz, expected.cov)
    new = points_where_expected(at, known, where, errors=search.errors, volume_margin=search.volume_margin)
    empty[new.id, new.cloud.frame] = False
    back = (marker == ASIDE_POINT) & (before >= 0)
    back[back] = empty[before[back], cloud.frame[back]]
    return _with(points._replace(marker=np.where(back, before, marker)), new)


def _with(points: _Points, new: Looked) -> _Points:
    """The points and those that were found, by frame."""
    frame = np.concatenate([points.cloud.frame, new.cloud.frame])
    order = np.argsort(frame, kind="stable")
    start = np.searchsorted(frame[order], np.arange(points.cloud.n_frames + 1))
    names = ("xyz", "cov", "residual", "detection")
    columns = (np.concatenate([getattr(points.cloud, name), getattr(new.cloud, name)])[order] for name in names)
    n = len(new.id)
    added = new.id, new.id, np.full(n, -1), np.zeros(n, bool)
    rest = (np.concatenate(pair)[order] for pair in zip(points[1:], added, strict=True))
    return _Points(Cloud(points.cloud.rate, start, *columns), *rest)


def _renamed(found: NamedTracks, tracks: Tracks, points: _Points, M: int) -> NamedTracks:
    """The record of the points as they are now."""
    identity = np.where(points.marker == -1, points.track, np.maximum(points.marker, -1))
    rest, number = np.unique(identity[identity >= M], return_inverse=True)
    identity[identity >= M] = M + number
    named = Tracks(points.cloud, identity)
    ghosts = ghost_tracks(named, identity, M) | twins(named, M)
    kept = np.array([k for k in range(M + len(rest)) if k < M or k not in ghosts], np.int64)
    place = np.full(M + len(rest) + 1, -1)  # the last one is that of −1
    place[kept] = np.arange(len(kept))
    named = Tracks(points.cloud, place[identity])
    names = renumbered([*found.names[:M], *["*"] * (len(kept) - M)])
    old = points.row >= 0
    before = np.empty(int(old.sum()), np.int64)
    before[points.row[old]] = named.id[old]
    counts, finding = _changes(found, points, M, len(ghosts))
    samples = np.bincount(named.id[named.id >= 0], minlength=len(names))
    markers = [
        {**one, "samples": int(samples[names.index(one["name"])])} if one["name"] in names[:M] else one
        for one in found.figures["markers"]
    ]
    return found._replace(
        tracks=named, names=names, tracker_names=tracker_names(tracks, before, names),
        figures={**found.figures, "markers": markers, "second_pass": counts}, findings=(*found.findings, *finding),
    )  # fmt: skip


def twins(tracks: Tracks, M: int) -> frozenset[int]:
    """The tracks from M on most of whose points lie within TWIN_MM of a point of those before, the named ones."""
    cloud, own = tracks.cloud, (tracks.id >= 0) & (tracks.id < M)
    rest = np.flatnonzero(tracks.id >= M)
    if not len(rest) or not own.any():
        return frozenset()
    apart = 10 * TWIN_MM  # mm a frame, so that points of other frames are far
    columns = np.column_stack([cloud.xyz - cloud.xyz[0], apart * cloud.frame])
    near = scipy.spatial.cKDTree(columns[own]).query(columns[rest], distance_upper_bound=TWIN_MM)[0] < TWIN_MM
    count = np.bincount(tracks.id[rest])
    share = np.bincount(tracks.id[rest], near, len(count)) / np.maximum(count, 1)
    return frozenset(np.flatnonzero((count > 0) & (share >= TWIN_SHARE)).tolist())


def _changes(found: NamedTracks, points: _Points, M: int, ghosts: int) -> tuple[dict[str, Any], tuple[Finding, ...]]:
    """How many points changed, and the finding that says so; none where nothing did."""
    old = points.row >= 0
    was, now = np.full(len(old), -1), points.marker
    was[old] = found.tracks.id[points.row[old]]
    had = old & (was >= 0) & (was < M)
    kinds = {
        "found": ~old,
        "renamed": had & (now >= 0) & (now != was),
        "joined": old & (was >= M) & (now >= 0),
        "put_aside": had & (now < 0),
    }
    counts: dict[str, Any] = {name: int(which.sum()) for name, which in kinds.items()} | {"ghosts": ghosts}
    changed = np.flatnonzero(kinds["found"] | kinds["renamed"] | kinds["joined"] | kinds["put_aside"])
    if not any(counts.values()):
        return counts, ()
    about = np.where(now[changed] >= 0, now[changed], was[changed])
    markers = [found.names[m] for m in np.unique(about).tolist()]
    return counts, (make_finding("second_pass_by_body", markers=markers, frames=_runs(points, changed), **counts),)


def _runs(points: _Points, rows: Ints) -> list[tuple[int, int]]:
    """First and last of the runs of frames of some points."""
    frame = np.unique(points.cloud.frame[rows])
    cuts = equal_runs(frame - np.arange(len(frame))) if len(frame) else np.zeros(1, np.int64)
    return [(int(frame[a]), int(frame[b - 1])) for a, b in pairwise(cuts.tolist())]
