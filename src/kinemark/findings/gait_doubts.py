"""What is said of markers and plates of a walk that cannot be as the file says."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from ..data import Finding, make_finding
from ..data.subject_measures import SIDES, Side
from ..gait.marker_doubts import MarkerDoubts
from ..gait.marker_leaps import MarkerLeaps
from ..gait.marker_spikes import MarkerSpikes
from ..gait.plate_contacts import Contact
from ..gait.plate_doubts import PlateDoubt
from ..gait.reaction import Reaction

TOLD_N = 10.0
"""Force without a load from which it is told, N; chosen: half of what counts as a load."""


def of_doubts(trial: str, names: MarkerDoubts, leaps: MarkerLeaps) -> Iterator[Finding]:
    """Of the markers of a trial of this name."""
    if leaps.markers:
        yield make_finding(
            "gait_markers_leap", trial=trial, markers=leaps.markers, leaps=leaps.frames, most_mm=leaps.most_mm
        )
    for how, markers in names.exchanged:
        yield make_finding("gait_markers_exchanged", trial=trial, markers=markers, how=how)
    if names.moved:
        pairs, most = [f"{a}–{b}" for a, b, _ in names.moved], max(mm for *_, mm in names.moved)
        yield make_finding("gait_markers_move_apart", trial=trial, pairs_list=pairs, most_mm=most)


def of_plates(trial: str, doubts: Sequence[PlateDoubt], reactions: Sequence[Reaction]) -> Iterator[Finding]:
    """Of the plates of a trial of this name: what cannot be, and which showed a force while nothing stood on them."""
    for doubt in doubts:
        late = 1000 * doubt.value if doubt.what == "time" else None
        away = doubt.value if doubt.what in ("elsewhere", "origin") else None
        share = doubt.value if late is away is None else None
        plate = None if doubt.plate is None else doubt.plate + 1
        yield make_finding(
            "gait_plate_doubtful", trial=trial, plate=plate, what=doubt.what, by_share=share, late_ms=late,
            away_mm=away,
        )  # fmt: skip
    for number, one in enumerate(reactions, 1):
        if one.baseline_n > TOLD_N:
            yield make_finding("gait_plate_zeroed", trial=trial, plate=number, baseline=one.baseline_n)


def of_spikes(trial: str, spikes: MarkerSpikes, first_frame: int) -> Iterator[Finding]:
    """Which samples of a trial of this name, whose first frame has this number, were left out."""
    if spikes.markers:
        yield make_finding(
            "gait_spikes_left_out", trial=trial, markers=spikes.markers, samples=spikes.samples, most_mm=spikes.most_mm,
            frames=[(first + first_frame, last + first_frame) for first, last in spikes.frames],
        )  # fmt: skip


def left_out_for(contact: Contact) -> str | None:
    """Why a contact does not count; None where it does, alone or with others."""
    return None if contact.reason in ("", "shared") else contact.reason


def of_contacts(trial: str, contacts: Sequence[Contact], bare: Side | None, first_frame: int) -> Iterator[Finding]:
    """Of the loads on the plates of a trial of this name: those left out, and those that were added up.

    Args:
        trial: its name. contacts: on its plates. bare: the leg without markers. first_frame: its number.
    """
    for one in contacts:
        if left_out_for(one) and (bare is None or one.reason != "no_foot"):
            yield make_finding(
                "contact_left_out", trial=trial, plate=one.plate + 1, reason=one.reason,
                frames=[(one.first + first_frame, one.stop - 1 + first_frame)],
            )  # fmt: skip
    for side in SIDES:
        plates = sorted({str(one.plate + 1) for one in contacts if one.side == side and one.reason == "shared"})
        if plates:
            yield make_finding("gait_plates_added", trial=trial, side=side, plates_list=plates)
