"""Edits of values on the markers that they are about; what was worked out for one version serves the next.

The edits of one marker, in their order, lead from its record to another one, and to what became of each; nothing else
does but an image that is no marker's, which is put to every marker. So each marker is folded by itself, and is the same
record again where neither it nor its edits changed: an edit costs one marker, and two versions share all others.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from weakref import WeakValueDictionary

import numpy as np

from ..data import MarkerTrajectory, Origin, Trajectories
from ..data.array_types import Bools
from ..data.edits import Edit, Erase, GapChoice, ImagePoint, Put, Smooth
from .anchors import disowned, with_doubt
from .values import ALONE, Changed, Footage, ImagesByHand, Result, erase, put, smooth, with_image, without_image
from .votes import nearest_images

ValueEdit = Erase | Put | Smooth | ImagePoint | GapChoice


@dataclass(frozen=True, slots=True, eq=False, weakref_slot=True)
class Folded:
    """A marker before and after edits, what became of each, and images by hand; kept by the versions it belongs to."""

    before: MarkerTrajectory
    after: MarkerTrajectory
    results: tuple[Result, ...]
    corrected: ImagesByHand


_KNOWN: WeakValueDictionary[object, Folded] = WeakValueDictionary()


def with_values(
    trajectories: Trajectories, edits: Sequence[Edit], of: Footage
) -> tuple[Trajectories, list[Result], tuple[Folded, ...]]:
    """The markers with edits of values, what became of each edit, and what the next version may use again.

    Args:
        trajectories: as the claims left them. edits: erase, put, smooth, image and gap choices, in their order.
        of: what is behind the samples.
    """
    results: list[list[Result]] = [[] for _ in edits]
    paths, folds = list[MarkerTrajectory](), list[Folded]()
    for path in trajectories:
        mine = [k for k, edit in enumerate(edits) if getattr(edit, "marker", None) in (path.name, None)]
        if not mine:
            paths.append(path)
            continue
        folded = _folded(path, tuple(edits[k] for k in mine), of)
        paths.append(folded.after)
        folds.append(folded)
        for k, result in zip(mine, folded.results, strict=True):
            results[k].append(result)
    same = all(a is b for a, b in zip(paths, trajectories, strict=True))
    whole = trajectories if same else replace(trajectories, paths=tuple(paths))
    found = [_of_all(edit, some, of, trajectories) for edit, some in zip(edits, results, strict=True)]
    return whole, found, tuple(folds)


def _of_all(edit: Edit, results: Sequence[Result], of: Footage, trajectories: Trajectories) -> Result:
    """What became of an edit, from what became of it on each marker that it is about."""
    if isinstance(edit, ImagePoint) and edit.marker is None:
        return _no_marker_result(edit, results, of, trajectories)
    return results[0] if results else Result("orphan", reason=f"there is no marker {getattr(edit, 'marker', '')}")


def _folded(path: MarkerTrajectory, edits: tuple[Edit, ...], of: Footage) -> Folded:
    """A marker with all of its edits."""
    behind = of.first_frame, of.rate, of.detections, of.rig, of.world, of.timed, of.left_out
    found = _KNOWN.get((path, edits, *behind))
    if found is None:
        start = _KNOWN.get((path, edits[:-1], *behind)) or Folded(path, path, (), {})
        corrected = {at: dict(images) for at, images in start.corrected.items()}
        alone, after, results = replace(of, corrected=corrected), start.after, list(start.results)
        for edit in edits[len(results) :]:
            after, result = _applied(path, after, edit, alone)
            results.append(result)
        _KNOWN[path, edits, *behind] = found = Folded(path, after, _joined(edits, results), corrected)
    return found


def _joined(edits: Sequence[Edit], results: Sequence[Result]) -> tuple[Result, ...]:
    """What became of each edit in the end: an image alone is part of the place that a later one made of both."""
    places = {edit.frame: k for k, edit in enumerate(edits) if isinstance(edit, ImagePoint) and _stands(results[k])}
    return tuple(
        Result("held")
        if result == ALONE and isinstance(edit, ImagePoint) and places.get(edit.frame, -1) > k
        else result
        for k, (edit, result) in enumerate(zip(edits, results, strict=True))
    )


def _stands(result: Result) -> bool:
    return result.outcome in ("held", "thin")


def _applied(before: MarkerTrajectory, path: MarkerTrajectory, edit: Edit, of: Footage) -> Changed:
    """A marker after one edit, where that is of what the marker has there; `before`: all of its edits."""
    doubt = disowned(edit, before, path, of)
    if doubt is not None and doubt.outcome == "orphan":
        return path, doubt
    return with_doubt(_changed(path, edit, of), doubt)


def _changed(path: MarkerTrajectory, edit: Edit, of: Footage) -> Changed:
    """A marker after one edit."""
    match edit:
        case Erase():
            return erase(path, edit, of)
        case Put():
            return put(path, edit, of)
        case Smooth():
            return smooth(path, edit, of)
        case GapChoice():
            return path, _choice_result(edit, path.origin == Origin.MISSING, of)
        case ImagePoint():
            return with_image(path, edit, of) if edit.marker is not None else _without(path, edit, of)
        case _:
            raise ValueError(f"{edit} changes no values")


def _choice_result(edit: GapChoice, missing: Bools, of: Footage) -> Result:
    """Whether a choice has anything to choose for."""
    span = slice(max(edit.first - of.first_frame, 0), max(edit.last - of.first_frame + 1, 0))
    n = int(missing[span].sum())
    return Result("held", n) if n else Result("moot", reason="there is no gap in these frames")


def _without(path: MarkerTrajectory, edit: ImagePoint, of: Footage) -> Changed:
    """An image that is no marker's is taken from a marker that has it."""
    seen, f = of.detections, edit.frame - of.first_frame
    nothing = Result("moot", reason="no marker has an image there")
    if seen is None or edit.camera not in seen.cameras or not 0 <= f < min(len(path), seen.n_frames):
        return path, nothing
    c = seen.cameras.index(edit.camera)
    row = nearest_images(np.array([c]), np.array([f]), np.array([[edit.u, edit.v]]), seen)[0]
    if not path.detection.shape[1] or not path.detection[f, c] == row >= 0:
        return path, nothing
    return without_image(path, f, edit.camera, of)[0], Result("held", 1)


def _no_marker_result(edit: ImagePoint, results: Sequence[Result], of: Footage, trajectories: Trajectories) -> Result:
    """From how many markers an image was taken, or why from none."""
    seen, f = of.detections, edit.frame - of.first_frame
    if seen is None or edit.camera not in seen.cameras:
        return Result("orphan", reason=f"there is no camera {edit.camera}")
    if not 0 <= f < min(trajectories.n_frames, seen.n_frames):
        return Result("moot", reason="the trial does not have this frame")
    n = sum(one.outcome == "held" for one in results)
    return Result("held", n) if n else Result("moot", reason="no marker has an image there")
