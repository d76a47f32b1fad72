"""Names of tracks: what automatic labelling proposes, and whether links keep their lengths."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...data import MarkerSet, MarkerTrajectory, Trajectories
from ...data.edits import is_named
from ...engine.naming.proposed_names import propose_names
from ...report.words import text_of
from .desk import OpenDocument
from .edit_messages import Labels, LinkFound, LinkState, Proposal
from .header import finite

STRETCHED = 0.04
"""Standard deviation of a link's length, as a share of it, above which a link within a segment is shown as stretched;
chosen: skin moves markers of one segment by 1–3 % against each other. More where the marker set states more."""
LEAST_FRAMES = 10
"""That a link must be seen in for its spread to say something; chosen."""


NONE_FITS = (
    "No names are proposed: none of the templates and labelled trials in the folder of {} fits it, nor do the names "
    "that it has. Put a labelled trial of the subject beside it, or a template that kinemark template kept."
)


def labels(document: OpenDocument, *, ask: bool = False) -> Labels:
    """Proposals, links and sides of an open trial; those of a file without a session where they were asked for."""
    if document.trial is None:
        return _of_file(document, ask=ask)
    record = document.records.get("label")
    proposals = [] if record is None else [*_sure(record.figures, document), *_unsure(record.figures, document)]
    said = [] if record is None else list(record.findings)
    sides = [text_of(one) for one in said if "side" in one.kind]
    words = [text_of(one) for one in said if "side" not in one.kind]
    return Labels(
        proposals=proposals,
        links=_links(document.marker_set, document.now.trajectories),
        sides=" ".join(sides),
        words=" ".join(words) if not proposals else "",
        known=[],
        head=document.head,
    )


def _of_file(document: OpenDocument, *, ask: bool) -> Labels:
    """By what lies beside the file; tracks that were changed since are asked about again."""
    now = document.now.trajectories
    if ask:
        document.kept["names"] = propose_names(document.place.path, now), now
    found, then = document.kept.get("names", (None, now))
    same = {path.name for path, old in ((path, _called(then, path.name)) for path in now) if path is old}
    each = found.names if found is not None else {}
    return Labels(
        proposals=[
            Proposal(
                track=track,
                name=one.name,
                probability=one.probability,
                runner_up=one.runner_up,
                state="sure" if one.sure else "unsure",
            )
            for track, one in each.items()
            if track in same
        ],
        links=_links(document.marker_set, now),
        words=NONE_FITS.format(document.place.path.name) if found is not None and not each else "",
        can_ask=not all(map(is_named, now.names)),
        by=found.source if found is not None else "",
        known=list(found.known) if found is not None else [],
        head=document.head,
    )


def _called(trajectories: Trajectories, name: str) -> MarkerTrajectory | None:
    return next((path for path in trajectories if path.name == name), None)


def _sure(figures: Any, document: OpenDocument) -> list[Proposal]:
    """Markers that have their names from labelling."""
    there = set(document.now.trajectories.names)
    return [
        Proposal(
            track=one["name"],
            name=one["name"],
            probability=one["probability"] or 0.0,
            runner_up=one["runner_up"],
            state="sure" if one["state"] in ("sure", "stated") else "unsure",
        )
        for one in figures["markers"]
        if one["state"] != "missing" and one["name"] in there
    ]


def _unsure(figures: Any, document: OpenDocument) -> list[Proposal]:
    """Tracks without a marker's name that labelling has one for, by the track that has most of their samples now.

    A track that was joined of several has the proposal of the longest.
    """
    markers = set() if document.marker_set is None else set(document.marker_set.names)
    found: dict[str, tuple[int, Proposal]] = {}
    given = [path for path in document.editing.trajectories if path.name.startswith("*")]
    for one in figures["unsure"]:  # in the order of the paths
        extent = one["first_frame"], one["last_frame"]
        piece = next((path for path in given if _extent(path) == extent), None)
        if piece is None:
            continue
        given = [path for path in given if path is not piece]
        track, samples = _has_most(piece, document.now.trajectories)
        if track is None or track in markers or samples <= found.get(track, (0, None))[0]:
            continue
        found[track] = (
            samples,
            Proposal(
                track=track,
                name=one["name"],
                probability=one["probability"],
                runner_up=one["runner_up"],
                state="unsure",
            ),
        )
    return [proposal for _, proposal in found.values()]


def _has_most(piece: MarkerTrajectory, trajectories: Trajectories) -> tuple[str | None, int]:
    """The trajectory that has most samples of a path, and how many; None where none has any."""
    here = np.flatnonzero(piece.origin)
    shared = [(int((path.xyz[here] == piece.xyz[here]).all(1).sum()), path.name) for path in trajectories]
    samples, name = max(shared, default=(0, ""))
    return (name, samples) if samples else (None, 0)


def _extent(path: MarkerTrajectory) -> tuple[int, int]:
    """First and last frame that are there, from 0; −1 where none is."""
    seen = np.flatnonzero(path.origin)
    return (int(seen[0]), int(seen[-1])) if len(seen) else (-1, -1)


def _links(marker_set: MarkerSet | None, trajectories: Trajectories) -> list[LinkFound]:
    """The links of the marker set whose ends are both there."""
    if marker_set is None:
        return []
    there = {path.name: path for path in trajectories}
    found = []
    for (a, b), stated in zip(marker_set.links.tolist(), marker_set.length, strict=True):
        ends = there.get(marker_set.names[a]), there.get(marker_set.names[b])
        if ends[0] is not None and ends[1] is not None:
            allowed = _allowed(marker_set, ends[0].name, ends[1].name)
            found.append(_link(ends[0].name, ends[1].name, ends[0].xyz - ends[1].xyz, finite(stated), allowed))
    return found


def _allowed(marker_set: MarkerSet, a: str, b: str) -> float | None:
    """The share of its length by which a link may vary; None for one over a joint, whose length the joint changes."""
    both = [name for name, markers in marker_set.segments.items() if a in markers and b in markers]
    if marker_set.segments and not both:
        return None
    return max([STRETCHED, *(marker_set.rigidity.get(name, 0.0) for name in both)])


def _link(a: str, b: str, apart: Any, stated: float | None, allowed: float | None) -> LinkFound:
    length = np.linalg.norm(apart, axis=1)
    length = length[np.isfinite(length)]
    if len(length) < LEAST_FRAMES:
        return LinkFound(a=a, b=b, mean_mm=None, sd_mm=None, stated_mm=stated, state="unknown")
    mean, sd = float(length.mean()), float(length.std())
    state: LinkState = "bends" if allowed is None else "stretched" if sd > allowed * mean else "steady"
    return LinkFound(a=a, b=b, mean_mm=mean, sd_mm=sd, stated_mm=stated, state=state)
