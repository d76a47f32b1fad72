"""What of a walk cannot be as its file says: names of markers, and plates; and feet that it took otherwise."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from ...data import Origin, Trial
from ...data.array_types import Floats
from ...data.marker_sides import without_subject
from ...data.model_markers import MODEL_MARKERS
from ...data.strides import FootEvent
from ...gait.estimated_measures import mass_on_plates
from ...gait.foot_events import marker_events
from ...gait.gait_trial import GaitTrial
from ...gait.marker_doubts import MarkerDoubts, marker_doubts
from ...gait.marker_leaps import MarkerLeaps, marker_leaps
from ...gait.plate_doubts import (
    PlateDoubt,
    place_doubts,
    plate_doubts,
    saturation_doubts,
    time_doubts,
    unit_doubts,
    weight_doubts,
)
from ...gait.static_checks import FeetTaken, feet_taken
from ...io.c3d.subject_measures import measures_of


def feet_otherwise(static: Trial, points: Mapping[str, Floats], *, flat_foot: bool) -> FeetTaken | None:
    """How the standing trial's own program took the feet, where it is the other way.

    Args:
        static: as it was read. points: (F, 3) mm by the model's names. flat_foot: how they are taken here.
    """
    stated = measures_of(static.source)
    if stated is None or stated.left.plantar_offset_deg is None or stated.right.plantar_offset_deg is None:
        return None
    taken = feet_taken(stated, points)
    return None if taken is None or taken.flat == flat_foot else taken


def doubted_markers(trial: Trial, points: Mapping[str, Floats]) -> tuple[MarkerDoubts, MarkerLeaps]:
    """What of the names of a trial's markers cannot be, and their leaps.

    Args:
        trial: by the model's names. points: (F, 3) mm of its markers.
    """
    worn = worn_points(trial, points)
    leaps = marker_leaps(points, tuple(n for n in MODEL_MARKERS if n in worn), rate=trial.trajectories.rate)
    return marker_doubts(worn), leaps


def worn_points(trial: Trial, points: Mapping[str, Floats]) -> dict[str, Floats]:
    """Those of the points (F, 3) mm by the model's names that markers of the trial have shown."""
    worn = {without_subject(p.name) for p in trial.trajectories if (p.origin == Origin.MEASURED).any()}
    return {name: xyz for name, xyz in points.items() if name in worn}


def doubted_plates(
    trial: Trial, points: Mapping[str, Floats], gait: GaitTrial, events: Sequence[FootEvent], way: str,
    mass_kg: float | None,
) -> tuple[PlateDoubt, ...]:  # fmt: skip
    """What of the plates of a walk on a level floor cannot be; nothing of runs and stairs.

    Args:
        trial: with named markers. points: (F, 3) mm. gait, events, way: of it. mass_kg: of the body, as stated.
    """
    if way != "level" or not gait.reactions:
        return ()
    rate = trial.trajectories.rate
    weighed = mass_on_plates(gait.reactions, gait.contacts, events, rate=rate)
    measured = [event for event in events if event.source == "plate"]
    seen = marker_events(points, rate)
    late = time_doubts(seen, measured) if measured else ()
    return (
        *plate_doubts(gait.reactions, gait.contacts, points),
        *weight_doubts(weighed, mass_kg, gait.contacts),
        *late,
        *place_doubts(trial.plates, gait.contacts, seen, rate=rate),
        *saturation_doubts(trial.plates, trial.analog),
        *unit_doubts(trial.plates, trial.analog),
    )
