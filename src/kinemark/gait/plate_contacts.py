"""Which foot stood on which plate, and whether it stood there alone and whole.

While a plate is loaded from frame a to b, the distance of a foot is that of the middle m of its heel and toe from the
centre of pressure p, on the floor, weighted by the force:

    d = Σ F_z |p − m| / Σ F_z                                                                          (1)

The near foot has stepped there. A contact does not count where both feet are as near, the other foot stands on the
plate too, a heel or toe of the standing foot is beside the plate, what the plate recorded begins or ends within it, or
the plate is loaded while the toe swings: then something else stands there, as a stick or a walker (2). Nor does it
where the foot rolls from one plate to another: another plate is loaded meanwhile or at once after, by a share of the
impulse, and the pressure there is nearer to the standing foot than to the other (3). Where the other is not seen, it
may be what stands there, and the pressure must be as near as that of a foot's own plate.

What plates below one foot do to it adds up. So a step on several counts where the foot alone is on each, whole on all
of them together, each carries a share of the impulse, and the pressure on each is below the foot: with a along the foot
from heel to toe and b beside it, in its lengths, −0.3 < a < 1.5 and |b| < 0.4 in the mean over the force (4).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from ..data.array_types import Bools, Floats
from ..data.subject_measures import LETTER, SIDES, Side
from ..numerics.finite import finite_median
from ..numerics.runs import true_runs
from .reaction import Reaction, plate_axes
from .segments import Z_UP, along_floor

SHORTEST_S = 0.1
"""Of a contact, s; chosen: shorter loads are knocks."""
BRIDGED_S = 0.03
"""Unloaded time within a contact, s; chosen: heel and forefoot of a light step."""
NEAR_FEET = 0.8
"""Distance (1) as a share of the foot's length within which a foot can have stepped there; chosen: the pressure is
below the foot."""
CLEARER = 1.5
"""By which the other foot is farther; chosen: feet of walkers were 4 to 20 times as far."""
STANDING_MM_S = 400.0
"""Speed of the foot's middle below which it stands, mm/s; chosen: a third of a slow swing's."""
BESIDE_MM = 10.0
"""By which a marker of the standing foot may be beside the plate, mm; chosen: markers stick out of shoes."""
OTHER_SHARE = 0.1
"""Share of the contact during which the other foot stands on the plate; chosen."""
SWINGING_MM_S = 1000.0
"""Speed of the toe, from the floor, beyond which it swings, mm/s; chosen: a toe on the floor reaches 600."""
SWINGING_S = 0.16
"""By which a plate may be loaded while the toe swings, s; chosen: in whole contacts it was up to 0.03,
of simulated ones 0.13."""

SHARED_IMPULSE = 0.05
"""Of a contact's impulse, that a second plate below the same foot carries; chosen: crosstalk between plates is 1 %."""
REACHING_FEET = 1.5
"""Distance (1) as a share of the foot's length at which a second plate is still below it; chosen: a toe's tip is about
one such length from the middle between heel and toe."""
ALONG_FEET = (-0.3, 1.5)
"""a of (4); chosen: the heel's marker is a third before the end of a shoe, the toes reach 0.4 beyond theirs."""
BESIDE_FEET = 0.4
"""|b| of (4); chosen: a foot is 0.3 wide to either side, and sticks stand farther off."""


class Contact(NamedTuple):
    """A load on one plate.

    Attributes:
        plate: its index. first, stop: frames, counted from 0, stop excluded.
        side: of the foot; None where it is not known or the contact does not count.
        reason: why it does not count: "", "unclear", "two_feet", "aid", "beside", "cut", "two_plates",
            "no_foot"; "shared" where it counts together with those of other plates (4).
        distance: (1) of the near foot, mm.
    """

    plate: int
    first: int
    stop: int
    side: Side | None
    reason: str
    distance: float

    @property
    def apart(self) -> Contact:
        """It where plates do not add up."""
        return self._replace(side=None, reason="two_plates") if self.reason == "shared" else self


