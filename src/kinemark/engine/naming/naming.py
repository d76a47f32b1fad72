"""Naming the tracks of a trial: by a template, by what a person stated, or as the recording itself says."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from ...data import Finding, Tracks, Trajectories, make_finding
from ...data.array_types import Bools, Ints
from ...data.track_trajectories import trajectories_of
from ...findings.labels import label_figures, label_findings
from ...io.stated_names_csv import StatedName
from ...label import Labelling, Labels, Switch, label_subjects, label_switching, learn_template, named
from ...label.bystanders import among_bystanders
from ...label.pooled import contradiction
from ...label.stated import with_stated
from ...label.subject_template import FEWEST
from ...numerics.evenly import evenly_rounded
from .claims import ClaimedTracks
from .named_tracks import NamedTracks
from .stated_exchanges import stated_exchanges
from .statements import facts_of, labels_of_facts
from .templates import SessionTemplate, markers_of, prefix_of

ACCEPTED = 0.9
"""Share of what could have a name that must have a sure one, for a trial to be learnt from; chosen."""
LEARNT_FRAMES = 300
"""Of a trial that others learn from, evenly spread; as many as a template looks at; chosen."""
SHARED = 0.5
"""Share of a nameless track's points that have an image in common with a named marker's, from which on the track is
taken for a ghost; chosen."""


def name_tracks(
    tracks: Tracks,
    by: Mapping[str, SessionTemplate],
    *,
    how: Labelling,
    stated: Sequence[StatedName] = (),
    first_frame: int = 1,
    claimed: ClaimedTracks | None = None,
    images: Collection[int] = (),
) -> NamedTracks:
    """The tracks joined to markers, with names where evidence or statements give them.

    Nameless tracks that are made of images of named markers are ghosts, and no tracks any more.

    Args:
        tracks: of a trial.
        by: what is known of each subject, as `templates_of_trial` has it; none where nothing is.
        how: what the session says of labelling.
        stated: what a person said of this trial.
        first_frame: number of the first frame in the recording.
        claimed: its trajectories, a point's row as its residual, with what was claimed; made of the tracks where None.
        images: numbers of tracks that are images in a mirror, and no markers unless somebody said so.
    """
    points, claims = claimed or ClaimedTracks(numbered(tracks, first_frame), {})
    facts = facts_of(points, stated)
    known = facts.of | claims  # what was claimed is later
    no_markers = dict.fromkeys(_made_of(points, tracks, images))
    points, labels, switches, undecided = _labelled(points, by, how, no_markers | known)
    done = named(points, labels, unsure=how.unsure)
    joined = rows_of(done, len(tracks.cloud))
    ghosts = ghost_tracks(tracks, joined, sum(not name.startswith("*") for name in done.names))
    expected = [prefix_of(s) + name for s, one in by.items() for name in one.template.names]
    sources = list(dict.fromkeys(source for one in by.values() for source in one.sources))
    figures = label_figures(points, labels, done, expected, sources)
    figures["ghosts_removed"] = len(ghosts)
    figures["stated"] = len(known)
    figures["switches"] = [{"frame": one.frame, "before": one.before, "after": one.after} for one in switches]
    if any(by):
        figures["subjects"], figures["undecided"] = list(by), [list(pair) for pair in undecided]
    findings = [*_lost(facts.lost, points.first_frame), *label_findings(figures, labels, template=bool(by))]
    findings += [said for one in by.values() for said in one.findings]
    kept = _without(joined, ghosts)
    names = renumbered([name for k, name in enumerate(done.names) if k not in ghosts])
    by_hand = stated_exchanges(done, by, known.values())
    contradicts = {s: found for s, one in by.items() if (found := _contradicts(markers_of(done, s), one, s))}
    accepted = not by or (not labels.refused and (figures["sure_share"] or 0.0) >= ACCEPTED)
    return NamedTracks(
        Tracks(tracks.cloud, kept), names, tracker_names(tracks, kept, names), figures,
        (*findings, *by_hand.findings, *contradicts.values()),
        learnt_of(_without_subjects(by_hand.learnt, contradicts), accepted), learnt_frames(points),
    )  # fmt: skip


def numbered(tracks: Tracks, first_frame: int) -> Trajectories:
    """Tracks as trajectories in which a point's row stands as its residual."""
    rows = np.arange(len(tracks.cloud), dtype=np.float64)
    return replace(trajectories_of(tracks, rows), first_frame=first_frame)


