"""The gait of a subject's walks, which are in memory: `files` reads and writes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np

from ...data import Events, KinemarkError, Signals, Trial
from ...data.array_types import Floats
from ...data.gait_curves import GaitCurves, joined_curves
from ...data.laboratory_axes import shows_up
from ...data.marker_sides import without_subject
from ...data.strides import FootEvent
from ...data.subject_measures import SIDES, SubjectMeasures
from ...findings.gait_records import ClustersShown, GaitOfTrial, HipsShown, StaticAxes
from ...gait import with_static_offsets
from ...gait.backwards import reversals
from ...gait.clusters import CalibratedBody, Clusters, calibrated_body, uncarried, with_wands
from ...gait.estimated_measures import WIDTH_SD_MM, check_legs, estimated_measures, joints_by_share, mass_on_plates
from ...gait.foot_events import foot_events
from ...gait.functional_hip import functional_hip, with_functional_hips
from ...gait.gait_cycles import dynamic_peaks, emg_curves, gait_curves
from ...gait.gait_trial import REACTION, along_way, analyse_gait, marker_points, measured_only
from ...gait.key_values import key_values
from ...gait.lower_limb import check_markers, leg_seen, lower_limbs, never_seen
from ...gait.marker_spikes import MarkerSpikes, without_spikes
from ...gait.standard_trial import (
    StandardTrial,
    in_laboratory,
    standard_trial,
    with_absent_leg,
    with_heels,
    with_landmarks,
)
from ...gait.standing import stands, with_standing
from ...gait.static_axes import with_knees
from ...gait.static_checks import static_doubts
from ...gait.time_distance import strides
from ...gait.treadmill import floor_velocity
from ...gait.turning import with_counts, with_facing
from ...gait.uncertainty import gait_uncertainty, with_uncertainty
from ...gait.way_of_walking import way_of_walking
from ...io.c3d.subject_measures import measures_of
from ...numerics.finite import finite_median
from .doubts import doubted_markers, doubted_plates
from .emg import emg_of, greatest_contractions, left_out_of
from .one_subject import of_one_subject
from .settings import GaitSettings

WIDTH_MM = 2.0
"""Standard uncertainty of a measured width of knee or ankle, mm; chosen."""


@dataclass(frozen=True, slots=True, eq=False)
class Recorded:
    """A file of one subject, as it was read and as the gait model wants it.

    Attributes:
        name: of the file, without its ending. given: as it was read. standard: of it, without `spikes`.
        clusters: that a standing trial calibrates. by_names: segments of those that nobody stated.
    """

    name: str
    given: Trial
    standard: StandardTrial
    clusters: Clusters = field(default_factory=dict)
    by_names: tuple[str, ...] = ()
    spikes: MarkerSpikes = field(default_factory=MarkerSpikes)

    @property
    def trial(self) -> Trial:
        """As the model wants it."""
        return self.standard.trial

    @property
    def points(self) -> dict[str, Floats]:
        """(F, 3) mm by the model's names; knees are where alignment devices show them, if they have no marker."""
        return with_knees(marker_points(self.trial))


class KnownMeasures(NamedTuple):
    """A subject's measures, and whence they are.

    Attributes:
        measures: of the subject, without offsets from the standing trial.
        estimated: what of them nobody measured: "legs", "mass"; "knees", "ankles" whose widths no markers show.
        hips: what a functional trial shows of them; None where there is none.
    """

    measures: SubjectMeasures
    estimated: tuple[str, ...] = ()
    hips: HipsShown | None = None

    @property
    def width_mm(self) -> float:
        """Standard uncertainty of the widths of knee and ankle."""
        return WIDTH_SD_MM if "legs" in self.estimated else WIDTH_MM


class SubjectGait(NamedTuple):
    """The gait of all walks.

    Attributes:
        trials: of each walk. curves: over all strides. causes: (F, A) of the uncertainty by cause and name, of the
            first walk that has any. measures: with what the standing trial shows. axes: of joints, by what it does.
        clusters: that carry segments.
    """

    trials: tuple[GaitOfTrial, ...]
    curves: tuple[GaitCurves, ...]
    causes: Mapping[str, Mapping[str, Floats]]
    measures: SubjectMeasures
    axes: StaticAxes | None = None
    clusters: ClustersShown | None = None


