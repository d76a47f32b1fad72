"""The second pass over the tracks of a trial, once its markers have names: the tracker profits from the body.

Points are judged by where the body says that each marker is (`label.by_body`), and markers that have none are looked
for there in the images that nobody has (`track.simultaneous.expected_places`). Both go on from what the other found.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from ...data import Cloud, Detections, Rig, Tracks
from ...data.array_types import Bools, Ints
from ...geometry.weighted_points import DEFAULT_ERRORS, ImageErrors
from ...label import Template
from ...label.body_places import figures as figures_of
from ...label.body_places import places_by
from ...label.carried_places import carried_places
from ...label.by_body import ASIDE_POINT, NamedPoints, judged
from ...track.simultaneous import Simultaneous
from ...track.simultaneous.expected_places import points_where_expected, searched
from ...track.simultaneous.learned_delays import VOLUME_MARGIN
from ...track.simultaneous.neighbouring_points import TrackPoints
from .naming import ghost_tracks

ROUNDS = 4
"""Of judging and looking; chosen: the third finds hardly anything new."""


class Again(NamedTuple):
    """Tracks after the second pass.

    Attributes:
        tracks: the first are those of the named markers, in their order; points put aside are of none.
        row: (P) of each point, its row before, −1 of those that were found.
        figures: points renamed, joined (of tracks without a name), put aside and found.
    """

    tracks: Tracks
    row: Ints
    figures: Mapping[str, Any]


def second_pass(
    tracks: Tracks,
    names: tuple[str, ...],
    template: Template,
    detections: Detections,
    rig: Rig,
    *,
    fixed: Bools | None = None,
    method: Simultaneous,
    errors: ImageErrors = DEFAULT_ERRORS,
    volume_margin: float | None = VOLUME_MARGIN,
) -> Again:
    """Tracks of markers (N) judged by the body, and looked for where it expects them.

    Args:
        tracks: joined to markers. names: of them; those of none begin with "*". template: of the subject.
        fixed: (P) points of which a person said what they are.
    """
    M = sum(name in template.names for name in names)
    if M < 4:
        return Again(tracks, np.arange(len(tracks.cloud)), {})
    index = np.array([template.names.index(name) for name in names[:M]], np.int64)
    cloud, row = tracks.cloud, np.arange(len(tracks.cloud))
    marker = np.where((tracks.id >= 0) & (tracks.id < M), tracks.id, -1)
    before, found = marker, 0
    track = tracks.id
    fixed = np.zeros(len(row), bool) if fixed is None else fixed
    for _ in range(ROUNDS):
        xyz = _places(cloud, marker, M)
        body = places_by(known := figures_of(xyz, index, template, cloud.rate), xyz)
        named = np.where(track >= 0, marker, ASIDE_POINT)
        was = named
        marker = judged(NamedPoints(cloud.frame, track, named, cloud.xyz, cloud.cov, fixed), body)
        held = (marker >= 0) | ((marker == -1) & (track >= 0))
        xyz = _places(cloud, marker, M)
        at = searched(detections, rig, Tracks(cloud, np.where(marker >= 0, marker, -1)), held, method=method)
        expected = carried_places(known, xyz, _empty(cloud, marker, M), cloud.rate)
        places = TrackPoints(expected.frame, expected.marker, expected.xyz, expected.cov)
        new = points_where_expected(at, _known(cloud, marker), places, errors=errors, volume_margin=volume_margin)
        found += len(new.id)
        taken = _empty(cloud, marker, M)
        taken[new.id, new.cloud.frame] = False
        back = (marker == ASIDE_POINT) & (was >= 0)
        back[back] = taken[was[back], cloud.frame[back]]
        marker = np.where(back, was, marker)
        cloud, order = _with(cloud, new.cloud)
        nothing = np.full(len(new.id), -1)
        row = np.concatenate([row, nothing])[order]
        marker = np.concatenate([marker, new.id])[order]
        track = np.concatenate([track, new.id])[order]
        fixed = np.concatenate([fixed, nothing == 0])[order]
        if not len(new.id):
            break
    old = row >= 0
    was, now = before[row[old]], marker[old]
    figures = {
        "renamed": int(((was >= 0) & (now >= 0) & (was != now)).sum()),
        "joined": int(((was < 0) & (now >= 0)).sum()),
        "put_aside": int(((was >= 0) & (now < 0)).sum()),
        "found": int(found),
    }
    identity = np.where(marker >= 0, marker, np.where((marker == -1), track, -1))
    return Again(Tracks(cloud, _dense(identity, M)), row, figures)


def _dense(identity: Ints, M: int) -> Ints:
    """Identities without holes above M."""
    rest = np.unique(identity[identity >= M])
    return np.where(identity >= M, M + np.searchsorted(rest, identity), identity)


def _places(cloud: Cloud, marker: Ints, M: int):
    xyz = np.full((M, cloud.n_frames, 3), np.nan)
    own = (marker >= 0)
    xyz[marker[own], cloud.frame[own]] = cloud.xyz[own]
    return xyz


def _empty(cloud: Cloud, marker: Ints, M: int):
    out = np.ones((M, cloud.n_frames), bool)
    own = marker >= 0
    out[marker[own], cloud.frame[own]] = False
    return out


def _known(cloud: Cloud, marker: Ints) -> TrackPoints:
    own = marker >= 0
    return TrackPoints(cloud.frame[own], marker[own], cloud.xyz[own], cloud.cov[own])


def _with(cloud: Cloud, new: Cloud):
    frame = np.concatenate([cloud.frame, new.frame])
    order = np.argsort(frame, kind="stable")
    start = np.searchsorted(frame[order], np.arange(cloud.n_frames + 1))
    names = ("xyz", "cov", "residual", "detection")
    columns = (np.concatenate([getattr(cloud, name), getattr(new, name)])[order] for name in names)
    return Cloud(cloud.rate, start, *columns), order
