"""Segments that clusters of markers carry, calibrated in the standing trial (CAST; Cappozzo et al. 1995).

A cluster is three or more markers on one segment, on a plate or on the skin. The standing trial has them together with
the landmarks, which show the model's segment, its axes R and origin o; there the cluster has the pose (C, c). In a walk
its pose of least squares (C(t), c(t)) (`kinematics.pose`) carries the segment and its landmarks q along:

    R(t) = C(t) Cᵀ R,   o(t) = C(t) Cᵀ (o − c) + c(t),   q(t) likewise                                          (1)

so that a segment has six degrees of freedom of its own, and the walk needs none of its landmarks. Segments without a
cluster are as ever those of `lower_limb`, from the joint centres that the others have. A standing trial without wands
has them where inner markers show the axes: beyond the outer marker, on the axis (2).

Some clusters need no statement, because the names of the markers tell their segment (`usual_clusters`). Sets without
wands have three or more markers on thigh and shank: the landmarks of the Rizzoli sets and of the ISB (trochanter,
epicondyles; head of the fibula, tuberosity of the tibia, malleoli; Leardini et al. 2007), plates or skin markers
numbered on a segment (LTH1 … LTH4), CGM2's THAP and THAD, "Thigh.Upper". They stand for the wands of the model.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ..data import KinemarkError
from ..data.array_types import Floats
from ..data.landmarks import landmarks
from ..data.model_markers import INSIDE
from ..data.subject_measures import LETTER, SIDES, Side, SubjectMeasures
from ..kinematics import body_pose
from ..kinematics.pose import ClusterTemplate, cluster_template
from .lower_limb import LowerLimbs, absent_markers, lower_limbs
from .segments import Segment

Clusters = Mapping[str, Sequence[str]]
"""Names of markers by the segment that carries them, one of `SEGMENTS`."""
PARTS = ("thigh", "shank", "foot")
"""Of a leg; conventional."""
SEGMENTS = ("pelvis", *(f"{side} {part}" for side in SIDES for part in PARTS))
"""That may have a cluster; conventional."""
LANDMARKS = {"pelvis": ("LASI", "RASI", "SACR", "LPSI", "RPSI"), "thigh": ("THI", "KNE", "KNM"),
             "shank": ("TIB", "ANK", "MED"), "foot": ("HEE", "TOE")}  # fmt: skip
"""The model's markers on each segment, those of a leg after L or R; conventional."""
WANDS = {"THI": ("KNE", INSIDE[0]), "TIB": ("ANK", INSIDE[1])}
"""Outer and inner marker of the axis that a wand shows, after L or R; conventional."""
FEWEST = 3
"""Markers that a pose wants; by definition."""
POINTS = ("o", "x", "y", "z")
"""Of a segment that a template carries: its origin, and 1 m along each axis."""
METRE = 1000.0
"""Length of what stands for an axis, mm; by definition."""


@dataclass(frozen=True, slots=True, eq=False)
class CalibratedBody:
    """What clusters carry.

    Attributes:
        templates: by segment, each with the landmarks of it, and with `POINTS` where it is of a leg.
    """

    templates: Mapping[str, ClusterTemplate]

    @property
    def markers(self) -> frozenset[str]:
        """Of all clusters."""
        return frozenset(marker for template in self.templates.values() for marker in template.markers)

    def landmarks(self, points: Mapping[str, Floats]) -> dict[str, Floats]:
        """(F, 3) mm by name of all that the clusters carry, from their markers at `points` (F, 3) mm."""
        return _without_points(_carried(template, points) for template in self.templates.values())

    def limbs(self, points: Mapping[str, Floats], measures: SubjectMeasures, *, hip_centre: str) -> LowerLimbs:
        """Segments in every frame, by clusters where there are.

        Args:
            points: (F, 3) mm by name. measures: of the subject. hip_centre: the regression.
        """
        each = {name: _carried(template, points) for name, template in self.templates.items()}
        segments = {name: _segment(carried) for name, carried in each.items() if "o" in carried}
        whole = {**points, **_without_points(each.values())}
        return lower_limbs(whole, measures, hip_centre=hip_centre, carried=segments)

    def misfit(self, points: Mapping[str, Floats]) -> dict[str, float]:
        """mm by segment: RMS distance of the markers at `points` (F, 3) mm from where their cluster has them."""
        found = {}
        for name, template in self.templates.items():
            xyz = np.array([points[marker] for marker in template.markers])
            pose = body_pose(template.xyz, xyz)
            there = np.einsum("fij,kj->kfi", pose.R, template.xyz) + pose.t
            squared = ((there - xyz) ** 2).sum(-1)
            found[name] = float(np.sqrt(np.nanmean(squared))) if np.isfinite(squared).any() else np.nan
        return found