def recorded(
    name: str, trial: Trial, markers: Mapping[str, str], settings: GaitSettings, *, like: Recorded | None = None
) -> Recorded:
    """A file's trial as the gait model wants it.

    Args:
        name: of the file. trial: that it holds.
        markers: the trial's names by the model's, of those that are stated, with the subject's name or without it.
        settings: say which axis is up, and whose gait it is. like: the standing trial, whose axis counts where clusters
            carry the pelvis, or where this trial does not show one.

    Raises:
        KinemarkError: a stated marker is not there, no axis is up, or nobody says which of several subjects it is; the
            message begins with the name.
    """
    try:
        trial = of_one_subject(trial, settings.subject, markers)
        names = trial.trajectories.names
        plain = {without_subject(own): own for own in reversed(names)}
        there = {marker: full for marker, own in markers.items() if (full := own if own in names else plain.get(own))}
        found = standard_trial(trial, markers=there, up=settings.up)
        hidden = like is not None and ("pelvis" in like.clusters or not shows_up(marker_points(found.trial)))
        if like is not None and hidden and settings.up == "auto":
            found = standard_trial(trial, markers=there, turn=like.standard.turn)
        clean, spikes = without_spikes(found.trial)
        return Recorded(name, trial, found._replace(trial=clean), spikes=spikes)
    except KinemarkError as error:
        raise KinemarkError(f"{name}: {error}") from None


def completed(walk: Recorded, static: Recorded | None) -> Recorded:
    """A walk with the landmarks that clusters carry, and with the heels that only the standing trial has.

    Raises:
        KinemarkError: a marker of a cluster or of the model is not there, or a leg is none of a person's; the message
            begins with the walk's name.
    """
    try:
        if static is not None and static.clusters:
            walk = replace(walk, standard=with_landmarks(walk.standard, static.points, static.clusters))
        if static is not None:
            walk = replace(walk, standard=with_heels(walk.standard, static.points))
        walk = replace(walk, standard=with_absent_leg(walk.standard))
        check_markers(walk.points)
        check_legs(walk.points)
    except KinemarkError as error:
        called = ", ".join(f"{marker} = {own}" for marker, own in sorted(renamed(walk).items()))
        taken = f" Taken for the model's were {called}." if called else ""
        raise KinemarkError(f"{walk.name}: {error}{taken}{_more_clusters(walk, static)}") from None
    return walk


def _more_clusters(walk: Recorded, static: Recorded | None) -> str:
    """Of which segments clusters are missing, where some are stated and do not carry all that the walk lacks."""
    if static is None or not static.clusters:
        return ""
    missing = uncarried(walk.points, with_wands(static.points), static.clusters)
    if not missing:
        return ""
    lacking = "; ".join(f"{segment}: {', '.join(markers)}" for segment, markers in missing.items())
    return (
        f" Clusters are stated of {', '.join(static.clusters)} alone; the standing trial shows what the walk lacks of "
        f'segments without one ({lacking}). State their clusters as well: --cluster "{next(iter(missing))}=A,B,C", in '
        "a session under [gait.clusters]."
    )


def renamed(*walks: Recorded) -> dict[str, str]:
    """The walks' names by the model's, where they differ."""
    known = {marker: name for walk in walks for marker, name in walk.standard.known.items()}
    return {marker: name for marker, name in known.items() if without_subject(name) != marker}


def known_measures(stated: SubjectMeasures | None, walks: Sequence[Recorded], static: Recorded | None) -> KnownMeasures:
    """What is stated; else of the static trial's file, else of the first walk's that states them; else estimated.

    Args:
        stated: by a person. walks, static: of the subject.

    Raises:
        KinemarkError: nobody states them and the markers do not show them.
    """
    files = [one for one in (static, *walks) if one is not None]
    found = stated or next((m for m in (measures_of(one.given.source) for one in files) if m is not None), None)
    if found is not None:
        return KnownMeasures(found)
    masses = [m for m in (_mass(walk) for walk in walks) if m is not None]
    mass = float(np.median(masses)) if masses else None
    points = (static or walks[0]).points
    parts = ("legs", *([] if mass is None else ["mass"]), *joints_by_share(points))
    return KnownMeasures(estimated_measures(points, mass_kg=mass), parts)