def contacts(reactions: Sequence[Reaction], points: Mapping[str, Floats], *, rate: float) -> tuple[Contact, ...]:
    """All loads of all plates, in the order of time.

    Args:
        reactions: of the plates over F frames.
        points: (F, 3) mm, with LHEE, LTOE, RHEE and RTOE.
        rate: frames a second.
    """
    feet = {side: _Foot.of(points, side, rate) for side in SIDES}
    judged = [
        _judged(plate, reaction, first, stop, feet, rate)
        for plate, reaction in enumerate(reactions)
        for first, stop in _loads(reaction.loaded, rate)
    ]
    found = list(judged)
    for k, one in enumerate(judged):
        parts = [j for j, other in enumerate(judged) if _shares(one, other, reactions, feet, rate)]
        if not parts or found[k].reason == "shared":
            continue
        step = [judged[j] for j in (k, *parts)]
        if _adds_up(step, reactions, feet):
            for j in (k, *parts):
                found[j] = judged[j]._replace(side=one.side, reason="shared")
        else:
            found[k] = one._replace(side=None, reason="two_plates")
    return tuple(sorted(found, key=lambda one: (one.first, one.plate)))


def steps_of(found: Sequence[Contact], rate: float) -> list[list[Contact]]:
    """Contacts that count, those of one step (4) together, in the order of time.

    Args:
        found: on all plates. rate: frames a second.
    """
    steps: list[list[Contact]] = []
    for one in sorted(found, key=lambda one: one.first):
        if one.side is None or one.reason not in ("", "shared"):
            continue
        for step in steps if one.reason else ():
            together = one.first - max(c.stop for c in step) <= BRIDGED_S * rate
            if together and (step[0].side, step[0].reason) == (one.side, "shared"):
                step.append(one)
                break
        else:
            steps.append([one])
    return steps


def _loads(loaded: Bools, rate: float) -> list[tuple[int, int]]:
    """Runs of loaded frames, short breaks bridged."""
    bridged = loaded.copy()
    for first, stop in true_runs(~loaded):
        if first > 0 and stop < len(loaded) and stop - first <= BRIDGED_S * rate:
            bridged[first:stop] = True
    return [(int(a), int(b)) for a, b in true_runs(bridged) if b - a >= SHORTEST_S * rate]


class _Foot(NamedTuple):
    """(F, 3) mm heel, toe and the centre between them, mm/s of the toe; (F) whether it stands; mm its length."""

    heel: Floats
    toe: Floats
    toe_v: Floats
    centre: Floats
    stands: Bools
    length: float

    @classmethod
    def of(cls, points: Mapping[str, Floats], side: Side, rate: float) -> _Foot:
        heel, toe = points[LETTER[side] + "HEE"], points[LETTER[side] + "TOE"]
        centre = (heel + toe) / 2
        speed = np.linalg.norm(np.gradient(centre, axis=0), axis=1) * rate if len(centre) > 1 else np.zeros(len(centre))
        length = np.linalg.norm(toe - heel, axis=1)
        toe_v = np.gradient(toe, axis=0) * rate if len(toe) > 1 else np.zeros_like(toe)
        return cls(heel, toe, toe_v, centre, speed < STANDING_MM_S, finite_median(length))


def _judged(plate: int, reaction: Reaction, first: int, stop: int, feet: Mapping[Side, _Foot], rate: float) -> Contact:
    """A load with its foot."""
    distance = {side: _distance(reaction, foot, first, stop) for side, foot in feet.items()}
    near, far = sorted(SIDES, key=lambda side: np.nan_to_num(distance[side], nan=np.inf))
    on = {side: _on_plate(reaction, foot, first, stop).mean() for side, foot in feet.items()}
    d, reason = distance[near], ""
    if min(on.values()) > OTHER_SHARE:
        reason = "two_feet"  # one after the other too, when the pressure of both together is near neither
    elif not d <= NEAR_FEET * feet[near].length:
        reason = "no_foot"
    elif distance[far] < CLEARER * d:
        reason = "unclear"
    elif on[far] > OTHER_SHARE:
        reason = "two_feet"
    elif _swinging(feet[near].toe_v[first:stop]) > SWINGING_S * rate:
        reason = "aid"  # (2)
    elif not _whole([reaction], feet[near], first, stop):
        reason = "beside"
    elif first == 0 or stop == len(reaction.loaded) or reaction.unknown[first - 1] or reaction.unknown[stop]:
        reason = "cut"
    side = None if reason in ("no_foot", "unclear", "two_feet", "aid") else near
    if reason == "no_foot" and np.isfinite(d) and np.isnan(feet[far].length):
        side = far  # whose markers nobody wears
    return Contact(plate, first, stop, side, reason, float(d))


