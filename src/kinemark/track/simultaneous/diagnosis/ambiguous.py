"""Ambiguous decisions: those that were close, for the operator to review.

| kind   | what happened | when it is ambiguous |
| swap   | two tracks came so near that either could have had the other's images | nearer than gates (1), (3) |
| swap   | a track was lost and found again | its standard deviation exceeded `Simultaneous.uncertain_sd` |
| swap   | no image tells that two tracks go on as themselves | about as likely exchanged (`possible_exchanges`) |
| merge  | a track used images of two markers | fewer than two images of its own, also as one camera alone shows |
| ghost  | a track of little evidence | less than `WEAK_EVIDENCE` |
| stitch | two tracks may be one marker | made or not, another stitch was nearly as likely, or the gap was wide (2) |

With standard deviations s and s' of both predicted positions, in each axis, (1) is |x − x'| < g (s + s'). A gap is
wide where the standard deviation that motion leaves exceeds half of `uncertain_sd` (2).

At a low rate s says what any marker may do, and things that stand far apart would be near. To have exchanged their
images two tracks would have had to leave their own courses by their distance, so s is no more than what they do leave
them by at that time: the RMS of x(t) − 2 x(t−1) + x(t−2), in each axis, over `AROUND` frames (3).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np

from ....data import Detections, Rig, Tracks
from ....data.array_types import Bools, Floats, Ints
from ....data.finding import plain_value
from ....numerics.returned_memory import return_memory
from ....numerics.runs import equal_runs
from ..following.passes import Associations
from ..following.room_scale import scaled
from ..ghosts.merging_in_images import merged_in_images
from ..joining.possible_exchanges import possible_exchanges
from ..joining.stitch import CLEAR_MARGIN
from ..simultaneous_method import DEFAULT, Simultaneous
from ..simultaneous_tracking import track_simultaneously
from ..tracker import TrackingResult
from .lost_beside import with_lost_ones

WEAK_EVIDENCE = float(np.log(1000.0))
"""A marker is then a thousand times likelier than chance; chosen."""

MAX_FRAMES_APART = 3
"""Frames apart that two ambiguous decisions of the same tracks may lie to be one.
Chosen (see benchmarks/tracking.py)."""

AROUND = 3
"""Frames before and after, over which what a track leaves its course by is taken; an exchange shows in three. Chosen on
simulated recordings at 10 to 500 Hz: static things, pendulums and arms have no confusable points any more, and walking
at 10 and 25 Hz, with swaps, keeps nine in ten."""

DecisionKind = Literal["swap", "merge", "ghost", "stitch"]
DecisionReason = Literal[
    "came_near",
    "found_again",
    "exchange_as_likely",
    "shared_images",
    "little_evidence",
    "stitched_with_rival",
    "stitched_over_wide_gap",
    "not_stitched_with_rival",
    "not_stitched_over_wide_gap",
]
"""Why a decision was close; `report.words` says it in words."""


@dataclass(frozen=True, slots=True)
class AmbiguousDecision:
    """A decision that was close.

    Attributes:
        kind: what may have happened.
        first, last: frames, both included.
        tracks: that it is about.
        reason: why it was close.
        values: the numbers of the reason: distance_mm or sd_mm, the median over the frames; likelihood_ratio
            of a marker to a chance meeting of images; margin, how much more likely (logarithm) than the next best
            stitch, or than exchanged.
    """

    kind: DecisionKind
    first: int
    last: int
    tracks: tuple[int, ...]
    reason: DecisionReason
    values: Mapping[str, float] = field(default_factory=dict)

    def as_dict(self) -> dict[str, Any]:
        """As plain data for JSON."""
        return {
            "kind": self.kind,
            "first": self.first,
            "last": self.last,
            "tracks": list(self.tracks),
            "reason": self.reason,
            "values": {name: plain_value(value) for name, value in self.values.items()},
        }

    @classmethod
    def of(cls, data: Mapping[str, Any]) -> AmbiguousDecision:
        """The decision that `as_dict` wrote.

        Raises:
            TypeError: parts are missing, or there are others.
        """
        return cls(**{**data, "tracks": tuple(data["tracks"])})


def track_with_decisions(
    detections: Detections, rig: Rig, *, method: Simultaneous = DEFAULT
) -> tuple[Tracks, list[AmbiguousDecision]]:
    """Tracks of all markers as `track_detections` gives them, and the decisions that were close."""
    result = track_simultaneously(detections, rig, method)
    return result.tracks, ambiguous_decisions(result, method)


def ambiguous_decisions(result: TrackingResult, method: Simultaneous) -> list[AmbiguousDecision]:
    """The decisions of a run that were close, by frame."""
    method = scaled(method, result.scale)
    return_memory()
    detection = result.tracks.cloud.detection
    own = (detection >= 0) & ~result.images.merged[detection]
    near, merged = _of_associations(result, own & ~_merging(result)[detection], method)
    return_memory()
    lost = with_lost_ones(result.tracks, result.images, result.resolution, method)
    return_memory()
    found = [
        *near,
        *_possible_exchanges(result.tracks, own & ~lost, method),
        *merged,
        *_little_evidence(result),
        *_close_stitches(result, method),
    ]
    return sorted(found, key=lambda decision: (decision.first, decision.last, decision.tracks))


def _merging(result: TrackingResult) -> Bools:
    """(D) images that their camera alone shows to be of two markers (`merging_in_images`), in a file that marks none.

    The tracker believes it with three and four cameras; with more, most points' other images tell as much. They do not
    where they are of both markers too.
    """
    if not result.resolution or result.images.common:
        return np.zeros(len(result.images.merged), bool)
    return merged_in_images(result.images, result.resolution)


def _of_associations(
    result: TrackingResult, own: Bools, method: Simultaneous
) -> tuple[list[AmbiguousDecision], list[AmbiguousDecision]]:
    """Tracks that came near each other or were found again, and those that used images of several markers.

    The associations are in memory once more for as long.
    """
    rows = np.flatnonzero(result.id[result.seen.id] >= 0)
    seen = result.seen.take(rows[np.argsort(result.seen.frame[rows], kind="stable")])
    seen = seen._replace(id=result.id[seen.id])
    near = [*_came_near(seen, method), *_found_again(seen, method)]
    return near, _merged(result.tracks, own, seen, result.images.merged)


def _came_near(seen: Associations, method: Simultaneous) -> list[AmbiguousDecision]:
    """Tracks that came nearer than their gates (1), (3), both having images."""
    has, none = np.flatnonzero((seen.detection >= 0).any(0)), np.zeros((0, 0))
    # Without what takes memory.
    seen = seen._replace(detection=none.astype(np.int64), shared=none > 0, squared=none).take(has)
    sd = np.minimum(seen.before / np.sqrt(3), _off_course(seen))
    start = np.searchsorted(seen.frame, np.arange(int(seen.frame.max(initial=-1)) + 2))
    pairs, apart = [np.zeros((2, 0), np.int64)], [np.zeros(0)]
    for a, b in zip(start[:-1].tolist(), start[1:].tolist(), strict=True):
        xyz, reach = seen.xyz[:, a:b], method.gate * sd[a:b]
        squared = ((xyz[:, :, None] - xyz[:, None]) ** 2).sum(0)
        i, j = np.nonzero(np.triu(squared < (reach + reach[:, None]) ** 2, 1))
        pairs.append(np.array([a + i, a + j]))
        apart.append(np.sqrt(squared[i, j]))
    rows, far = np.concatenate(pairs, 1), np.concatenate(apart)
    who = np.sort(seen.id[rows], axis=0)
    other = who[0] != who[1]
    return [
        AmbiguousDecision("swap", a, b, who, "came_near", {"distance_mm": apart})
        for who, a, b, apart in _runs(who.T[other], seen.frame[rows[0]][other], far[other])
    ]


def _off_course(seen: Associations) -> Floats:
    """(n) mm in each axis, by which tracks leave straight courses at the time (3); infinite where that is not known."""
    order = np.lexsort([seen.frame, seen.id])
    who, frame, xyz = seen.id[order], seen.frame[order], seen.xyz[:, order]
    follows = (np.diff(who) == 0) & (np.diff(frame) == 1)
    off = np.full(len(order), np.nan)
    off[2:] = np.where(follows[1:] & follows[:-1], (np.diff(xyz, 2) ** 2).mean(0), np.nan)
    total, count = np.zeros((2, len(order)))
    for k in range(-AROUND, AROUND + 1):  # rows of the same track that are as many frames away, gaps left out
        a, b = slice(max(0, -k), len(order) - max(0, k)), slice(max(0, k), len(order) - max(0, -k))
        known = (who[a] == who[b]) & (np.abs(frame[a] - frame[b]) <= AROUND) & ~np.isnan(off[b])
        total[a] += np.where(known, off[b], 0.0)
        count[a] += known
    out = np.full(len(order), np.inf)
    out[order[count > 0]] = np.sqrt(total[count > 0] / count[count > 0])
    return out


def _found_again(seen: Associations, method: Simultaneous) -> list[AmbiguousDecision]:
    """Tracks that were lost, and then had two images where their place was hardly known.

    At a low rate a place is hardly known from one frame to the next. A track that has two images before and after was
    not lost there, and a marker alone is exchanged with none.
    """
    alone = np.bincount(seen.frame)[seen.frame] == 1 if len(seen.frame) else np.zeros(0, np.bool_)
    two = (seen.detection >= 0).sum(0) >= 2
    place = seen.id * (int(seen.frame.max(initial=0)) + 3) + seen.frame
    goes_on = np.isin(place - 1, place[two]) & np.isin(place + 1, place[two])
    again = np.flatnonzero((seen.before > method.uncertain_sd) & two & ~goes_on & ~alone)
    return [
        AmbiguousDecision("swap", a, b, who, "found_again", {"sd_mm": sd})
        for who, a, b, sd in _runs(seen.id[again][:, None], seen.frame[again], seen.before[again])
    ]


def _possible_exchanges(tracks: Tracks, own: Bools, method: Simultaneous) -> list[AmbiguousDecision]:
    """Pairs of tracks that may have been exchanged where no image tells that each goes on as itself."""
    found = possible_exchanges(tracks, own, method)
    return [
        AmbiguousDecision("swap", first, last, tuple(sorted(pair)), "exchange_as_likely", {"margin": margin})
        for pair, first, last, margin in zip(*(column.tolist() for column in found), strict=True)
    ]


def _merged(tracks: Tracks, own: Bools, seen: Associations, merged: Bools) -> list[AmbiguousDecision]:
    """Tracks that used images of several markers, and had fewer than two of their own, where own (P, C): when they were
    tracked, or in the end, as points are given up and found in between."""
    cloud, has = tracks.cloud, seen.detection >= 0
    few = (has & ~seen.shared & ~merged[seen.detection]).sum(0) < 2
    was = np.flatnonzero(few & (has & seen.shared).any(0) & (has.sum(0) >= 2))
    now = np.flatnonzero((own.sum(1) < 2) & ((cloud.detection >= 0).sum(1) >= 2))
    both = np.append(seen.id[was], tracks.id[now]), np.append(seen.frame[was], cloud.frame[now])
    who, frame = np.unique(both, axis=1)
    return [
        AmbiguousDecision("merge", a, b, one, "shared_images")
        for one, a, b, _ in _runs(who[:, None], frame, np.zeros(len(frame)))
    ]


def _little_evidence(result: TrackingResult) -> list[AmbiguousDecision]:
    """Tracks of little evidence."""
    cloud, ids = result.tracks.cloud, result.tracks.id
    total = np.zeros(len(result.tracks))
    raw = np.flatnonzero(result.id[: len(result.evidence)] >= 0)
    np.add.at(total, result.id[raw], result.evidence[raw])
    return [
        AmbiguousDecision(
            "ghost",
            int(cloud.frame[ids == i].min()),
            int(cloud.frame[ids == i].max()),
            (int(i),),
            "little_evidence",
            {"likelihood_ratio": float(np.exp(total[i]))},
        )
        for i in np.flatnonzero(total < WEAK_EVIDENCE)
    ]


def _close_stitches(result: TrackingResult, method: Simultaneous) -> list[AmbiguousDecision]:
    """Stitches that had a rival, and those over wide gaps."""
    found = []
    for stitch in result.stitches:
        rival, wide = stitch.margin < 2 * CLEAR_MARGIN, stitch.sd > method.uncertain_sd / 2  # (2)
        if not rival and not wide:
            continue
        tracks = tuple(dict.fromkeys(int(result.id[i]) for i in (stitch.before, stitch.after)))
        reason = _stitch_reason(stitch.margin > CLEAR_MARGIN, rival)
        values = {"margin": float(stitch.margin), "sd_mm": float(stitch.sd)}
        found.append(AmbiguousDecision("stitch", stitch.last, stitch.first, tracks, reason, values))
    return found


def _stitch_reason(stitched: bool, rival: bool) -> DecisionReason:
    """Two tracks were stitched or not, and another stitch was nearly as likely, or the gap was wide."""
    if rival:
        return "stitched_with_rival" if stitched else "not_stitched_with_rival"
    return "stitched_over_wide_gap" if stitched else "not_stitched_over_wide_gap"


def _runs(who: Ints, frame: Ints, size: Floats) -> list[tuple[tuple[int, ...], int, int, float]]:
    """Runs of frames in which the same tracks `who` (n, k) are ambiguous: they, first, last, the median of `size`."""
    order = np.lexsort([frame, *who.T[::-1]])
    who, frame, size = who[order], frame[order], size[order]
    spell = np.cumsum(np.diff(frame, prepend=frame[:1]) > MAX_FRAMES_APART)
    cuts = equal_runs(*who.T, spell)
    return [
        (tuple(int(i) for i in who[a]), int(frame[a]), int(frame[b - 1]), float(np.median(size[a:b])))
        for a, b in zip(cuts[:-1].tolist(), cuts[1:].tolist(), strict=True)
    ]
