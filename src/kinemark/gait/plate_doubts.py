"""Force plates that cannot be as the file says: pressure beside the foot, another weight, another time.

Corners in another order, moments in another unit and plates that were moved or started late leave a force that looks
right, and moments that are not. Of a contact that counts, with the toe t, the foot's axis f from heel to toe while it
stands, of length 1 foot, and the centre of pressure p under at least `LOADED` of the greatest force,

    a = 1 + (p − t) · f,   b = (p − t) · (z × f)                                                              (1)

the toe since it stays with the floor to the end, be that a belt. f is level, and its unit is the way from heel to toe,
which a raised heel does not shorten.

b stays below the foot, also where that bears on its edge; a stick on the same plate takes it away for as long as it
stands there. a goes forward from the first fifth of the contact to the
last (2). Feet that strike with the toes, or bear on the heel alone, have little of that, so a plate is doubted where
the pressure goes backward, or hardly moves at all. The contacts' impulses weigh the body (`estimated_measures`), and
events from markers and plates are at one time (3). A channel that stands still where it is farthest from its rest, and
moves in fine steps elsewhere, is at the limit of its amplifier (4).

A plate on which no foot ever is, and which is loaded from when a foot strikes till it leaves, is where that foot is,
and not where its corners say (5). Its sensors are some centimetres off the surface, and between its edges (6).

The force on a foot that stands points towards the body. With d from the middle of the foot to the pelvis, level, as a
share of the height between them, and f the force's level part as a share of the vertical one,

    c = Σ d f / √(Σ d² Σ f²)                                                                                  (7)

of their components along the way in which the pelvis goes over the foot, and square to it, tell of a plate that is
mirrored or turned, whatever its centre of pressure.

A plate whose file states no unit of force, which rests for a part of the time and then bears up to a few of that unit,
bears persons in kN (8): in N it would never be loaded.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from typing import Literal, NamedTuple

import numpy as np

from ..data import Analog, ForcePlate
from ..data.array_types import Floats
from ..data.strides import FootEvent
from ..data.subject_measures import LETTER, SIDES
from .plate_contacts import Contact
from .reaction import THRESHOLD_N, Reaction, plate_axes
from .segments import Z_UP, along_floor, unit

LOADED = 0.2
"""Of a contact's greatest force, from which (1) counts; chosen: less says little of where it acts."""
BESIDE = 0.25
"""|b| of (1) in feet, to one side for a fifth of the contact; chosen: the edge of a foot is at 0.25 to 0.3. In 14
contacts of three children it was up to 0.16, in 10 of four others up to 0.10, on stairs 0.15."""
STILL = 0.15
"""Way of (2), and reach of a, in feet; chosen: in the same contacts they were 0.41 and 0.55 at least."""
WEIGHT_SHARE = 0.15
"""Difference of the body's weight by plates from the stated one; chosen: in nine public walks it was up to 0.06."""
WEIGHT_OF_ONE_SIDE = 0.35
"""The same where feet of one side alone were weighed; chosen: persons who spare a leg load it by a fifth less."""
LATE_S = 0.03
"""Mean of (3), s; chosen: in 33 public events single ones were up to 0.013."""
LATE_SHARE = 0.03
"""The same of a stride, where that is more; chosen: slow feet strike and leave over a longer time."""
ALIKE_S = 0.15
"""Within which an event from markers and one from a plate are the same, s; chosen: less than half a step."""

FINE = 100
"""Steps between rest and limit from which (4) tells; chosen: coarser channels stand still on their peaks as well."""
CUT_SHARE = 0.1
"""Of the samples under load at the limit (4); chosen: in 38 public files with plates it was up to 0.043."""
CUT_SAMPLES = 10
"""So many are at the limit (4) at least; chosen: a plate on which nobody steps has a few samples of noise."""
CARRYING = {1: slice(2, 3), 2: slice(2, 5), 3: slice(4, 8), 4: slice(2, 5), 5: slice(0, 8)}
"""Channels that carry the weight, by the type of plate; of the file format. Others are far from their limits."""

