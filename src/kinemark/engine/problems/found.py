"""What the paths of a trial show, and by which frames it is told."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from ...data.array_types import Ints
from ...data.problems import ASK_ABOVE
from ...edit.probable_errors import (
    Break,
    Change,
    Filling,
    Ghost,
    Leap,
    Moment,
    Paths,
    Piece,
    Spike,
    in_trial,
)

LIKELY = 0.5
"""Probability from which on a spike, a leap or an exchange stands for what is beside it; chosen."""
ONCE = 6
"""Frames within which a path shows one thing twice, at most; chosen, as what filters smear (`leaps.SMEARED`)."""


class Found(NamedTuple):
    """What a trial's paths show: places of the paths, and what may be wrong with them, changes seen once; and what
    happened to all at once in the trial `as_it_is`."""

    paths: Paths
    spikes: tuple[Spike, ...]
    leaps: tuple[Leap, ...]
    changes: tuple[Change, ...]
    pieces: tuple[Piece, ...]
    ghosts: tuple[Ghost, ...]
    fillings: tuple[Filling, ...]
    breaks: tuple[Break, ...]
    as_it_is: Paths


def by_trial(found: Found) -> Found:
    """Changes, spikes and leaps of files as likely as the trial's others make them; those of tracks that have images
    are judged by themselves."""
    if found.paths.images.any():
        return found
    some = (found.changes, found.spikes, found.leaps)
    alone = np.array([one.wrong for kind in some for one in kind])
    wrong = iter(in_trial(alone, found.paths.rate, list(_moments(found))).tolist())
    return found._replace(
        changes=tuple(one._replace(wrong=next(wrong)) for one in found.changes),
        spikes=tuple(one._replace(wrong=next(wrong)) for one in found.spikes),
        leaps=tuple(one._replace(wrong=next(wrong)) for one in found.leaps),
    )


def _moments(found: Found) -> Iterator[Moment]:
    """Of changes, spikes and leaps."""
    for change in found.changes:
        yield Moment(change.place.middle, frozenset({change.place.path, change.partner.path} - {-1}))
    for spike in found.spikes:
        yield Moment((spike.first + spike.last) / 2, frozenset({spike.path}))
    for leap in found.leaps:
        yield Moment((leap.before + leap.after) / 2, frozenset({leap.path}))


def likeliest(found: Found, near: float) -> Found:
    """Without what files show that is not worth a look, and is on its path within `near` frames of what is, with which
    it is looked at, or within ONCE of what is likelier: this shows the same, which would count several times among the
    errors that are expected."""
    some = [(one.place.path, *_span(found.paths, one), one.wrong) for one in found.changes]
    some += [(one.path, one.first, one.last, one.wrong) for one in found.spikes]
    some += [(one.path, one.before, one.after, one.wrong) for one in found.leaps]
    with_images = [bool(row.any()) for row in found.paths.images]
    kept = np.zeros(len(some), bool)
    frames: dict[int, list[tuple[float, float]]] = {}
    for k in sorted(range(len(some)), key=lambda k: -some[k][3]):
        path, first, last, wrong = some[k]
        beside = any(low <= last and first <= high for low, high in frames.get(path, ()))
        kept[k] = wrong >= ASK_ABOVE or with_images[path] or not beside
        exchanged = k < len(found.changes) and wrong >= ASK_ABOVE
        others = (path, found.changes[k].partner.path) if exchanged else (path,)
        for other in others if kept[k] else ():
            reach = near if wrong >= ASK_ABOVE else min(ONCE, near)
            frames.setdefault(other, []).append((first - reach, last + reach))
    stays = iter(kept.tolist())
    return found._replace(
        changes=tuple(one for one in found.changes if next(stays)),
        spikes=tuple(one for one in found.spikes if next(stays)),
        leaps=tuple(one for one in found.leaps if next(stays)),
    )


def _span(paths: Paths, one: Change) -> tuple[int, int]:
    """Frames of the samples beside a change."""
    first, last = paths.frames[one.place.path][one.place.sample :][:2].tolist()
    return first, last


def not_exchanged(some: Sequence[Piece], own: Sequence[Change], near: float) -> list[Piece]:
    """The pieces of files that no likely exchange beside them, within `near` frames, joins otherwise: the path that
    ends then has another's samples."""
    likely = [one for one in own if one.wrong >= LIKELY and one.partner.path >= 0]

    def said(piece: Piece, one: Change) -> bool:
        low, high = sorted((piece.last, piece.first))
        mine = {piece.before, piece.after} & {one.place.path, one.partner.path}
        return bool(mine) and low - near <= one.place.middle <= high + near

    return [one for one in some if one.kind == "piece" or not any(said(one, change) for change in likely)]


def numbered(found: Found, frame: Ints) -> Found:
    """By the frames that the trial has, `frame` being the one that each is."""
    at = [int(f) for f in frame]

    def change(one: Change) -> Change:
        middle = float(np.interp(one.place.middle, np.arange(len(frame)), frame))
        return one._replace(place=one.place._replace(middle=middle))

    return found._replace(
        paths=found.paths._replace(frames=tuple(frame[own] for own in found.paths.frames)),
        changes=tuple(change(one) for one in found.changes),
        spikes=tuple(one._replace(first=at[one.first], last=at[one.last]) for one in found.spikes),
        leaps=tuple(one._replace(before=at[one.before], after=at[one.after]) for one in found.leaps),
        pieces=tuple(one._replace(last=at[one.last], first=at[one.first]) for one in found.pieces),
        ghosts=tuple(one._replace(first=at[one.first], last=at[one.last]) for one in found.ghosts),
        fillings=tuple(one._replace(first=at[one.first], last=at[one.last]) for one in found.fillings),
    )


def apart_from(found: Found, causes: Sequence[Break], near: float) -> Found:
    """Without what is not worth a look and within `near` frames of a cause of all markers: it is looked at with that,
    and a list would have it for every marker."""

    def stays(wrong: float, first: float, last: float) -> bool:
        return wrong >= ASK_ABOVE or not any(c.before - near <= last and first <= c.after + near for c in causes)

    return found._replace(
        spikes=tuple(one for one in found.spikes if stays(one.wrong, one.first, one.last)),
        leaps=tuple(one for one in found.leaps if stays(one.wrong, one.before, one.after)),
        changes=tuple(one for one in found.changes if stays(one.wrong, one.place.middle, one.place.middle)),
    )
