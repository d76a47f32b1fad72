"""Standard uncertainties of angles, moments and powers, and what they come from.

A quantity y(x₁, x₂, …) of independent causes with standard uncertainties u₁, u₂, … has

    u(y)² = Σᵢ Δᵢ²,   Δᵢ = [ y(xᵢ + uᵢ) − y(xᵢ − uᵢ) ] / 2                                                   (1)

Causes that stay as they are through a trial are shifted in all frames at once, each along the three axes of its own
segment: where a marker sits on its landmark (in the static trial too), the hip joint centre, widths, skin over bone,
and where the plates lie. A hip that a motion has shown stays in the bone where a marker of the pelvis is shifted. Noise
of the markers is independent between frames, and derivatives make much of it, so that it is drawn at random (2): the
deviation s of y over n trials, filtered as the trial itself, with noise of the stated covariance, s √((n − 1)/(n − 3)),
as few draws know it badly (JCGM 101:2008, 6.4.9). What smoothing takes of the motion itself is systematic, and about
what it takes when it is done once more, and what it would not take with a higher cut-off: its
standard uncertainty is √[(y(smoothed twice) − y)² + (y(√2 times the cut-off) − y)²] (3).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import chain
from typing import Any

import numpy as np

from ..data import Signals, Trial
from ..data.array_types import Floats
from ..data.model_markers import INSIDE
from ..data.subject_measures import LETTER, SIDES, SubjectMeasures
from .clusters import Clusters, calibrated_body, landmarks_of, with_wands
from .gait_trial import Inputs, gait_of
from .lower_limb import LowerLimbs, lower_limbs, pelvis_of
from .segments import Segment, within_half_turn
from .static_axes import with_knees
from .static_trial import with_static_offsets

FEWEST_DRAWS = 4
"""Of noise, whose deviation means something; by definition of (2)."""
Quantities = Mapping[str, Floats]
"""(F, A) by name."""


@dataclass(frozen=True, slots=True)
class GaitErrors:
    """Standard uncertainties of the causes.

    Attributes:
        placement_mm: of each marker on its landmark, along each axis.
        hip_mm: of the hip joint centre by regression, along each axis; measures that know the hip state their own.
        width_mm: of the measured widths of knee and ankle.
        tissue_mm: how far skin moves markers of thigh and shank over the bone, along each axis.
        plate_mm: of the places of force plates among the markers, along each horizontal axis.
        draws: of noise; fewer than `FEWEST_DRAWS` leave it out.
        seed: of the draws.

    Raises:
        ValueError: one is below 0.
    """

    placement_mm: float = 5.0
    hip_mm: float = 10.0
    width_mm: float = 2.0
    tissue_mm: float = 5.0
    plate_mm: float = 3.0
    draws: int = 20
    seed: int = 0

    def __post_init__(self) -> None:
        for name in ("placement_mm", "hip_mm", "width_mm", "tissue_mm", "plate_mm"):
            if not 0 <= getattr(self, name) < np.inf:
                raise ValueError(f"{name} is {getattr(self, name)}, wanted 0 or more")


SEGMENT_OF = {"THI": "thigh", "KNE": "thigh", "TIB": "shank", "ANK": "shank", "HEE": "foot", "TOE": "foot"}
"""On which segment a marker of a leg sits."""
STANDING = {"KAX": "thigh", "KNM": "thigh", "MED": "shank"}
"""The same of those that only the static trial has."""
SKINNY = tuple(f"{side} {part}" for side in SIDES for part in ("thigh", "shank"))
"""Segments whose clusters move with skin; conventional, as of single markers."""
APART = 0.5
"""How far skin moves the markers of a cluster against each other, as a share of how far it moves all of them; chosen:
over pins in thigh and shank of a walker it was 0.3 and 0.5 (`studies/gait_references.py`)."""
PELVIS = ("ASI", "PSI", "ACR")
"""Names of the pelvis' markers without their first letter."""