def with_hips(known: KnownMeasures, functional: Recorded, settings: GaitSettings) -> KnownMeasures:
    """The measures with the hips that a motion shows.

    Args:
        known: of the subject. functional: the motion. settings: how.

    Raises:
        KinemarkError: it does not show them; the message begins with its name.
    """
    try:
        found = [functional_hip(functional.points, side, tissue_mm=settings.tissue_mm) for side in SIDES]
        points = functional.points
        pair = [lower_limbs(points, m, hip_centre=settings.made.mechanics.hip_centre)
                for m in (known.measures, with_functional_hips(known.measures, found))]  # fmt: skip
    except KinemarkError as error:
        raise KinemarkError(f"{functional.name}: {error}") from None
    away = [float(np.nanmedian(np.linalg.norm(pair[0].leg(s).hip - pair[1].leg(s).hip, axis=-1))) for s in SIDES]
    sd = float(np.sqrt(np.mean([hip.sd**2 for hip in found])))
    shown = HipsShown(functional.name, found[0].way, sd, max(away))
    return known._replace(measures=with_functional_hips(known.measures, found), hips=shown)


def subject_gait(
    walks: Sequence[Recorded], known: KnownMeasures, static: Recorded | None, settings: GaitSettings,
    mvc: Trial | None = None,
) -> SubjectGait:  # fmt: skip
    """Gait of all walks.

    Args:
        walks: of one subject, complete. known: the subject's measures. static: a standing trial. settings: how.
        mvc: of the muscles' greatest contractions, whose envelopes' greatest values are 100 %.

    Raises:
        KinemarkError: the standing trial does not show a foot, or a plate cannot be read.
    """
    measures, axes = (known.measures, None) if static is None else _standing(known.measures, static, settings)
    causes: dict[str, dict[str, Floats]] = {}
    body = None if static is None else _body(static, measures, settings)
    trials = []
    for walk in walks:
        own = _uncertain(walk.trial, known, static, settings)
        found = gait_of_trial(walk.trial, measures, settings, own, body)
        trials.append(found._replace(spikes=walk.spikes))
        causes = causes or own
    counted = with_counts([one.strides for one in trials])
    trials = [one._replace(strides=strides) for one, strides in zip(trials, counted, strict=True)]
    trials = [one._replace(keys=key_values(one.gait.signals, one.counted)) for one in trials]
    whole = _whole(trials, settings, mvc)
    each = [(*gait_curves(along_way(one.gait), one.counted), *emg_curves(one.emg, one.counted, whole=whole))
            for one in trials]  # fmt: skip
    return SubjectGait(tuple(trials), joined_curves(each), causes, measures, axes, _shown(walks, static, body))


def _body(static: Recorded, measures: SubjectMeasures, settings: GaitSettings) -> CalibratedBody | None:
    """What its clusters carry; None where it has none."""
    if not static.clusters:
        return None
    points, hip_centre = with_wands(static.points), settings.made.mechanics.hip_centre
    try:
        return calibrated_body(points, measures, static.clusters, hip_centre=hip_centre)
    except KinemarkError as error:
        raise KinemarkError(f"{static.name}: {error}") from None


def _shown(walks: Sequence[Recorded], static: Recorded | None, body: CalibratedBody | None) -> ClustersShown | None:
    """What is said of clusters; the worst misfit of all walks."""
    if static is None or body is None:
        return None
    misfits = [body.misfit(walk.points) for walk in walks]
    largest = {name: float(np.nanmax([one[name] for one in misfits])) for name in body.templates}
    clusters = {segment: tuple(static.clusters[segment]) for segment in static.by_names}
    return ClustersShown(static.name, largest, clusters)


def _whole(trials: Sequence[GaitOfTrial], settings: GaitSettings, mvc: Trial | None) -> dict[str, float]:
    """What of each channel is 100 %; nothing of those that their own greatest value of a walk is."""
    if mvc is not None:
        return greatest_contractions(mvc, {name for one in trials for name in one.emg})
    return dynamic_peaks([(one.emg, one.counted) for one in trials]) if settings.emg_to == "strides" else {}


def _standing(
    stated: SubjectMeasures, static: Recorded, settings: GaitSettings
) -> tuple[SubjectMeasures, StaticAxes | None]:
    """The measures with what a standing trial shows, and by what it shows axes."""
    points = static.points
    way = settings.axes_from(points)
    try:
        shown = with_static_offsets(
            stated, points, flat_foot=settings.flat_foot, hip_centre=settings.made.mechanics.hip_centre, axes=bool(way)
        )
    except KinemarkError as error:
        raise KinemarkError(f"{static.name}: {error}") from None
    return shown, StaticAxes(static.name, way, static_doubts(points, stated, shown)) if way else None


