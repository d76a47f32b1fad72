"""Names of labelled files checked: exchanged markers, swapped sides, stretches that are called what they are not."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ...data import KinemarkError, MarkerTrajectory, Origin, Trajectories
from ...data.array_types import Ints
from ...data.marker_sides import sides_by_name
from ...io.marker_sets import marker_sets, read_marker_set
from ...io.trial import read_trial
from ...label import Exchanged, Template, find_exchanges, learn_template
from ...label.check_sides import SideSwap, find_side_swaps
from ...label.check_stretches import Mislabelled, find_mislabelled
from ...label.evidence import PairScore
from ...label.held import OWN, held
from ...label.own_exchanges import find_own_exchanges, without_exchanged
from ...label.stretches import stretches_of
from ...label.subject_template import SubjectTemplate
from ..put_aside import put_aside
from .subject_templates import without_prefix

MOST_OFF = 0.3
"""Share of named samples that are exchanged or mislabelled from which on a template is of another subject, or most
names are wrong; measured on eight trials of four subjects: by a template of the same one 0.08 at most, of another one
0.2 to 0.8, median 0.6."""


FEWEST = 6
"""Markers without which that is no judge; chosen: of five, one exchange touches nearly all distances."""


class CheckedNames(NamedTuple):
    """What is wrong with the names of a labelled file.

    Attributes:
        exchanged: two markers that carry each other's name. swapped: limbs whose left and right are.
        mislabelled: stretches of another marker, or of none.
        first_frame: number of the file's first frame.
        off_share: of the samples that are named, those that are exchanged or mislabelled.
        holds: share of the stiffest distances that hold, where sides are not swapped.
    """

    exchanged: tuple[Exchanged, ...]
    swapped: tuple[SideSwap, ...]
    mislabelled: tuple[Mislabelled, ...]
    first_frame: int = 1
    off_share: float = 0.0
    holds: float = 1.0

    @property
    def unfit(self) -> str:
        """In words, that the template does not fit the names; empty where it does."""
        if self.off_share < MOST_OFF and self.holds >= OWN:
            return ""
        off = f"{100 * self.off_share:.0f} % of the named samples do not fit the template"
        if self.holds < OWN:
            off = (
                f"Only {100 * self.holds:.0f} % of the distances that should hardly change are as the template has them"
            )
        return (
            f"{off}: it is of another subject, or most names are wrong. Give a template of this subject; if it is, "
            "name the trial anew: kinemark label."
        )

    @property
    def good(self) -> bool:
        """Whether nothing was found."""
        return not (self.exchanged or self.swapped or self.mislabelled)


def check_file(source: Path, template: SubjectTemplate) -> CheckedNames:
    """Where names of a labelled file are wrong.

    Raises:
        KinemarkError: the file cannot be read, has too few of the template's names, or the template does not fit them:
            what it would find says nothing then.
    """
    known = template.marker_set if template.marker_set in marker_sets() else None
    pairs = read_marker_set(known).pairs if known else sides_by_name(template.template.names)
    points = put_aside(read_trial(source), keep=template.template.names).rest
    if not any((path.origin != Origin.MISSING).any() for path in points):
        raise KinemarkError(f"{source} is not checked: none of its markers has a sample. Export it again.")
    found = check_names(without_prefix(points, template.template.names), template.template, pairs)
    if found.unfit:
        raise KinemarkError(f"{source} is not checked. {found.unfit}")
    return found


def check_names(trial: Trajectories, own: Template, pairs: Sequence[tuple[str, str]]) -> CheckedNames:
    """Where names of a labelled trial are wrong.

    Args:
        trial: labelled. own: template of the subject. pairs: left and right names.

    Raises:
        KinemarkError: it has too few of the template's names.
    """
    swapped = find_side_swaps(trial, own, pairs)
    exchanged = tuple(one for one in find_exchanges(trial, own) if not _of_swap(one, swapped))
    mislabelled = find_mislabelled(trial, own, besides=_frames([*exchanged, *swapped]))
    off = _share(_frames([*exchanged, *mislabelled]), trial, own)
    holds = _holds(trial, own, _frames(swapped))
    return CheckedNames(exchanged, swapped, mislabelled, trial.first_frame, off, holds)


def check_by_itself(trial: Trajectories, pairs: Sequence[tuple[str, str]]) -> CheckedNames:
    """The same by what the trial itself is like, but for the samples that contradict the rest of it.

    Raises:
        KinemarkError: it has fewer than four markers.
    """
    (exchanged,) = find_own_exchanges(trial)
    rest = without_exchanged(trial, exchanged)
    found = check_names(rest, learn_template(rest), pairs)
    every = sorted((*exchanged, *found.exchanged), key=lambda one: (one.first, one.markers))
    return found._replace(exchanged=tuple(every))


def check_files(
    sources: Sequence[Path], template: SubjectTemplate, *, announce: Callable[[Path], None] = lambda source: None
) -> dict[Path, CheckedNames | KinemarkError]:
    """Each of many; an error stands in the place of one that cannot be checked.

    Args:
        sources: files with names. template: of their subject. announce: called with each file before it is checked.

    Raises:
        KinemarkError: the only one cannot be checked.
    """
    done: dict[Path, CheckedNames | KinemarkError] = {}
    for source in sources:
        announce(source)
        try:
            done[source] = check_file(source, template)
        except KinemarkError as error:
            if len(sources) == 1:
                raise
            done[source] = error
    return done


def _of_swap(one: Exchanged, swapped: Sequence[SideSwap]) -> bool:
    """Whether an exchange is part of a swap of sides at the same time."""
    names = {
        frozenset(pair) for swap in swapped if swap.first < one.stop and one.first < swap.stop for pair in swap.pairs
    }
    return any(set(one.markers) & pair for pair in names)


def _share(frames: dict[str, Ints], trial: Trajectories, own: Template) -> float:
    """Of the samples that have names of the template, those in these frames."""
    seen = {name: np.flatnonzero(trial[name].origin != Origin.MISSING) for name in own.names if name in trial.names}
    some = sum(int(np.isin(seen[name], those).sum()) for name, those in frames.items())
    return some / max(1, sum(len(each) for each in seen.values()))


def _holds(trial: Trajectories, own: Template, besides: dict[str, Ints]) -> float:
    """Of the stiffest distances of named markers, the share that holds; 1 where nothing is left to judge.

    Args:
        besides: marker → frames in which its sides are swapped, which is another fault.
    """
    kept = trial.select([name for name in own.names if name in trial.names])
    kept = replace(kept, paths=tuple(_without(path, besides.get(path.name)) for path in kept))
    kept = replace(kept, paths=tuple(path for path in kept if np.isfinite(path.xyz).any()))
    if len(kept) < FEWEST:
        return 1.0
    label = np.array([own.names.index(name) for name in kept.names])
    return held(stretches_of(kept, own.size), label, PairScore.of_template(own), absent_too=False)


def _without(path: MarkerTrajectory, frames: Ints | None) -> MarkerTrajectory:
    """Without its samples in these frames."""
    if frames is None:
        return path
    xyz = path.xyz.copy()
    xyz[frames] = np.nan
    return MarkerTrajectory.measured(path.name, xyz)


def _frames(found: Sequence[Exchanged | SideSwap | Mislabelled]) -> dict[str, Ints]:
    """Of each marker, the frames in which its name is found to be wrong."""
    out: dict[str, Ints] = {}
    for one in found:
        for name in _markers(one):
            out[name] = np.union1d(out.get(name, np.zeros(0, np.int64)), np.arange(one.first, one.stop))
    return out


def _markers(one: Exchanged | SideSwap | Mislabelled) -> Sequence[str]:
    """That it is about."""
    if isinstance(one, Mislabelled):
        return (one.marker,)
    return one.markers if isinstance(one, Exchanged) else [name for pair in one.pairs for name in pair]


def check_figures(found: CheckedNames) -> dict[str, Any]:
    """For a machine: frames count as the file does, both included."""
    return {
        "good": found.good,
        "off_share": round(found.off_share, 3),
        "exchanged": [
            {"markers": list(one.markers), "frames": _span(one, found), "nats_a_frame": round(one.gain, 1)}
            for one in found.exchanged
        ],
        "sides_swapped": [
            {
                "pairs": [list(pair) for pair in one.pairs],
                "frames": _span(one, found),
                "nats_a_frame": round(one.gain, 1),
                "off_mm": _number(one.off_mm),
                "off_swapped_mm": _number(one.off_swapped_mm),
            }
            for one in found.swapped
        ],
        "mislabelled": [
            {
                "marker": one.marker,
                "frames": _span(one, found),
                "nats_a_frame": round(one.evidence, 1),
                "expected_nats_a_frame": round(one.expected, 1),
                "off_mm": _number(one.off_mm),
                "instead": one.instead,
            }
            for one in found.mislabelled
        ],
    }


def _span(one: Exchanged | SideSwap | Mislabelled, found: CheckedNames) -> list[int]:
    return [one.first + found.first_frame, one.stop - 1 + found.first_frame]


def _number(mm: float) -> float | None:
    return round(mm, 1) if np.isfinite(mm) else None


def check_text(source: Path, found: CheckedNames) -> str:
    """A line for each."""
    if found.good:
        return f"{source}: no wrong names"
    lines = []
    for one in found.exchanged:
        lines.append(
            f"{' and '.join(one.markers)} are exchanged in frames {_frames_text(one, found)}: the other way round fits "
            f"better by {one.gain:.0f} nats a frame"
        )
    for swap in found.swapped:
        off = f", where their distances are off by {swap.off_swapped_mm:.0f} mm and not {swap.off_mm:.0f} mm"
        lines.append(
            f"left and right are swapped in frames {_frames_text(swap, found)} of "
            f"{', '.join('/'.join(pair) for pair in swap.pairs)}: the other way round fits better by {swap.gain:.0f} "
            f"nats a frame{off if np.isfinite(swap.off_mm) else ''}"
        )
    for wrong in found.mislabelled:
        other = f"it fits {wrong.instead}" if wrong.instead else "it fits no name that is free"
        lines.append(
            f"{wrong.marker} is not {wrong.marker} in frames {_frames_text(wrong, found)}: its distances are off by "
            f"{wrong.off_mm:.0f} mm, {wrong.evidence:.0f} nats a frame where {wrong.expected:.0f} are expected; {other}"
        )
    return "\n".join(f"{source}: {line}" for line in lines)


def _frames_text(one: Exchanged | SideSwap | Mislabelled, found: CheckedNames) -> str:
    first, last = _span(one, found)
    return f"{first}–{last}"