DEPTH_MM = (2.0, 500.0)
"""How far (6) sensors are off the surface, mm, where that is stated; chosen: of 20 public plates 16 to 101."""

VERTICAL = {1: slice(2, 3), 2: slice(2, 3), 3: slice(4, 8)}
"""Channels whose sum is the vertical force, by the type of plate; of the file format. Others need a matrix."""
IN_KN = (0.1, 4.0)
"""Greatest vertical force (8), kN; chosen: of a child of 10 kg, and of 140 kg that run."""
AT_REST = (0.02, 0.1)
"""Share of that force within which a plate rests (8), and share of the samples that do; chosen: of mere noise hardly
a hundredth lies there."""
TOWARDS = (0.3, -0.5)
"""c of (7) along the way and square to it, below which a plate is doubted; chosen: in 24 contacts of 14 public walks
and turns the least were 0.72 and −0.05."""
PELVIS = ("LASI", "RASI", "SACR", "LPSI", "RPSI")
"""Markers whose mean stands for the body in (7); conventional."""

PlateFault = Literal["beside", "backward", "askew", "weight", "time", "saturated", "elsewhere", "origin", "unit"]


class PlateDoubt(NamedTuple):
    """Of a plate, counted from 0, or of all (None): what is wrong, and by how much: feet, share, s or mm."""

    plate: int | None
    what: PlateFault
    value: float


def plate_doubts(
    reactions: Sequence[Reaction], contacts: Sequence[Contact], points: Mapping[str, Floats]
) -> tuple[PlateDoubt, ...]:
    """Contacts that count and whose pressure or force cannot be the foot's, by (1), (2), (7); of each plate the worst.

    Args:
        reactions: of the plates over F frames. contacts: on them. points: (F, 3) mm by the model's names.
    """
    found: dict[tuple[int, PlateFault], float] = {}
    for one in contacts:
        if one.side is None or one.reason:
            continue
        for what, value in _of_contact(reactions[one.plate], one, points):
            found[one.plate, what] = max(found.get((one.plate, what), value), value, key=abs)
    return tuple(PlateDoubt(plate, what, value) for (plate, what), value in found.items())


def weight_doubts(by_plates: float | None, stated: float | None, contacts: Sequence[Contact]) -> tuple[PlateDoubt, ...]:
    """Whether the mass by plates, kg, is the stated one; nothing where either is unknown.

    Args:
        by_plates, stated: kg. contacts: by which it was weighed, and others.
    """
    share = by_plates / stated - 1 if by_plates and stated else 0.0
    sides = {one.side for one in contacts if one.side is not None and not one.reason}
    most = WEIGHT_SHARE if len(sides) > 1 else WEIGHT_OF_ONE_SIDE
    return (PlateDoubt(None, "weight", share),) if abs(share) > most else ()


def time_doubts(seen: Sequence[FootEvent], measured: Sequence[FootEvent]) -> tuple[PlateDoubt, ...]:
    """Whether the plates are late (or early, below 0) by (3), of strikes and of offs alike.

    Args:
        seen: events from markers. measured: from plates.
    """
    late = {
        strike: [p.time - m.time for p in measured for m in seen if _same(p, m, strike)] for strike in (True, False)
    }
    means = [float(np.mean(times)) for times in late.values() if times]
    strides = [b.time - a.time for side in SIDES for a, b in pairwise(e for e in seen if e.strike and e.side == side)]
    least = max(LATE_S, LATE_SHARE * float(np.median(strides))) if strides else LATE_S
    alike = len(means) == 2 and np.ptp(means) < LATE_S and min(map(abs, means)) > least
    return (PlateDoubt(None, "time", float(np.mean(means))),) if alike else ()