def gait_of_trial(
    trial: Trial, measures: SubjectMeasures, settings: GaitSettings, causes: Mapping[str, Mapping[str, Floats]],
    body: CalibratedBody | None = None,
) -> GaitOfTrial:  # fmt: skip
    """One walk: segments and loads with their error bars, events, strides, EMG.

    Args:
        trial: by the model's names, z up. measures: with offsets. settings: how. causes: of the uncertainty.
        body: clusters that show segments.

    Raises:
        KinemarkError: a marker is missing, or a plate cannot be read.
    """
    points, rate, method = marker_points(trial), trial.trajectories.rate, settings.made
    events = foot_events(trial, points)
    gait = analyse_gait(trial, measures, method=method, body=body)
    found = measured_only(gait, events, method.mechanics.counts, rate)
    if causes:
        found = replace(found, signals=with_uncertainty(found.signals, causes))
    floor = floor_velocity(events, points, rate=rate)
    placement = settings.placement_mm if settings.uncertainty else 0.0
    steps = strides(events, points, rate=rate, heel_sd_mm=_heel_sd(trial), placement_mm=placement, floor=floor)
    steps = with_facing(steps, gait.limbs.pelvis.R[..., 0], rate=rate, back=reversals(points))
    steps = with_standing(steps, stands(events, points, rate=rate, floor=floor))
    first, way = trial.trajectories.first_frame, way_of_walking(events, points, rate=rate)
    (names, leaps), muscles = doubted_markers(trial, points), emg_of(trial)
    return GaitOfTrial(
        trial.name, found, events, steps, trial.events, (first - 1) / rate, muscles, way, first, floor,
        leaps=leaps, names=names, plates=doubted_plates(trial, points, gait, events, way, measures.mass_kg),
        bare=next((side for side in SIDES if not leg_seen(points, side)), None), unseen=never_seen(points),
        no_emg=left_out_of(trial, muscles),
    )  # fmt: skip


def with_gait(walk: Recorded, result: GaitOfTrial) -> Trial:
    """The trial as it was read with its results among the signals, and its events where it had none."""
    events = walk.given.events if len(walk.given.events) else as_events(result.events, result.start_s)
    turn = walk.standard.turn
    signals = [
        replace(s, values=in_laboratory(s.values, turn), cov=turn @ s.cov @ turn.T)
        if s.name.endswith(REACTION) else s
        for s in result.gait.signals
    ]  # fmt: skip
    return replace(walk.given, signals=walk.given.signals.updated(Signals(tuple(signals))), events=events)


def as_events(events: Sequence[FootEvent], start_s: float) -> Events:
    """As files have them."""
    return Events(
        tuple("Foot Strike" if e.strike else "Foot Off" for e in events),
        tuple(e.side.title() for e in events),
        np.array([e.time + start_s for e in events]),
    )


def how(settings: GaitSettings, hips: HipsShown | None = None) -> dict[str, Any]:
    """What of the settings makes the method, by name; with hips that a motion has shown."""
    own = ("hip_centre", "inertia", "smoothing", "cutoff_hz", "force_cutoff_hz")
    names = (*own, "flat_foot") if settings.method == "physical" else ("flat_foot",)
    made = {"name": settings.method} | {name: getattr(settings, name) for name in names}
    return made if hips is None else made | {"hip_centre": f"functional, from {hips.trial}"}


def _mass(walk: Recorded) -> float | None:
    """kg by the plates of a walk."""
    if not walk.trial.plates or any(name not in walk.points for name in ("LHEE", "LTOE", "RHEE", "RTOE")):
        return None
    nobody = estimated_measures(walk.points)
    given = GaitSettings().made.inputs(walk.trial, walk.points, nobody)
    events, rate = foot_events(walk.trial, walk.points), walk.trial.trajectories.rate
    return mass_on_plates(given.reactions, given.contacts, events, rate=rate)


def _uncertain(
    trial: Trial, known: KnownMeasures, static: Recorded | None, settings: GaitSettings
) -> dict[str, dict[str, Floats]]:
    """By cause and name; empty where it is not asked for."""
    if not settings.uncertainty:
        return {}
    stood = None if static is None else static.points
    return gait_uncertainty(
        trial, known.measures, method=settings.made, errors=settings.errors(width_mm=known.width_mm), static=stood,
        flat_foot=settings.flat_foot, axes=bool(settings.axes_from(stood)),
        clusters=None if static is None else static.clusters,
    )  # fmt: skip


def _heel_sd(trial: Trial) -> float:
    """mm along an axis, as the heels' covariance states it; 0 where it states none."""
    heels = [path for path in trial.trajectories if path.name.endswith(("LHEE", "RHEE"))]
    variances = [np.diagonal(path.cov, axis1=1, axis2=2).ravel() for path in heels]
    return float(np.sqrt(finite_median(np.concatenate(variances), 0.0))) if variances else 0.0
