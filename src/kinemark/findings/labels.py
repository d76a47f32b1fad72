"""What is to be said of the names of a trial's markers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ..data import Finding, Trajectories, make_finding
from ..label import Labels
from .plain import plain


def label_figures(
    tracks: Trajectories,
    labels: Labels | None,
    done: Trajectories,
    expected: Sequence[str],
    sources: Sequence[str],
) -> dict[str, Any]:
    """For quality.json and the report.

    Args:
        tracks: that were labelled. labels: of them; None where the recording itself names its markers.
        done: what they became.
        expected: names that the template has. sources: files and trials that it was learnt from.
    """
    n = np.isfinite(tracks.xyz[..., 0]).sum(1) if len(tracks) else np.zeros(0, int)
    names = [name for name in done.names if not name.startswith("*")]
    markers = [_of_marker(name, done, labels, n) for name in names]
    markers += [_missing(name) for name in expected if name not in names]
    unsure = [] if labels is None else [_unsure(tracks, labels, k, n) for k in _of_state(labels, "unsure")]
    could = min(len(expected), len(tracks)) and np.minimum(np.isfinite(tracks.xyz[..., 0]).sum(0), len(expected)).sum()
    sure = sum(int(n[k]) for k in _of_state(labels, "sure")) if labels else int(n.sum())
    return plain(
        {
            "sources": list(sources),
            "fit": labels.fit if labels and expected else None,
            "placed_share": labels.placed if labels and expected else None,
            "sure_share": sure / could if could else None,
            "refused": bool(labels and labels.refused),
            "markers": markers,
            "unsure": unsure,
            "displaced": [{"name": a, "off_mm": mm} for a, mm in (labels.displaced if labels else ()) if a in names],
        }
    )


def _of_state(labels: Labels, state: str) -> list[int]:
    return [k for k, one in enumerate(labels.state) if one == state]


def _of_marker(name: str, done: Trajectories, labels: Labels | None, n: Any) -> dict[str, Any]:
    """A marker that is there: its probability is the mean over its samples, its runner-up that of its worst piece."""
    samples = int(np.isfinite(done[name].xyz[:, 0]).sum())
    if labels is None:
        return {
            "name": name, "samples": samples, "probability": 1.0, "state": "stated", "runner_up": None, "pieces": 1
        }  # fmt: skip
    own = [k for k, one in enumerate(labels.names) if one == name and labels.state[k] != "unknown"]
    taken = [k for k in own if labels.state[k] == "sure"] or own
    p, weight = labels.probability[taken], n[taken]
    least = taken[int(np.argmin(p))] if taken else None
    return {
        "name": name,
        "samples": samples,
        "probability": float((p * weight).sum() / max(weight.sum(), 1)),
        "state": "sure" if all(labels.state[k] == "sure" for k in own) else "unsure",
        "runner_up": labels.runner_up[least] if least is not None else None,
        "pieces": len(taken),
    }


def _missing(name: str) -> dict[str, Any]:
    return {"name": name, "samples": 0, "probability": None, "state": "missing", "runner_up": None, "pieces": 0}


def _unsure(tracks: Trajectories, labels: Labels, k: int, n: Any) -> dict[str, Any]:
    """A track whose name is not sure; frames from 0, both included."""
    seen = np.flatnonzero(np.isfinite(tracks.paths[k].xyz[:, 0]))
    return {
        "name": labels.names[k],
        "probability": float(labels.probability[k]),
        "runner_up": labels.runner_up[k],
        "first_frame": int(seen[0]),
        "last_frame": int(seen[-1]),
        "samples": int(n[k]),
    }


def label_findings(figures: Mapping[str, Any], labels: Labels, *, template: bool) -> tuple[Finding, ...]:
    """What needs attention: no template, one that does not fit, unsure sides and stretches, markers not found."""
    if not template:
        return () if figures["stated"] else (make_finding("labels_without_template"),)
    if labels.refused is not None:
        return (labels.refused,)
    found = [] if labels.undecided is None else [labels.undecided]
    probably = {one["name"] for one in figures["unsure"]}
    if unsure := figures["unsure"]:
        found.append(
            make_finding(
                "labels_unsure",
                markers=sorted(probably),
                frames=[(one["first_frame"], one["last_frame"]) for one in unsure],
                stretches=len(unsure),
            )
        )
    if missing := [
        one["name"] for one in figures["markers"] if one["state"] == "missing" and one["name"] not in probably
    ]:
        found.append(make_finding("markers_not_found", markers=missing))
    if displaced := figures["displaced"]:
        found.append(displaced_finding(displaced))
    if switches := figures["switches"]:
        names = sorted({one[key] for one in switches for key in ("before", "after")})
        frames = sorted({(one["frame"] - 1, one["frame"]) for one in switches})
        found.append(make_finding("tracks_switched", markers=names, frames=frames, switches=len(switches)))
    if figures["ghosts_removed"]:
        found.append(make_finding("ghosts_removed", tracks=figures["ghosts_removed"]))
    return tuple(found)


def displaced_finding(displaced: Sequence[Mapping[str, Any]]) -> Finding:
    """Markers beside their places: each with its `name` and `off_mm`."""
    return make_finding(
        "markers_displaced",
        markers=[one["name"] for one in displaced],
        off_mm_list=[one["off_mm"] for one in displaced],
    )