def place_doubts(
    plates: Sequence[ForcePlate], contacts: Sequence[Contact], seen: Sequence[FootEvent], *, rate: float
) -> tuple[PlateDoubt, ...]:
    """Plates that are elsewhere by (5), with mm to the foot that stood when they were loaded, or whose sensors cannot
    be where their origin is by (6), with mm off the surface or the middle; of each plate one.

    Args:
        plates: of the trial. contacts: on them. seen: events from markers. rate: frames a second.
    """
    origins = {k: mm for k, plate in enumerate(plates) if (mm := _origin_off(plate))}
    in_time = sorted(seen, key=lambda event: event.time)
    stands = [(a.time, b.time) for side in SIDES
              for a, b in pairwise(e for e in in_time if e.side == side) if a.strike and not b.strike]  # fmt: skip
    known = {one.plate for one in contacts if one.reason != "no_foot"} | {
        k for k, mm in origins.items() if mm > DEPTH_MM[1]
    }
    away: dict[int, float] = {}
    for one in contacts:
        first, last = one.first / rate, one.stop / rate
        alike = any(max(abs(first - a), abs(last - b)) < ALIKE_S for a, b in stands)
        if one.plate not in known and alike and np.isfinite(one.distance):
            away[one.plate] = min(away.get(one.plate, np.inf), one.distance)
    return (
        *(PlateDoubt(plate, "elsewhere", mm) for plate, mm in away.items()),
        *(PlateDoubt(plate, "origin", mm) for plate, mm in origins.items() if plate not in away),
    )


def _origin_off(plate: ForcePlate) -> float:
    """mm by which its sensors are off the surface or the middle where they cannot be there by (6), else 0."""
    if plate.type not in range(2, 6) or not np.isfinite(plate.corners).all():
        return 0.0
    R, middle = plate_axes(plate.corners)
    half, off = np.abs((plate.corners - middle) @ R[:, :2]).max(0), np.abs(plate.origin)
    if off[2] and not DEPTH_MM[0] <= off[2] <= DEPTH_MM[1]:
        return float(off[2])
    return float(off[:2].max()) if (off[:2] > half).any() else 0.0


def saturation_doubts(plates: Sequence[ForcePlate], analog: Sequence[Analog]) -> tuple[PlateDoubt, ...]:
    """Plates of which a channel is cut off at its limit (4), by the share of the samples under load there."""
    channels = {name: block.values[k] for block in analog for k, name in enumerate(block.names)}
    each = [[name for name in one.channels[CARRYING.get(one.type, slice(0))] if name in channels] for one in plates]
    shares = [max((_cut(channels[name]) for name in names), default=0.0) for names in each]
    return tuple(PlateDoubt(k, "saturated", share) for k, share in enumerate(shares) if share > CUT_SHARE)


def _cut(x: Floats) -> float:
    """Share of a channel's samples (N) under load that are at its limit (4); 0 where it is too coarse to tell."""
    x = x[np.isfinite(x)]
    steps = np.diff(np.unique(x))
    if not len(steps):
        return 0.0
    unloaded = (x == 0).sum() >= CUT_SAMPLES  # by a threshold of its program; belts are loaded most of the time
    away = np.abs(x - (0.0 if unloaded else np.median(x)))
    under = away > LOADED * away.max()
    there = int((x == x[away.argmax()]).sum())
    return there / int(under.sum()) if there >= CUT_SAMPLES and away.max() >= FINE * steps.min() else 0.0


def unit_doubts(plates: Sequence[ForcePlate], analog: Sequence[Analog]) -> tuple[PlateDoubt, ...]:
    """Plates without a stated unit of force that are loaded in kN by (8), with their force in N as a share of the least
    load."""
    found = []
    for k, plate in enumerate(plates):
        names = plate.channels[VERTICAL.get(plate.type, slice(0))]
        block = next((one for one in analog if names and {*names} <= {*one.names}), None)
        if block is None or any(block.units[block.names.index(name)].strip() for name in names):
            continue
        force = np.sum([block[name] for name in names], axis=0)
        force = np.sort(force[np.isfinite(force)])
        most = float(np.ptp(force)) if len(force) else 0.0
        near = AT_REST[0] * most
        resting = max((force < force[0] + near).mean(), (force > force[-1] - near).mean()) if most else 0.0
        if IN_KN[0] < most < IN_KN[1] and resting > AT_REST[1]:
            found.append(PlateDoubt(k, "unit", most / THRESHOLD_N))
    return tuple(found)