def calibrated_body(
    static: Mapping[str, Floats], measures: SubjectMeasures, clusters: Clusters, *, hip_centre: str = "davis"
) -> CalibratedBody:
    """The clusters with what they carry.

    Args:
        static: (F, 3) mm by name of the standing trial, with wands (`with_wands`) and the clusters' markers.
        measures: of the subject, with what the standing trial shows of it.
        clusters: at least one. hip_centre: the regression.

    Raises:
        KinemarkError: a marker is not there, a cluster is never seen whole or lies on a line, or a segment is none.
    """
    check_clusters(clusters, static, "standing trial")
    limbs = lower_limbs(static, measures, hip_centre=hip_centre)
    found = {}
    for name, markers in clusters.items():
        own = _landmarks(name, static)
        if name != "pelvis":
            own |= _points_of(name, limbs)
        found[name] = _template(name, markers, static, own)
    return CalibratedBody(found)


def carried_landmarks(
    walk: Mapping[str, Floats], static: Mapping[str, Floats], clusters: Clusters
) -> dict[str, Floats]:
    """(F, 3) mm by name of the landmarks that clusters carry into a walk.

    Args:
        walk: (F, 3) mm by name. static: (S, 3) mm by name of the standing trial. clusters: in both.

    Raises:
        KinemarkError: see `calibrated_body`.
    """
    check_clusters(clusters, static, "standing trial")
    each = {name: _template(name, markers, static, _landmarks(name, static)) for name, markers in clusters.items()}
    return CalibratedBody(each).landmarks(walk)


def _landmarks(segment: str, static: Mapping[str, Floats]) -> dict[str, Floats]:
    """(F, 3) mm by name of those of a segment that the standing trial has."""
    return {m: static[m] for m in landmarks_of(segment) if m in static and np.isfinite(static[m]).any()}


def _points_of(segment: str, limbs: LowerLimbs) -> dict[str, Floats]:
    """(F, 3) mm of `POINTS` of a leg's segment."""
    side, part = _side_and_part(segment)
    leg = limbs.leg(side)
    one = {"thigh": leg.thigh, "shank": leg.shank, "foot": leg.bare_foot}[part]
    ends = (one.origin + METRE * one.R[..., axis] for axis in range(3))
    return dict(zip(POINTS, (one.origin, *ends), strict=True))


def _template(
    segment: str, markers: Sequence[str], static: Mapping[str, Floats], own: Mapping[str, Floats]
) -> ClusterTemplate:
    xyz = np.array([static[marker] for marker in markers])
    carried = np.array(list(own.values())).reshape(len(own), *xyz.shape[1:])
    try:
        return cluster_template(segment, tuple(markers), xyz, tuple(own), carried)
    except KinemarkError as error:
        raise KinemarkError(f"The cluster of the {segment} cannot be calibrated: {error}") from None


def with_wands(static: Mapping[str, Floats]) -> dict[str, Floats]:
    """The standing trial with wands (2), where it has none and inner markers show the axes.

    Args:
        static: (F, 3) mm by the model's names.
    """
    out = dict(static)
    for letter in LETTER.values():
        for wand, (outer, inner) in WANDS.items():
            if letter + wand not in out and {letter + outer, letter + inner} <= set(out):
                out[letter + wand] = 2 * out[letter + outer] - out[letter + inner]  # (2)
    return out


def check_clusters(clusters: Clusters, points: Mapping[str, Floats], trial: str) -> None:
    """Whether a trial has all clusters.

    Args:
        clusters: as stated. points: (F, 3) mm by name. trial: what it is called.

    Raises:
        KinemarkError: a segment is none, a cluster has too few markers or shares one, or a marker is not there.
    """
    if unknown := [name for name in clusters if name not in SEGMENTS]:
        raise KinemarkError(f"A cluster is on {unknown[0]!r}, which is none of {', '.join(SEGMENTS)}.")
    for name, markers in clusters.items():
        if len(set(markers)) < FEWEST:
            raise KinemarkError(
                f"The cluster of the {name} has {len(set(markers))} markers ({', '.join(markers)}), wanted {FEWEST} or "
                "more, not on a line. Name all of them, or leave the cluster out."
            )
        if absent := [marker for marker in markers if marker not in points or not np.isfinite(points[marker]).any()]:
            raise KinemarkError(
                f"The {trial} has no {', '.join(absent)}, of the cluster of the {name}; there are "
                f"{', '.join(list(points)[:40]) or 'none'}. Name the markers as the files do."
            )
    every = [marker for markers in clusters.values() for marker in markers]
    if twice := sorted({marker for marker in every if every.count(marker) > 1}):
        raise KinemarkError(f"{', '.join(twice)} is said to be in two clusters. A marker is on one segment.")


