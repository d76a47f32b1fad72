"""Problems that names show: markers exchanged, left and right, stretches that are called what they are not.

What a labelled trial's names say is judged by the subject's template, as `kinemark label --check` does; where there is
none, by what the trial itself is like for most of its time.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import lru_cache

import numpy as np

from ...data import KinemarkError, MarkerTrajectory, Trajectories
from ...data.edits import Edit, is_named
from ...data.marker_sides import sides_by_name
from ...data.problems import Problem, ProblemKind
from ...edit.probable_errors import name_probability
from ...label import Exchanged, Mislabelled, SideSwap, Template
from ...report.words.problems import problem_text
from ..naming.check_files import CheckedNames, check_by_itself, check_names
from ..naming.subject_templates import without_prefix
from .context import VERSIONS, Context

LEAST_MARKERS = 6
"""Named markers with which a trial can tell what it is itself like; chosen: fewer have no shape."""
LEAST_S = 3.0
"""s of a trial that can; chosen: its errors must not be most of it."""
OFF_MM = 20.0
"""mm that samples of another marker are off, where distances do not tell; chosen, as filling may be."""


def of_names(context: Context, template: Template | None) -> Iterator[Problem]:
    """All of them; none where neither a template nor the trial itself can tell.

    Raises:
        KinemarkError: the template does not fit the names, or has too few of them, so that none can be judged by it.
    """
    checked = _checked(context, template)
    if checked is None:
        return
    if template is not None and checked.unfit:
        raise KinemarkError(checked.unfit)
    for one in checked.exchanged:
        yield _problem(context, "swap", one.markers, one, one.gain)
    for swap in checked.swapped:
        yield _problem(context, "sides", [name for pair in swap.pairs for name in pair], swap, swap.gain)
    for wrong in checked.mislabelled:
        yield _problem(context, "label", (wrong.marker,), wrong, -wrong.evidence)


def _checked(context: Context, template: Template | None) -> CheckedNames | None:
    """What the check of names says; None where it cannot."""
    now = context.now
    named = tuple(path for path in now if is_named(path.name) and path.name not in context.computed)
    return _checked_names(named, now.rate, now.first_frame, template)


@lru_cache(maxsize=VERSIONS)
def _checked_names(
    some: tuple[MarkerTrajectory, ...], rate: float, first_frame: int, template: Template | None
) -> CheckedNames | None:
    """Of named markers; edits of tracks without names, verdicts and choices leave them the same records."""
    named = Trajectories(some, rate, first_frame)
    if template is None and (len(named) < LEAST_MARKERS or named.n_frames < LEAST_S * named.rate):
        return None
    try:
        if template is not None:
            return check_names(without_prefix(named, template.names), template, sides_by_name(template.names))
        return check_by_itself(named, sides_by_name(named.names))
    except KinemarkError:
        if template is not None and len(named):
            raise
        return None


def _problem(
    context: Context, kind: ProblemKind, tracks: Sequence[str], found: Exchanged | SideSwap | Mislabelled, nats: float
) -> Problem:
    """One stretch."""
    names = context.now.names
    who = [next(k for k, name in enumerate(names) if name == one or name.endswith(f":{one}")) for one in tracks]
    tracks = tuple(names[k] for k in who)
    first, last = found.first + context.start, found.stop - 1 + context.start
    span = found.first, found.stop - 1
    n = sum(int(((own := context.samples(k)) >= span[0]).sum() - (own > span[1]).sum()) for k in who)
    wrong = name_probability(kind, nats, (found.stop - found.first) / context.now.rate)
    mm = context.apart(who[0], who[1]) if len(who) > 1 else getattr(found, "off_mm", OFF_MM)
    mm = mm if np.isfinite(mm) else OFF_MM
    no = context.verdict(kind, who, *span, right=False)
    keep = context.alternative(
        "keep", tracks, first, 1 - wrong, wrong * n * mm, [context.verdict(kind, who, *span, right=True)]
    )
    turned = [*who[1::2], *who[::2]] if kind == "sides" else who[::-1]
    pairs = zip([*who[::2], *who[1::2]] if kind == "sides" else who, turned, strict=True)
    instead = getattr(found, "instead", None)
    if kind == "label":
        edits: list[Edit] = [*context.claim(who[0], instead, *span), no]
        act = context.alternative(
            "rename" if instead else "no_marker", tracks, first, wrong, (1 - wrong) * n * mm, edits, name=instead or ""
        )
    else:
        edits = [*(claim for a, b in pairs for claim in context.claim(a, names[b], *span)), no]
        act = context.alternative("exchange", tracks, first, wrong, (1 - wrong) * n * mm, edits)
    words = problem_text(kind, tracks, first, last, mm if kind == "label" else float("nan"))
    ways = tuple(sorted((keep, act), key=lambda one: one.cost))
    return Problem(
        context.id(kind, who[0], found.first), kind, tracks, first, last, (first + last) // 2, wrong, n, wrong * n * mm,
        words, ways, {"nats_a_frame": float(nats)},
    )  # fmt: skip