def _same(plate: FootEvent, marker: FootEvent, strike: bool) -> bool:
    return (
        plate.strike == marker.strike == strike
        and plate.side == marker.side
        and abs(plate.time - marker.time) < ALIKE_S
    )


def _of_contact(
    reaction: Reaction, contact: Contact, points: Mapping[str, Floats]
) -> Iterator[tuple[PlateFault, float]]:
    """By (1) and (2)."""
    a, b = _in_feet(reaction, contact, points)
    fifth = len(a) // 5
    if not fifth:
        return
    forward = float(a[-fifth:].mean() - a[:fifth].mean())
    if abs(aside := max((_lasting(b, fifth), -_lasting(-b, fifth)), key=abs)) > BESIDE:
        yield "beside", aside
    elif forward < -STILL or (forward < STILL and np.ptp(a) < STILL):
        yield "backward", forward
    elif askew := [c for c, least in zip(_towards_body(reaction, contact, points), TOWARDS, strict=True) if c < least]:
        yield "askew", min(askew)


def _lasting(b: Floats, n: int) -> float:
    """The most that b (N) stays above for n samples on end."""
    return float(np.lib.stride_tricks.sliding_window_view(b, n).min(axis=1).max())


def _towards_body(reaction: Reaction, contact: Contact, points: Mapping[str, Floats]) -> tuple[float, float]:
    """(7) over the loaded frames of a contact; 1 where too little is seen."""
    frames, letter = slice(contact.first, contact.stop), LETTER[contact.side or "left"]
    pelvis = [points[name][frames] for name in PELVIS if name in points]
    if not pelvis:
        return 1.0, 1.0
    d = np.mean(pelvis, axis=0) - (points[letter + "HEE"] + points[letter + "TOE"])[frames] / 2
    force = reaction.force[frames]
    on = np.isfinite(d + force).all(1) & (force @ Z_UP > LOADED * np.nanmax(force @ Z_UP, initial=0.0))
    if on.sum() < 2:
        return 1.0, 1.0
    d, f = (v[on] / (v[on] @ Z_UP)[:, None] - Z_UP for v in (d, force))
    way = unit(d[-1] - d[0])
    return _cosine(d @ way, f @ way), _cosine(d @ np.cross(Z_UP, way), f @ np.cross(Z_UP, way))


def _cosine(a: Floats, b: Floats) -> float:
    """Of two columns (n); 1 where one is zero."""
    size = float(np.sqrt((a @ a) * (b @ b)))
    return float(a @ b) / size if size > 0 else 1.0


def _in_feet(reaction: Reaction, contact: Contact, points: Mapping[str, Floats]) -> tuple[Floats, Floats]:
    """(n) of (1) over the loaded frames of a contact; empty where the foot is not seen."""
    frames, letter = slice(contact.first, contact.stop), LETTER[contact.side or "left"]
    heel, toe = (points[letter + name][frames] for name in ("HEE", "TOE"))
    n = len(heel)
    stands = np.isfinite(heel + toe).all(1) & (np.arange(n) >= n // 4) & (np.arange(n) <= n // 2)
    force, centre = np.abs(reaction.force[frames] @ Z_UP), reaction.centre[frames]
    on = np.isfinite(centre + toe).all(1) & (force > LOADED * np.nanmax(force, initial=0.0))
    if not stands.any() or not on.any():
        return np.zeros(0), np.zeros(0)
    f = np.median((toe - heel)[stands], axis=0)
    foot, f = max(float(np.linalg.norm(f)), 1e-300), unit(along_floor(f))
    off = (centre - toe)[on]
    return 1 + off @ f / foot, off @ np.cross(Z_UP, f) / foot
