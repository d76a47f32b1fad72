"""What gait analysis says: figures by name, findings and the verdict."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from ..data import Finding, make_finding
from ..data.array_types import Floats
from ..data.gait_curves import GaitCurves, GaitReference, KeyValue
from ..data.strides import UNITS, Stride
from ..data.subject_measures import SIDES, SubjectMeasures
from ..gait.gait_cycles import most_typical
from ..gait.key_values import KEYS
from ..gait.turning import ways
from ..gait.way_of_walking import faced_aside
from ..numerics.finite import finite_mean
from ..version import __version__
from .gait_doubts import left_out_for, of_contacts, of_doubts, of_plates, of_spikes
from .gait_events import of_events, of_way
from .gait_muscles import of_contractions, of_muscles
from .gait_numbers import (
    averages_of,
    curve,
    harmonics,
    key_values,
    measures_of,
    profile,
    uncertainty_by_cause,
    ways_walked,
)
from .gait_records import ClustersShown, GaitOfTrial, GivenFiles, MeasuredSubject, StandingShown, StaticAxes
from .gait_strides import of_left_out, of_strides
from .gait_subjects import of_bodies, of_subjects
from .plain import SCHEMA_VERSION, plain, quantile
from .verdict import Verdict, verdict_of

CURVE_OF = {key.name: key.curve for key in KEYS}
"""What each key value is read off, without side; by definition."""
SIZE_OF = {"knee_width": "mm", "ankle_width": "mm", "device": "share"}
"""In which unit a doubt about a static trial is said; else in degrees."""
LOOSE_MM = 8.0
"""RMS misfit of a cluster's markers; chosen: of skin over the thigh of a walker it was 1.7 mm, of exchanged markers
tens."""
TURN_DEG = 30.0
"""By which the pelvis faces another way than where it walks, deg; chosen: in straight walks it was below 20."""


def gait_figures(
    trials: Sequence[GaitOfTrial],
    curves: Sequence[GaitCurves],
    causes: Mapping[str, Mapping[str, Floats]],
    *,
    subject: MeasuredSubject,
    method: Mapping[str, Any],
    standing: StandingShown | None = None,
    files: GivenFiles | None = None,
    reference: GaitReference | None = None,
    contractions: bool = False,
) -> dict[str, Any]:
    """Every figure of the page by name.

    Args:
        trials: results. curves: over all strides of all trials. causes: of the uncertainty, of the first trial.
        subject: whose gait it is. method: its name and parameters. standing: what a standing trial has shown; None
            where there is none. files: what they say; None where the walks are of no files.
        reference: band of controls. contractions: whether the EMG is in % of a trial of greatest contractions.
    """
    standing, files = standing or StandingShown(), files or GivenFiles()
    strides = [stride for trial in trials for stride in trial.counted]
    findings = [
        *files.left_out,
        *of_subjects(files.subjects),
        *of_bodies(files.bodies),
        *_of_files(subject, standing.heels, files.renamed),
        *([] if subject.hips is None else [make_finding("gait_hips_functional", **subject.hips._asdict())]),
        *([] if standing.axes is None else _of_axes(standing.axes)),
        *([] if standing.feet is None else [make_finding("gait_feet_otherwise", **standing.feet._asdict())]),
        *([] if standing.clusters is None else _of_clusters(standing.clusters)),
        *of_strides({trial.name: trial.strides for trial in trials}, files.paths),
        *_findings(trials, subject.measures, standing.name),
        *of_contractions(curves if contractions else ()),
        *_of_gaps(curves, [key for trial in trials for key in trial.keys]),
    ]
    uncertainty = uncertainty_by_cause(causes)
    figures = {
        "kinemark": __version__,
        "schema_version": SCHEMA_VERSION,
        "subject": subject.name,
        "trials": [_trial(one) for one in trials],
        "static": standing.name,
        "method": method,
        "measures": measures_of(subject.measures),
        "time_distance": {side: averages_of(strides, side) for side in SIDES},
        "key_values": key_values([key for trial in trials for key in trial.keys]),
        "ways": ways_walked(strides),
        "units": UNITS,
        "curves": [curve(one) for one in curves],
        "harmonics": harmonics(curves, strides),
        "typical_stride": {side: most_typical(curves, side) for side in SIDES},
        "profile": None if reference is None else profile(curves, reference),
        "uncertainty": uncertainty,
        "findings": [found.as_dict() for found in findings],
    }
    return plain(figures | {"verdict": _verdict(findings, strides, uncertainty).as_dict()})


def _trial(one: GaitOfTrial) -> dict[str, Any]:
    return {
        "name": one.name,
        "events": [
            {"side": e.side, "strike": e.strike, "time_s": round(e.time, 4), "sd_s": round(e.sd, 4), "from": e.source}
            for e in one.events
        ],
        "contacts": [
            {
                "plate": c.plate + 1,
                "first": c.first + 1,
                "last": c.stop,
                "side": c.side,
                "left_out": left_out_for(c),
            }
            for c in one.gait.contacts
        ],
        "strides": [
            {
                "side": s.side,
                "first_s": s.first,
                "last_s": s.last,
                "values": dict(s.values),
                "sd": dict(s.sd),
                "facing_deg": s.facing_deg,
                "turned_deg": s.turned_deg,
                "stands": s.stands,
                "counts": s.counts,
            }
            for s in one.strides
        ],
        "emg": {name: {"saturated_share": e.saturated, "hum_hz": e.hum_hz} for name, e in one.emg.items()},
    }


def _of_files(subject: MeasuredSubject, heels: Sequence[str], renamed: Mapping[str, str]) -> Iterator[Finding]:
    """What of the files was not as the model wants it."""
    if subject.estimated:
        mass = subject.measures.mass_kg if "mass" in subject.estimated else None
        widths = ("markers", "both", "share")[len({"knees", "ankles"} & set(subject.estimated))]
        yield make_finding("gait_measures_estimated", leg_mm=subject.measures.mean_leg_mm, mass_kg=mass, widths=widths)
    if heels:
        yield make_finding("gait_heels_from_static", markers=heels)
    if renamed:
        yield make_finding("gait_markers_renamed", names_list=[f"{a} = {b}" for a, b in sorted(renamed.items())])


def _of_axes(axes: StaticAxes) -> Iterator[Finding]:
    """By what axes are shown, and what of it cannot be."""
    yield make_finding("gait_axes_from_static", trial=axes.trial, way=axes.way)
    for doubt in axes.doubts:
        unit = SIZE_OF.get(doubt.what, "deg")
        mm, share, deg = (doubt.value if unit == one else None for one in ("mm", "share", "deg"))
        yield make_finding(
            "gait_axes_doubtful", trial=axes.trial, side=doubt.side, what=doubt.what, by_mm=mm, by_share=share,
            by_deg=deg,
        )  # fmt: skip


def _of_clusters(clusters: ClustersShown) -> Iterator[Finding]:
    """Which segments they carried, and those whose markers moved against each other."""
    known = {name: mm for name, mm in clusters.misfit_mm.items() if np.isfinite(mm)}
    names = list(clusters.misfit_mm)
    worst = max(known.values(), default=None)
    yield make_finding("gait_clusters", trial=clusters.trial, segments_list=names, misfit_mm=worst)
    if clusters.by_names:
        told = [f"{segment} = {', '.join(own)}" for segment, own in clusters.by_names.items()]
        yield make_finding("gait_clusters_by_names", clusters_list=told)
    for name, mm in known.items():
        if mm > LOOSE_MM:
            yield make_finding("gait_cluster_loose", trial=clusters.trial, segment=name, misfit_mm=mm)


def _findings(trials: Sequence[GaitOfTrial], measures: SubjectMeasures, static: str | None) -> Iterator[Finding]:
    for trial in trials:
        yield from _of_trial(trial)
    if static is None and measures.left.plantar_offset_deg is None:
        yield make_finding("foot_offsets_unknown")
    if why := _no_moments(trials, measures):
        yield make_finding("gait_without_moments", why=why)


def _of_gaps(curves: Sequence[GaitCurves], keys: Sequence[KeyValue]) -> Iterator[Finding]:
    """Strides of whose angles a part is not known, and key values that a few samples cost.

    Angles that no stride has are of markers that nobody wore."""
    for side in SIDES:
        angles = [one for one in curves if one.side == side and one.unit == "deg" and np.isfinite(one.values).any()]
        if not angles:
            continue
        whole = np.all([one.whole for one in angles], axis=0)
        if not whole.all():
            short = [one for one in angles if not one.whole.all()]
            unknown = float(np.mean([np.isnan(one.values).any(2).mean() for one in short]))
            joints = [_joint(one.name[1:]) for one in short]
            yield make_finding(
                "gait_angles_with_gaps", side=side, cut=int((~whole).sum()), strides=len(whole), joints_list=joints,
                unknown_share=unknown,
            )  # fmt: skip
        gappy = {one.name[1:] for one in angles if one.whole.all() and np.isnan(one.values).any()}
        lost = {k.name for k in keys if k.side == side and np.isnan(k.value) and CURVE_OF[k.name] in gappy}
        if lost:
            joints = sorted({_joint(CURVE_OF[name]) for name in lost})
            yield make_finding("gait_key_values_with_gaps", side=side, missing=len(lost), curves_list=joints)


def _joint(angle: str) -> str:
    """What the angles are called, as "foot progression"."""
    name = angle.removesuffix("Angles").lower()
    return "foot progression" if name == "footprogress" else name


def _of_trial(trial: GaitOfTrial) -> Iterator[Finding]:
    yield from of_spikes(trial.name, trial.spikes, trial.first_frame)
    yield from of_doubts(trial.name, trial.names, trial.leaps)
    yield from of_plates(trial.name, trial.plates, trial.gait.reactions)
    yield from of_events(trial.name, trial.events, trial.file_events, trial.start_s, trial.bare)
    if trial.bare is not None:
        yield make_finding("gait_one_leg", trial=trial.name, side=trial.bare)
    if trial.unseen:
        yield make_finding("gait_markers_never_seen", trial=trial.name, markers=trial.unseen)
    yield from of_way(trial.name, trial.way, trial.floor)
    yield from of_contacts(trial.name, trial.gait.contacts, trial.bare, trial.first_frame)
    yield from of_muscles(trial.name, trial.emg, trial.no_emg)
    yield from _of_ways(trial)


def _of_ways(trial: GaitOfTrial) -> Iterator[Finding]:
    """Whether the subject stands or turns, what of that is left out, and which ways it walks."""
    yield from of_left_out(trial.name, trial.strides)
    if len(each := ways(trial.counted)) > 1:
        told = [f"{own[0].facing_deg:z.0f}° in {len(own)} stride{'s' * (len(own) > 1)}" for own in each]
        yield make_finding("gait_ways", trial=trial.name, ways_list=told)
    if not trial.names.exchanged and (turned := _turned(trial)) > TURN_DEG:
        yield make_finding("gait_turns", trial=trial.name, turned_deg=turned)


def _turned(trial: GaitOfTrial) -> float:
    """deg by which the pelvis faces aside, of its mean or of its direction of progression, most of the time at most;
    of the strides that count, where others were left out, and not of its mean."""
    if "LPelvisAngles" not in trial.gait.signals.names:
        return 0.0
    signal = trial.gait.signals["LPelvisAngles"]
    off = np.abs(signal.values[:, 2])
    if trial.counted == trial.strides:
        return max(quantile(off, 0.9), quantile(faced_aside(trial.gait.limbs.pelvis.R[..., 0]), 0.9))
    time = np.arange(len(off)) / signal.rate
    inside = np.any([(time >= one.first) & (time <= one.last) for one in trial.counted], axis=0)
    return quantile(off[inside], 0.9) if np.any(inside) else 0.0


def _no_moments(trials: Sequence[GaitOfTrial], measures: SubjectMeasures) -> str:
    """Why there are none; empty where there are some."""
    if not any(trial.gait.reactions for trial in trials):
        return "plates"
    if measures.mass_kg is None:
        return "mass"
    whole = any(c.side and c.reason in ("", "cut", "shared") for trial in trials for c in trial.gait.contacts)
    return "" if whole else "contacts"


def _verdict(
    findings: Sequence[Finding], strides: Sequence[Stride], uncertainty: Sequence[Mapping[str, Any]]
) -> Verdict:
    grades = {found.severity for found in findings}
    wrong = any(found.kind == "gait_markers_exchanged" for found in findings)
    kind = "gait_usable" if "amber" in grades else "gait_good"
    kind = ("gait_unusable" if wrong else "gait_missing") if "red" in grades else kind
    statements = [make_finding(kind)]
    if strides:
        count = {side: sum(s.side == side for s in strides) for side in SIDES}
        statements.append(
            make_finding(
                "gait_measured", left_strides=count["left"], right_strides=count["right"],
                speed=finite_mean(np.array([s.values["speed"] for s in strides])) / 1000,
                cadence=finite_mean(np.array([s.values["cadence"] for s in strides])),
            )
        )  # fmt: skip
    rows = {row["name"]: row["by_cause"] for row in uncertainty}
    knees = (rows.get(name, {}) for name in ("LKneeAngles", "RKneeAngles"))
    knee: Mapping[str, Floats] = next((one for one in knees if any(np.isfinite(e[0]) for e in one.values())), {})
    squares = {cause: each[0] ** 2 for cause, each in knee.items() if np.isfinite(each[0])}
    if (total := sum(squares.values())) > 0:
        cause = max(squares, key=lambda c: squares[c])
        statements.append(
            make_finding("gait_deviations", knee_deg=total**0.5, cause=cause, variance_share=squares[cause] / total)
        )
    return verdict_of(findings, statements)