def _made_of(points: Trajectories, tracks: Tracks, which: Collection[int]) -> Iterator[str]:
    """Names of the trajectories, a point's row as its residual, that are made of these tracks."""
    for path in points:
        rows = path.residual[np.isfinite(path.residual)].astype(np.int64)
        if len(rows) and np.isin(tracks.id[rows], list(which)).all():
            yield path.name


class _Named(NamedTuple):
    """Tracks, cut where they go over to another marker, with labels; pairs of subjects that were not told apart."""

    points: Trajectories
    labels: Labels
    switches: tuple[Switch, ...] = ()
    undecided: tuple[tuple[str, str], ...] = ()


def _labelled(
    points: Trajectories, by: Mapping[str, SessionTemplate], how: Labelling, known: Mapping[str, str | None]
) -> _Named:
    """By the templates and what is known; the tracks of several subjects are not cut."""
    if not by or not len(points) or not np.isfinite(points.xyz).any():
        return _Named(points, with_stated(labels_of_facts(len(points)), points, known))
    if "" in by:
        own = by[""]
        cut = label_switching(points, own.template, method=how.method, stated=known)
        labels = cut.labels
        if own.wider is not None:
            labels = among_bystanders(cut.tracks, labels, own.template, own.wider, method=how.method, stated=known)
        return _Named(cut.tracks, labels, cut.switches)
    found = label_subjects(points, {s: one.template for s, one in by.items()}, method=how.method, stated=known)
    return _Named(points, found.labels, (), found.undecided)


def _without_subjects(done: Trajectories, subjects: Iterable[str]) -> Trajectories:
    """The trial without the markers of these."""
    prefixes = tuple(map(prefix_of, subjects))
    return replace(done, paths=tuple(path for path in done if not path.name.startswith(prefixes)))


def _contradicts(done: Trajectories, by: SessionTemplate, subject: str) -> Finding | None:
    """Where a subject's markers sit elsewhere than the template says, so that others should not learn from them."""
    known = [name for name in done.names if name in by.template.names]
    found = contradiction(by.template, learn_template(done, names=known), done) if len(known) >= FEWEST else None
    if found is None:
        return None
    return make_finding(
        "trial_contradicts_template",
        markers=[prefix_of(subject) + name for name in found.markers],
        pairs_share=found.pairs_share,
        off_mm=found.off_mm,
    )


def stated_by_recording(tracks: Tracks, trajectories: Trajectories) -> NamedTracks:
    """What an operator or the recording's own file named, which are facts; other trials learn from them."""
    figures = label_figures(trajectories, None, trajectories, (), ())
    names = tuple(trajectories.names)
    learnt = learnt_of(trajectories, True)
    return NamedTracks(tracks, names, names, figures, (), learnt, learnt_frames(trajectories))


def rows_of(done: Trajectories, n_points: int) -> Ints:
    """(P) the marker of each point, by the rows that stand as residuals; −1 for none."""
    joined = np.full(n_points, -1)
    for k, path in enumerate(done):
        joined[path.residual[np.isfinite(path.residual)].astype(np.int64)] = k
    return joined


def ghost_tracks(tracks: Tracks, joined: Ints, n_named: int) -> frozenset[int]:
    """Nameless tracks, by their place among all, most of whose points have an image in common with a named marker's."""
    image = tracks.cloud.detection
    of_named: Bools = np.asarray((joined >= 0) & (joined < n_named))
    taken = _images(image, of_named)
    shares: Bools = np.asarray((taken[image] & (image >= 0)).any(1))
    rest = np.flatnonzero(joined >= n_named)
    count = np.bincount(joined[rest], minlength=n_named)
    shared = np.bincount(joined[rest], weights=shares[rest], minlength=n_named)
    return frozenset(np.flatnonzero((count > 0) & (shared >= SHARED * np.maximum(count, 1))).tolist())


