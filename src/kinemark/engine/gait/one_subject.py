"""The markers of one subject, in a file that has those of several, as `A:LASI` and `B:LASI`."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace

from ...data import KinemarkError, Trial
from ...data.model_markers import model_names


def of_one_subject(trial: Trial, subject: str, stated: Collection[str] = ()) -> Trial:
    """The trial without the markers of other subjects; the same trial where it has one subject.

    Args:
        trial: with named markers. subject: as it stands before the markers' names; empty where nobody says.
        stated: names of the model's markers for which somebody says which marker they are.

    Raises:
        KinemarkError: several subjects wear a marker of the model, and nobody says whose gait is wanted.
    """
    names = trial.trajectories.names
    each = {prefix: [name for name in names if _prefix(name) == prefix] for prefix in map(_prefix, names)}
    known = {prefix: set(model_names(own)) - set(stated) for prefix, own in each.items()}
    several = [one for one in each if any(known[one] & known[other] for other in each if other != one)]
    if not several:
        return trial
    chosen = next((one for one in several if one.casefold() == subject.casefold()), None) if subject else None
    if chosen is None:
        there = ", ".join(one or "one without a name" for one in several)
        missing = f"{subject!r} is none of them. " if subject else ""
        raise KinemarkError(
            f"The markers of {len(several)} subjects are there: {there}. {missing}Say whose gait is wanted: "
            f'--subject {several[-1]}, in a session under [gait], subject = "{several[-1]}".'
        )
    others = {name for one in several if one != chosen for name in each[one]}
    kept = tuple(path for path in trial.trajectories if path.name not in others)
    return replace(trial, trajectories=replace(trial.trajectories, paths=kept))


def _prefix(name: str) -> str:
    """The subject that a marker's name begins with; empty where it begins with none."""
    return name.rpartition(":")[0]