@dataclass(frozen=True, slots=True)
class _Model:
    """All that is recomputed: a walk, its static trial, measures and method."""

    given: Inputs
    static: Mapping[str, Floats] | None
    flat_foot: bool
    method: Any
    axes: bool = True
    clusters: Clusters = field(default_factory=dict)

    def quantities(self) -> Quantities:
        """(F, A) by name."""
        measures, hip_centre = self.given.measures, self.method.mechanics.hip_centre
        body = None
        if self.static is not None:
            measures = with_static_offsets(
                measures,
                self.static,
                flat_foot=self.flat_foot,
                hip_centre=hip_centre,
                axes=self.axes,
            )
            if self.clusters:
                body = calibrated_body(with_wands(self.static), measures, self.clusters, hip_centre=hip_centre)
        found = gait_of(self.given._replace(measures=measures, body=body), self.method.mechanics)
        return {signal.name: signal.values for signal in found.signals}

    def limbs(self, points: Mapping[str, Floats]) -> LowerLimbs:
        """Segments of a trial."""
        return lower_limbs(points, self.given.measures, hip_centre=self.method.mechanics.hip_centre)


Shifted = Callable[[float], _Model]
"""The model with a cause shifted by so many of its standard uncertainties."""


def gait_uncertainty(
    trial: Trial,
    measures: SubjectMeasures,
    *,
    method: Any,
    errors: GaitErrors | None = None,
    static: Mapping[str, Floats] | None = None,
    flat_foot: bool = True,
    axes: bool = True,
    clusters: Clusters | None = None,
) -> dict[str, dict[str, Floats]]:
    """(F, A) standard uncertainty of each quantity by cause, then by name of the quantity.

    Causes are "noise", "smoothing", "placement", "hip centre", "widths", "soft tissue" and "plates"; their squares add.

    Args:
        trial: with named markers. measures: of the subject, without offsets of the feet where a static trial is given.
        method: of gait analysis. errors: of the causes; the usual ones where None.
        static: (F, 3) mm by name of the standing trial whose errors count too; flat_foot: as it was stood.
        axes: it turns the wands back where it shows the axes of the joints.
        clusters: that carry segments, calibrated in the standing trial.
    """
    errors, clusters = GaitErrors() if errors is None else errors, clusters or {}
    points = method.markers(trial, besides=[name for markers in clusters.values() for name in markers])
    given = method.inputs(trial, points, measures)
    model = _Model(given, None if static is None else with_knees(static), flat_foot, method, axes, clusters)
    out = {
        cause: _combined(shifted)
        for cause, shifted in {
            "placement": _placement(model, errors.placement_mm, tuple(SEGMENT_OF), pelvis=True, static=True),
            "hip centre": _hips(model, errors.hip_mm),
            "widths": _widths(model, errors.width_mm),
            "soft tissue": chain(
                _placement(model, errors.tissue_mm, ("THI", "KNE", "TIB"), pelvis=False, static=False),
                _skin_of_clusters(model, errors.tissue_mm),
            ),
            "plates": _plates(model, errors.plate_mm),
        }.items()
    }
    noise, lost = _noise(trial, model, errors), _lost(trial, model)
    return {**({"noise": noise} if noise else {}), **({"smoothing": lost} if lost else {}), **out}


def with_uncertainty(signals: Signals, causes: Mapping[str, Mapping[str, Floats]]) -> Signals:
    """Signals with the covariance that all causes leave, without correlation of their components."""
    out = []
    for signal in signals:
        total = sum((np.nan_to_num(cause[signal.name]) ** 2 for cause in causes.values() if signal.name in cause), 0.0)
        cov = np.broadcast_to(np.asarray(total)[..., None] * np.eye(len(signal.axes)), signal.cov.shape)
        out.append(replace(signal, cov=np.where(np.isnan(signal.values)[..., None], np.nan, cov)))
    return Signals(tuple(out))


def _combined(causes: Iterator[Shifted]) -> dict[str, Floats]:
    """(1) over causes."""
    total: dict[str, Floats] = {}
    for shifted in causes:
        more, less = shifted(1.0).quantities(), shifted(-1.0).quantities()
        for name, y in more.items():
            half = (y - less[name]) / 2
            if name.endswith("Angles"):
                half = within_half_turn(2 * half) / 2
            total[name] = total.get(name, 0.0) + half**2
    return {name: np.sqrt(square) for name, square in total.items()}