def _shares(
    one: Contact, other: Contact, reactions: Sequence[Reaction], feet: Mapping[Side, _Foot], rate: float
) -> bool:
    """Whether another plate, meanwhile or without a break, carries part of the step of contact `one` (3)."""
    apart = max(one.first, other.first) - min(one.stop, other.stop)
    if one.plate == other.plate or apart > BRIDGED_S * rate or one.side is None:
        return False
    away = {s: _distance(reactions[other.plate], foot, other.first, other.stop) for s, foot in feet.items()}
    near, far = away.pop(one.side), next(iter(away.values()))
    whole, part = (np.abs(reactions[c.plate].force[c.first : c.stop] @ Z_UP).sum() for c in (one, other))
    reach = REACHING_FEET if np.isfinite(far) else NEAR_FEET
    below = near <= reach * feet[one.side].length and not far < CLEARER * near
    return bool(below and part > SHARED_IMPULSE * whole)


def _adds_up(step: Sequence[Contact], reactions: Sequence[Reaction], feet: Mapping[Side, _Foot]) -> bool:
    """Whether the loads of several plates are all of the foot of the first one (4)."""
    if step[0].reason not in ("", "beside") or any(one.reason not in ("", "beside", "no_foot") for one in step):
        return False
    foot = feet[step[0].side or "left"]
    impulse = [np.abs(reactions[one.plate].force[one.first : one.stop] @ Z_UP).sum() for one in step]
    first, stop = min(one.first for one in step), max(one.stop for one in step)
    return bool(
        min(impulse) > SHARED_IMPULSE * max(impulse)
        and all(_below(reactions[one.plate], foot, one.first, one.stop) for one in step)
        and _whole([reactions[one.plate] for one in step], foot, first, stop)
    )


def _below(reaction: Reaction, foot: _Foot, first: int, stop: int) -> bool:
    """Whether the pressure is below the foot (4)."""
    sole = (foot.toe - foot.heel)[first:stop]
    sole = along_floor(sole)
    ahead = sole / np.linalg.norm(sole, axis=1)[:, None]
    off = reaction.centre[first:stop] - foot.heel[first:stop]
    a, b = ((off * axis).sum(1) / foot.length for axis in (ahead, np.cross(Z_UP, ahead)))
    weight = np.abs(reaction.force[first:stop] @ Z_UP)
    seen = np.isfinite(a + b + weight) & (weight > 0)
    if not seen.any():
        return False
    along, aside = (float(weight[seen] @ x[seen] / weight[seen].sum()) for x in (a, b))
    return ALONG_FEET[0] < along < ALONG_FEET[1] and abs(aside) < BESIDE_FEET


def _distance(reaction: Reaction, foot: _Foot, first: int, stop: int) -> float:
    """(1), mm; NaN where the foot is not seen."""
    offset = reaction.centre[first:stop] - foot.centre[first:stop]
    offset = along_floor(offset)
    weight = np.abs(reaction.force[first:stop] @ Z_UP)
    seen = np.isfinite(offset).all(1) & (weight > 0)
    return (
        float((weight[seen] * np.linalg.norm(offset[seen], axis=1)).sum() / weight[seen].sum())
        if seen.any()
        else np.nan
    )


def _inside(reaction: Reaction, xyz: Floats, margin: float) -> Bools:
    """(n) whether points (n, 3) mm are above the plate or within `margin` of it; missing points are not."""
    R, centre = plate_axes(reaction.corners)
    half = np.abs((reaction.corners - centre) @ R[:, :2]).max(0)
    return np.asarray((np.abs((xyz - centre) @ R[:, :2]) <= half + margin).all(1))


def _on_plate(reaction: Reaction, foot: _Foot, first: int, stop: int) -> Bools:
    """(n) whether the foot stands on the plate."""
    return _inside(reaction, foot.centre[first:stop], 0.0) & foot.stands[first:stop]


def _swinging(toe_v: Floats) -> int:
    """Frames of a load in which the toe, with velocities (n, 3), swings; the floor has its median velocity."""
    known = toe_v[np.isfinite(toe_v).all(1)]
    if not len(known):
        return 0
    return int((np.linalg.norm(known - np.median(known, axis=0), axis=1) > SWINGING_MM_S).sum())


def _whole(plates: Sequence[Reaction], foot: _Foot, first: int, stop: int) -> bool:
    """Whether heel and toe are each above one of the plates while the foot stands, most of the time."""
    stands = foot.stands[first:stop]
    if not stands.any():
        return True
    ends = [np.any([_inside(plate, end[first:stop][stands], BESIDE_MM) for plate in plates], axis=0)
            | np.isnan(end[first:stop][stands]).any(1) for end in (foot.heel, foot.toe)]  # fmt: skip
    return bool((ends[0] & ends[1]).mean() > 0.5)
