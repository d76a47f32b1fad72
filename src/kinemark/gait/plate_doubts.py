"""Force plates that cannot be as the file says: pressure beside the foot, another weight, another time.

Corners in another order, moments in another unit and plates that were moved or started late leave a force that looks
right, and moments that are not. Of a contact that counts, with the toe t, the foot's axis f from heel to toe while it
stands, of length 1 foot, and the centre of pressure p under at least `LOADED` of the greatest force,

    a = 1 + (p − t) · f,   b = (p − t) · (z × f)                                                              (1)

the toe since it stays with the floor to the end, be that a belt.

b stays small, and a goes forward from the first fifth of the contact to the last (2). The contact's impulse weighs the
body (`estimated_measures`), and events from markers and plates are at one time (3).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Literal, NamedTuple

import numpy as np

from ..data.array_types import Floats
from ..data.strides import FootEvent
from ..data.subject_measures import LETTER
from .plate_contacts import Contact
from .reaction import Reaction
from .segments import Z_UP

LOADED = 0.2
"""Of a contact's greatest force, from which (1) counts; chosen: less says little of where it acts."""
BESIDE = 0.25
"""b of (1) in feet, in the median; chosen: in 23 contacts of nine public walks it was up to 0.09."""
FORWARD = 0.15
"""Least way of (2) in feet; chosen: in the same contacts it was 0.45 and more, and less is left for feet that
stand on their toes."""
WEIGHT_SHARE = 0.15
"""Difference of the body's weight by plates from the stated one; chosen: in nine public walks it was up to 0.06."""
LATE_S = 0.03
"""Mean of (3), s; chosen: in 33 public events single ones were up to 0.013."""
ALIKE_S = 0.15
"""Within which an event from markers and one from a plate are the same, s; chosen: less than half a step."""

PlateFault = Literal["beside", "backward", "weight", "time"]


class PlateDoubt(NamedTuple):
    """Of a plate, counted from 0, or of all (None): what is wrong, and by how much: feet, feet, share or s."""

    plate: int | None
    what: PlateFault
    value: float


def plate_doubts(
    reactions: Sequence[Reaction], contacts: Sequence[Contact], points: Mapping[str, Floats], *, up: Floats = Z_UP
) -> tuple[PlateDoubt, ...]:
    """Contacts that count and whose pressure cannot be the foot's, by (1) and (2); of each plate the worst.

    Args:
        reactions: of the plates over F frames. contacts: on them. points: (F, 3) mm by the model's names.
        up: of the laboratory.
    """
    found: dict[tuple[int, PlateFault], float] = {}
    for one in contacts:
        if one.side is None or one.reason:
            continue
        for what, value in _of_contact(reactions[one.plate], one, points, up):
            found[one.plate, what] = max(found.get((one.plate, what), value), value, key=abs)
    return tuple(PlateDoubt(plate, what, value) for (plate, what), value in found.items())


def weight_doubts(by_plates: float | None, stated: float | None) -> tuple[PlateDoubt, ...]:
    """Whether the mass by plates, kg, is the stated one; nothing where either is unknown."""
    share = by_plates / stated - 1 if by_plates and stated else 0.0
    return (PlateDoubt(None, "weight", share),) if abs(share) > WEIGHT_SHARE else ()


def time_doubts(seen: Sequence[FootEvent], measured: Sequence[FootEvent]) -> tuple[PlateDoubt, ...]:
    """Whether the plates are late (or early, below 0) by (3), of strikes and of offs alike.

    Args:
        seen: events from markers. measured: from plates.
    """
    late = {
        strike: [p.time - m.time for p in measured for m in seen if _same(p, m, strike)] for strike in (True, False)
    }
    means = [float(np.mean(times)) for times in late.values() if times]
    alike = len(means) == 2 and np.ptp(means) < LATE_S and min(map(abs, means)) > LATE_S
    return (PlateDoubt(None, "time", float(np.mean(means))),) if alike else ()


def _same(plate: FootEvent, marker: FootEvent, strike: bool) -> bool:
    return (
        plate.strike == marker.strike == strike
        and plate.side == marker.side
        and abs(plate.time - marker.time) < ALIKE_S
    )


def _of_contact(
    reaction: Reaction, contact: Contact, points: Mapping[str, Floats], up: Floats
) -> Iterator[tuple[PlateFault, float]]:
    """By (1) and (2)."""
    a, b = _in_feet(reaction, contact, points, up)
    fifth = len(a) // 5
    if not fifth:
        return
    forward = float(a[-fifth:].mean() - a[:fifth].mean())
    if abs(aside := float(np.median(b))) > BESIDE:
        yield "beside", aside
    elif forward < FORWARD:
        yield "backward", forward


def _in_feet(reaction: Reaction, contact: Contact, points: Mapping[str, Floats], up: Floats) -> tuple[Floats, Floats]:
    """(n) of (1) over the loaded frames of a contact; empty where the foot is not seen."""
    frames, letter = slice(contact.first, contact.stop), LETTER[contact.side or "left"]
    heel, toe = (points[letter + name][frames] for name in ("HEE", "TOE"))
    n = len(heel)
    stands = np.isfinite(heel + toe).all(1) & (np.arange(n) >= n // 4) & (np.arange(n) <= n // 2)
    force, centre = np.abs(reaction.force[frames] @ up), reaction.centre[frames]
    on = np.isfinite(centre + toe).all(1) & (force > LOADED * np.nanmax(force, initial=0.0))
    if not stands.any() or not on.any():
        return np.zeros(0), np.zeros(0)
    f = np.median((toe - heel)[stands], axis=0)
    f = f - (f @ up) * up
    foot = max(float(f @ f), 1e-300)
    off = (centre - toe)[on]
    return 1 + off @ f / foot, off @ np.cross(up, f) / foot