def uncarried(walk: Collection[str], static: Collection[str], clusters: Clusters) -> dict[str, tuple[str, ...]]:
    """The model's markers that a walk lacks and the standing trial has, by their segments without a cluster.

    Args:
        walk, static: names of markers that they have. clusters: as stated.
    """
    absent = set(absent_markers(walk)) & set(static)
    each = {name: tuple(m for m in landmarks_of(name) if m in absent) for name in SEGMENTS if name not in clusters}
    return {name: markers for name, markers in each.items() if markers}


def segment_name(text: str) -> str:
    """A segment as `SEGMENTS` has it, of "left_thigh" or "Left Thigh"."""
    return " ".join(text.replace("_", " ").lower().split())


def landmarks_of(segment: str) -> tuple[str, ...]:
    """The model's names of the markers on a segment, one of `SEGMENTS`."""
    if segment == "pelvis":
        return LANDMARKS[segment]
    side, part = _side_and_part(segment)
    return tuple(LETTER[side] + name for name in LANDMARKS[part])


def _side_and_part(segment: str) -> tuple[Side, str]:
    side, part = segment.split()
    return ("left" if side == "left" else "right"), part


def _carried(template: ClusterTemplate, points: Mapping[str, Floats]) -> dict[str, Floats]:
    """(F, 3) mm by name of a template's points (1)."""
    pose = body_pose(template.xyz, np.array([points[marker] for marker in template.markers]))
    return {name: pose.R @ q + pose.t for name, q in zip(template.points, template.local, strict=True)}


def _without_points(each: Iterable[Mapping[str, Floats]]) -> dict[str, Floats]:
    """Landmarks alone of what clusters carry."""
    return {name: xyz for carried in each for name, xyz in carried.items() if name not in POINTS}


def _segment(carried: Mapping[str, Floats]) -> Segment:
    """Of its `POINTS`; axes made square where the standing trial's frames differed a little."""
    R = np.stack([carried[axis] - carried["o"] for axis in POINTS[1:]], -1) / METRE
    known = np.isfinite(R).all((1, 2))
    U, _, Vt = np.linalg.svd(R[known])
    square = np.full_like(R, np.nan)
    square[known] = U @ Vt
    return Segment(square, carried["o"])


ON_SEGMENT = {
    "thigh": r"th(igh)?[1-9]|thi[1-9]|thap|thad|thigh(upper|lower|front|rear|back|lat|med|side|top|bottom)"
    r"|ftc|gt|gtr|(greater)?troch(anter)?",
    "shank": r"sk[1-9]|shank[1-9]|tib[1-9]|tiap|tiad|shank(upper|lower|front|rear|back|lat|med|side|top|bottom)"
    r"|fax|hf|fh|fib(ula)?head|headfib(ula)?|ttc|tt|tub|tibtub|tibialtuberosity",
}
"""What markers are called that sit on a segment and are none of the model's, without side and signs; conventional."""
OF_JOINT = {"thigh": ("KNE", INSIDE[0]), "shank": ("ANK", INSIDE[1])}
"""The model's markers that may belong to its cluster, after L or R; conventional."""


def usual_clusters(walk: Collection[str], static: Collection[str], stated: Clusters) -> dict[str, tuple[str, ...]]:
    """Clusters by segment of thighs and shanks that the walk wants one for, by names; none of segments that have one.

    The model's own markers at knee and ankle belong to a cluster only where it would be too small without them.

    Args:
        walk: names of markers, the model's own called as the model has them, that all walks have.
        static: the same of the standing trial, with wands (`with_wands`). stated: by whoever knows.
    """
    lacking = set(absent_markers(walk))
    if not lacking & set(static):
        return {}  # most walks wear all, and to read names takes a while
    ways = landmarks(list(walk))
    taken = {marker for own in stated.values() for marker in own}
    found = {}
    for side in SIDES:
        for part, pattern in ON_SEGMENT.items():
            segment = f"{side} {part}"
            wanted = lacking & set(landmarks_of(segment))
            if segment in stated or not wanted or not wanted <= set(static):
                continue
            free = [name for name in walk if name in static and name not in taken]
            own = [n for n in free if any(way.side == side and re.fullmatch(pattern, way.word) for way in ways[n])]
            if len(own) < FEWEST:
                own += [n for n in (LETTER[side] + name for name in OF_JOINT[part]) if n in free]
            if len(own) >= FEWEST:
                found[segment] = tuple(own)
    return found