def _images(image: Ints, points: Bools) -> Bools:
    """(D + 1) whether an image is one of some points' (P, C)."""
    taken = np.zeros(int(image.max(initial=-1)) + 2, bool)
    taken[image[points]] = True
    taken[-1] = False  # of −1
    return taken


def _without(joined: Ints, ghosts: frozenset[int]) -> Ints:
    """(P) the same without some of the tracks, numbered anew."""
    number = np.array([-1 if k in ghosts else 0 for k in range(int(joined.max(initial=-1)) + 1)] + [-1])
    number[number == 0] = np.arange((number == 0).sum())
    return number[joined]


def renumbered(names: Sequence[str]) -> tuple[str, ...]:
    """The names, and `*1`, `*2`, … for the others in their order."""
    rest = iter(range(1, len(names) + 1))
    return tuple(f"*{next(rest)}" if name.startswith("*") else name for name in names)


def tracker_names(tracks: Tracks, joined: Ints, names: Sequence[str]) -> tuple[str, ...]:
    """What most of each of the tracker's tracks became; empty for no marker."""
    found = []
    for k in range(len(tracks)):
        own = joined[tracks.id == k]
        own = own[own >= 0]
        found.append(names[int(np.bincount(own).argmax())] if len(own) else "")
    return tuple(found)


def with_names(found: Finding, names: Sequence[str]) -> Finding | None:
    """What the tracker found, its tracks `*1`, `*2`, … by what they became; None where that has settled it.

    Args:
        found: by the tracker. names: of its tracks, empty for no marker.
    """

    def called(text: Any) -> Any:
        own = isinstance(text, str) and text[:1] == "*" and text[1:].isdigit() and int(text[1:]) <= len(names)
        return (names[int(text[1:]) - 1] or "no marker") if own else text

    values = {k: tuple(map(called, v)) if isinstance(v, tuple) else called(v) for k, v in found.values.items()}
    if found.kind == "tracks_continue":
        pairs = [pair for pair in zip(values["earlier_list"], values["later_list"], strict=True) if len(set(pair)) > 1]
        if not pairs:
            return None  # they were joined
        earlier, later = zip(*pairs, strict=True)
        values |= {"tracks": len(pairs), "earlier_list": earlier, "later_list": later}
    return replace(found, markers=tuple(map(called, found.markers)), values=values)


def learnt_of(trajectories: Trajectories, accepted: bool) -> Trajectories:
    """Some frames of the markers that have names; no markers where the names were not accepted."""
    F, rows = trajectories.n_frames, _learnt_rows(trajectories)
    columns = ("xyz", "cov", "origin", "residual", "cameras", "detection")
    paths = [
        replace(path, **{key: getattr(path, key)[rows] for key in columns})
        for path in trajectories
        if accepted and not path.name.startswith("*")
    ]
    return Trajectories(tuple(paths), trajectories.rate * len(rows) / max(F, 1))


def learnt_frames(trajectories: Trajectories) -> tuple[int, ...]:
    """The number in the recording of each frame that `learnt_of` keeps."""
    return tuple((_learnt_rows(trajectories) + trajectories.first_frame).tolist())


def _learnt_rows(trajectories: Trajectories) -> Ints:
    """(n) the frames, from 0, that others learn from."""
    return evenly_rounded(trajectories.n_frames, LEARNT_FRAMES)


def _lost(lost: Sequence[StatedName], first_frame: int) -> tuple[Finding, ...]:
    """Statements that are about no track of this trial; frames from 0."""
    if not lost:
        return ()
    frames = tuple((one.frame - first_frame,) * 2 for one in lost)
    return (make_finding("stated_names_lost", markers=[one.name for one in lost], frames=frames, statements=len(lost)),)
