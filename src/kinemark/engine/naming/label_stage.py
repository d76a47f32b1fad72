"""The stage `label` of a trial's graph."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ...data import Detections, Tracks, Trajectories
from ...data.array_types import Bools
from ...data.edits import Claim
from ...io.stated_names_csv import StatedName, read_stated_names
from ...reconstruct import LeastSquares, image_errors
from ...track.simultaneous import Simultaneous
from ...track.simultaneous.diagnosis.mirror_images import mirror_images
from ..keys import world_key
from ..sources import Recording
from ..trial_rig import TrialRig
from .claims import ClaimedTracks, claimed_tracks
from .earlier import ABSENT, Earlier, template_files_key
from .named_tracks import NamedTracks, load_learnt
from .naming import name_tracks, numbered, stated_by_recording
from .second_pass import Search, second_pass
from .statements import facts_of
from .templates import prefix_of, templates_of_trial, worn


def given_of(of: Recording, earlier: Sequence[Earlier], claims: Sequence[Claim]) -> tuple[Any, ...]:
    """What names depend on besides the tracks: files, marker set, clusters, trials before, and what people claimed."""
    label = of.settings.label
    assert label is not None  # else there is no such stage
    before = [(one.name, one.kind, one.key) for one in earlier]
    several = {s: worn(of.root, of.settings.of_subject(s)) for s in of.settings.label_subjects}
    apart = (of.settings.label_subjects, of.settings.subjects_of(of.entry), several) if several else ()
    gait = of.settings.gait
    segments = (gait.clusters, gait.markers) if gait is not None and gait.clusters else ()
    given = template_files_key(of.root, of.settings), worn(of.root, of.settings), before, *apart, *segments
    return (*given, claims, world_key(of.rig)) if claims else given


def name_trial(
    of: Recording,
    tracks: Tracks,
    earlier: Sequence[Earlier],
    named: Trajectories | None,
    claims: Sequence[Claim],
    detections: Detections,
    cameras: TrialRig,
) -> NamedTracks:
    """The tracks of a trial joined to markers.

    Args:
        of: what is recorded. tracks: of it. earlier: the trials before it.
        named: its markers where the recording itself says which is which.
        claims: of people, which are facts. detections: behind the tracks, as recorded.
        cameras: that the tracks were made with.

    Raises:
        KinemarkError: a file that the session names is absent or unusable.
    """
    label = of.settings.label
    assert label is not None  # else there is no such stage
    if named is not None:
        return stated_by_recording(tracks, named)
    templates = templates_of_trial(of.root, of.settings, earlier, of.entry)
    first = of.first_frame
    claimed = claimed_tracks(numbered(tracks, first), claims, detections, world=world_key(of.rig))
    stated = _stated(of)
    images = mirror_images(tracks, cameras.rig).tolist()
    found = name_tracks(tracks, templates, how=label, stated=stated, first_frame=first, claimed=claimed, images=images)
    tracker = of.settings.track
    if label.second_pass and isinstance(tracker, Simultaneous):
        fixed = _spoken(claimed, stated, len(tracks.cloud))
        found = second_pass(found, tracks, templates, _search(of, detections, cameras, tracker), fixed=fixed)
    return found._replace(figures={**found.figures, "claimed": len(claimed.stated)})


def _search(of: Recording, detections: Detections, cameras: TrialRig, tracker: Simultaneous) -> Search:
    """As the tracker had it."""
    place = of.settings.reconstruct if isinstance(of.settings.reconstruct, LeastSquares) else LeastSquares()
    margin = place.volume_margin if place.within_volume else None
    return Search(cameras.seen(detections), cameras.rig, tracker, image_errors(place), margin)


def _spoken(claimed: ClaimedTracks, stated: Sequence[StatedName], n_points: int) -> Bools:
    """(P) points of tracks of which a person said what they are."""
    out = np.zeros(n_points, bool)
    for name in {*claimed.stated, *facts_of(claimed.tracks, stated).of}:
        rows = claimed.tracks[name].residual
        out[rows[np.isfinite(rows)].astype(np.int64)] = True
    return out


def _stated(of: Recording) -> tuple[StatedName, ...]:
    """What a person said of this trial."""
    label = of.settings.label
    if label is None or label.names is None:
        return ()
    return tuple(one for one in read_stated_names(of.root / label.names) if one.trial == of.entry.name)


def static_of(earlier: Sequence[Earlier], subjects: Sequence[str] = ()) -> Trajectories | None:
    """The markers of the session's first static trial that has names; None where there is none.

    Args:
        earlier: the trials before another. subjects: of several, those of that other, whose markers are wanted.
    """
    prefixes = tuple(map(prefix_of, subjects)) or ("",)
    for one in earlier:
        if one.kind == "static" and one.key != ABSENT:
            learnt = load_learnt(one.folder)
            own = tuple(path for path in learnt if path.name.startswith(prefixes))
            if own:
                return replace(learnt, paths=own)
    return None