def _placement(
    model: _Model, sd: float, leg_markers: tuple[str, ...], *, pelvis: bool, static: bool
) -> Iterator[Shifted]:
    """Each marker along each axis of its segment."""
    if sd <= 0:
        return
    limbs = model.limbs(model.given.points)
    stood = model.limbs(with_wands(model.static)) if static and model.static is not None else None
    names = [n for n in ("LASI", "RASI", "SACR", "LPSI", "RPSI") if pelvis and n in model.given.points]
    names += [LETTER[side] + marker for side in SIDES for marker in leg_markers]
    by_cluster = {mark for segment in model.clusters for mark in landmarks_of(segment)}
    for name in names:
        for axis in range(3):
            walk = None if name in by_cluster else sd * _segment(limbs, name).R[..., axis]
            still = None if stood is None else sd * _segment(stood, name).R[..., axis]
            if walk is not None or (still is not None and model.static is not None and name in model.static):
                yield _shifting(model, name, walk, still)
    if stood is None:
        return
    for name in _only_standing(model):
        for axis in range(3):
            yield _shifting(model, name, None, sd * _segment(stood, name).R[..., axis])


def _skin_of_clusters(model: _Model, sd: float) -> Iterator[Shifted]:
    """All markers of each cluster of a leg together, and each alone by `APART` of it, along the segment's axes."""
    limbs = model.limbs(model.given.points)
    for segment, markers in model.clusters.items() if sd > 0 else ():
        if segment not in SKINNY:
            continue
        R = _segment(limbs, landmarks_of(segment)[0]).R
        for moved, share in ((tuple(markers), 1.0), *(((marker,), APART) for marker in markers)):
            for axis in range(3):
                yield _moving_markers(model, moved, share * sd * R[..., axis])


def _moving_markers(model: _Model, names: Sequence[str], by: Floats) -> Shifted:
    """Some markers of the walk by so many (F, 3) mm."""

    def shifted(times: float) -> _Model:
        moved = {name: model.given.points[name] + times * by for name in names}
        return replace(model, given=model.given._replace(points={**model.given.points, **moved}))

    return shifted


def _only_standing(model: _Model) -> list[str]:
    """Markers that show axes in the static trial alone."""
    names = [LETTER[side] + name for side in SIDES for name in ("KAX", *INSIDE)]
    return [name for name in names if model.axes and model.static is not None and name in model.static]


def _shifting(model: _Model, name: str, walk: Floats | None, still: Floats | None) -> Shifted:
    """One marker by so many (F, 3) mm, in the walk and in the static trial, where it is worn there."""

    def shifted(times: float) -> _Model:
        points = dict(model.given.points)
        if walk is not None:
            points[name] = points[name] + times * walk
        static = model.static
        if static is not None and still is not None and name in static:
            static = {**static, name: static[name] + times * still}
        measures = model.given.measures
        if name[1:] in PELVIS:
            moved = (model.given.points, points) if walk is not None else (model.static or {}, static or {})
            measures = _kept_hips(measures, *moved)
        given = model.given._replace(points=points, measures=measures)
        return replace(model, given=given, static=static)

    return shifted


def _kept_hips(measures: SubjectMeasures, before: Mapping[str, Floats], after: Mapping[str, Floats]) -> SubjectMeasures:
    """The measures with hips that motion has shown at the same place of the bone, though the pelvis' markers moved."""
    (one, _), (two, _) = pelvis_of(before), pelvis_of(after)
    out = measures
    for side in SIDES:
        own = measures.leg(side)
        if own.hip_mm is not None:
            local = np.einsum("fji,fj->fi", two.R, one.at(np.array(own.hip_mm)) - two.origin)
            if np.isfinite(local).all(1).any():
                x, y, z = (float(c) for c in np.nanmean(local, axis=0))
                out = out.with_leg(side, replace(own, hip_mm=(x, y, z)))
    return out


def _segment(limbs: LowerLimbs, name: str) -> Segment:
    """On which a marker sits."""
    part = (SEGMENT_OF | STANDING).get(name[1:])
    if part is None:
        return limbs.pelvis
    leg = limbs.left if name[0] == "L" else limbs.right
    found: Segment = getattr(leg, part)
    return found


