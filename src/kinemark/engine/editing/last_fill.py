"""The fills of the last run of a trial, whatever was said since: they stand in gaps that are still the same."""

from __future__ import annotations

import json

from ...data import Fills, KinemarkError, Trajectories
from ...fill import Filled, FilledGap
from ...io.records import load
from ..open_trial import OpenTrial
from ..store import Store
from ..trial_inputs import with_placed


def last_filled(trial: OpenTrial, measured: Trajectories) -> Filled | None:
    """The trajectories and gaps as the last run filled them; None where it did not, or what it left is damaged.

    Args:
        trial: of a session. measured: its trajectories before all edits.
    """
    done = Store.read(trial.folder).old
    if "fill" not in done:
        return None
    try:
        fills = load(trial.folder / "fills.h5")
        before = load(trial.folder / "edited.h5") if "edit" in done else measured
        if not isinstance(fills, Fills) or not isinstance(before, Trajectories):
            return None
        gaps = tuple(FilledGap(**json.loads(text)) for text in fills.gaps)
        return Filled(fills.on(with_placed(before, gaps)), gaps)
    except (KinemarkError, ValueError, TypeError):  # of another processing, or another version
        return None
