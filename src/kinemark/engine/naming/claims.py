"""What people claimed of a trial's identities, as facts for the naming of its tracks.

The journal of edits is read when the graph of a trial is made, and the claims that count are part of the key of the
stage `label`: a claim more or less names the trial anew, with the claims as facts by which neighbours are found. The
stage `edit` applies the journal afterwards as ever. There is no circle, as claims are anchored in images and places,
not in names.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ...data import Detections, MarkerTrajectory, Origin, Trajectories
from ...data.array_types import Bools, Ints
from ...data.edits import Claim, live
from ...edit.claims import claim_of_each
from ..editing.journal import Journal


class ClaimedTracks(NamedTuple):
    """Tracks cut where claims begin and end; the name of each that was claimed, None where it is no marker."""

    tracks: Trajectories
    stated: dict[str, str | None]


def claims_of(root: Path, trial: str) -> tuple[Claim, ...]:
    """The claims that count in the journal of a trial, in their order."""
    entries = live(Journal.of(root, trial).read().entries)
    return tuple(edit for entry in entries for edit in entry.edits if isinstance(edit, Claim))


def claimed_tracks(
    tracks: Trajectories, claims: Sequence[Claim], detections: Detections | None, *, world: str
) -> ClaimedTracks:
    """Tracks and what was claimed of them.

    Of two pieces of which the same name was claimed, the later claim counts where both are seen at once.

    Args:
        tracks: of a trial. detections: behind their samples, None for files alone. world: key of the cameras.
    """
    if not claims or not len(tracks):
        return ClaimedTracks(tracks, {})
    of = claim_of_each(tracks, claims, detections, world=world)
    named = np.array([one.name is not None for one in claims], bool)
    paths: list[MarkerTrajectory] = []
    claim: dict[str, int] = {}
    for path, own in zip(tracks, of, strict=True):
        part = _parts(path, own, named)
        for i, k in enumerate(pieces := np.unique(part[part >= 0]).tolist(), 1):
            name = path.name if len(pieces) == 1 else f"{path.name} ({i})"
            paths.append(replace(path.only(part == k), name=name))
            if (which := int(own[part == k][0])) >= 0:
                claim[name] = which
        paths += [path] if not pieces else []
    return _each_at_once(tuple(paths), tracks, claims, claim)


def _parts(path: MarkerTrajectory, own: Ints, named: Bools) -> Ints:
    """(F) the piece of each sample, −1 where there is none: those of a claim are one, and so is what is between two.

    A claim of no marker, of which `named` (K) is false, does not part what is before and after it.
    """
    seen = path.origin != Origin.MISSING
    claimed = own >= 0
    parting = claimed & named[np.maximum(own, 0)]
    free = len(named) + np.cumsum(np.diff(parting.astype(int), prepend=0) == 1)
    return np.where(seen, np.where(claimed, own, free), -1)


def _each_at_once(
    paths: tuple[MarkerTrajectory, ...], tracks: Trajectories, claims: Sequence[Claim], claim: dict[str, int]
) -> ClaimedTracks:
    """Pieces and the names claimed of them, by their claims: no name twice at once.

    Where two pieces are joined that are both seen for some frames, the first one is left out in these; one that is
    left out in most of its frames has not the name at all.
    """
    seen = {path.name: path.origin != Origin.MISSING for path in paths if path.name in claim}
    stated: dict[str, str | None] = {}
    cut: list[MarkerTrajectory] = []
    for path in paths:
        if (k := claim.get(path.name)) is None:
            cut.append(path)
            continue
        later = [n for n, other in claim.items() if other > k and claims[other].name == claims[k].name is not None]
        at_once = seen[path.name] & np.any([seen[n] for n in later], axis=0) if later else np.zeros(len(path), bool)
        if 2 * at_once.sum() >= seen[path.name].sum():
            cut.append(path)
            continue
        stated[path.name] = claims[k].name
        cut.append(path.only(~at_once))
        if at_once.any():
            cut.append(replace(path.only(at_once), name=f"{path.name} (twice)"))
    return ClaimedTracks(replace(tracks, paths=tuple(cut)), stated)