def _hips(model: _Model, sd: float) -> Iterator[Shifted]:
    """Each hip along each axis of the pelvis, by its own standard uncertainty where it has one."""
    for side in SIDES:
        own = model.given.measures.leg(side).hip_sd_mm or (sd, sd, sd)
        for axis in range(3):
            shift = tuple(own[axis] * np.eye(3)[axis])
            yield _measuring(model, side, "hip_shift_mm", shift)


def _widths(model: _Model, sd: float) -> Iterator[Shifted]:
    """Widths of knees and ankles."""
    for side in SIDES:
        for name in ("knee_mm", "ankle_mm"):
            yield _measuring(model, side, name, sd)


def _measuring(model: _Model, side: str, name: str, by: Any) -> Shifted:
    """One measure of a leg."""

    def shifted(times: float) -> _Model:
        measures = model.given.measures
        leg = getattr(measures, side)
        value = np.add(getattr(leg, name), np.multiply(times, by))
        changed = replace(leg, **{name: tuple(value) if np.ndim(value) else float(value)})
        return replace(model, given=model.given._replace(measures=replace(measures, **{side: changed})))

    return shifted


def _plates(model: _Model, sd: float) -> Iterator[Shifted]:
    """Each plate along each horizontal axis."""
    for k in range(len(model.given.reactions)):
        for axis in range(2):
            yield _moving(model, k, sd * np.eye(3)[axis])


def _moving(model: _Model, k: int, by: Floats) -> Shifted:
    """One plate by (3) mm."""

    def shifted(times: float) -> _Model:
        plates = list(model.given.reactions)
        plates[k] = replace(plates[k], centre=plates[k].centre + times * by)
        return replace(model, given=model.given._replace(reactions=tuple(plates)))

    return shifted


def _lost(trial: Trial, model: _Model) -> dict[str, Floats]:
    """(3); nothing where nothing is smoothed."""
    others = model.method.smoothed_otherwise(trial, besides=list(model.given.points))
    if not others:
        return {}
    once = model.quantities()
    total: dict[str, Floats] = {}
    for points in others:
        for name, y in replace(model, given=model.given._replace(points=points)).quantities().items():
            difference = within_half_turn(y - once[name]) if name.endswith("Angles") else y - once[name]
            total[name] = total.get(name, 0.0) + difference**2
    return {name: np.sqrt(square) for name, square in total.items()}


def _noise(trial: Trial, model: _Model, errors: GaitErrors) -> dict[str, Floats]:
    """(2); nothing where no marker states its noise or none is drawn."""
    roots = {path.name: _root(path.cov) for path in trial.trajectories}
    if errors.draws < FEWEST_DRAWS or not any(np.isfinite(root).any() for root in roots.values()):
        return {}
    rng, used = np.random.default_rng(errors.seed), list(model.given.points)
    cutoffs = model.method.cutoffs(trial, besides=used)
    drawn: dict[str, list[Floats]] = {}
    for _ in range(errors.draws):
        paths = tuple(
            replace(p, xyz=p.xyz + np.einsum("fij,fj->fi", np.nan_to_num(roots[p.name]), rng.normal(size=p.xyz.shape)))
            for p in trial.trajectories
        )
        noisy = replace(trial, trajectories=replace(trial.trajectories, paths=paths))
        points = model.method.markers(noisy, besides=used, cutoffs=cutoffs)
        for name, y in replace(model, given=model.given._replace(points=points)).quantities().items():
            drawn.setdefault(name, []).append(y)
    return {name: _spread(np.array(ys), angle=name.endswith("Angles")) for name, ys in drawn.items()}


def _spread(ys: Floats, *, angle: bool) -> Floats:
    """(F, A) standard deviation of (draws, F, A) by (2); of angles about the first, by less than half a turn."""
    n = len(ys)
    if angle:
        ys = ys[0] + within_half_turn(ys - ys[0])
    return np.asarray(ys.std(axis=0, ddof=1) * np.sqrt((n - 1) / (n - 3)))


def _root(cov: Floats) -> Floats:
    """(F, 3, 3) with root rootᵀ = cov; NaN where it is unknown."""
    known = np.isfinite(cov).all((1, 2))
    root = np.full_like(cov, np.nan)
    values, axes = np.linalg.eigh(cov[known])
    root[known] = axes * np.sqrt(np.maximum(values, 0.0))[:, None, :]
    return root
