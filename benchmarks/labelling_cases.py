"""Templates and the trials that they label: real ones, synthetic ones, of the same subject, of others, and wrong ones.

Real trials come from KINEMARK_DATA (default ../shared/data); those that are absent are left out.

Wrong names in them are mended, see `mended_references.py`.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from mended_references import mended

from kinemark.data import MarkerSet, MarkerTrajectory, Trajectories
from kinemark.engine.put_aside import put_aside
from kinemark.io.marker_sets import read_marker_set
from kinemark.io.trial import read_trial
from kinemark.label import Template, learn_template, static_template, template_of_subjects
from kinemark.synth import walking, with_markers

ROOT = Path(os.environ.get("KINEMARK_DATA", Path(__file__).parents[2] / "shared" / "data")) / "mocap3d"
MARKERS_OF_CHILD = """
    LFHD LBHD RFHD RBHD C7 T2 T6 T10 T12 RBAK CLAV STRN LSHO LELB LWRA LWRB LFIN RSHO RELB RWRA RWRB RFIN SACR RASI
    LASI LTHI LKNE LHFB LTUB LTIB LSHN LANK LHEE LCPG LLCA LSTL LNAV LP1M LP5M LD5M LTOE LHLX RTHI RKNE RHFB RTUB RTIB
    RSHN RANK RHEE RCPG RLCA RSTL RNAV RP1M RP5M RD5M RTOE RHLX"""
CHILD = tuple(MARKERS_OF_CHILD.split())
CHILDREN = {
    "HC030A": ("pig_gait_child", "05", "22", "01"),
    "HC002D": ("pig_gait_children", "06", "25", "02"),
    "HC031A": ("pig_gait_children", "06", "23", "01"),
    "HC032A": ("pig_gait_children", "03", "18", "01"),
    "HC033A": ("pig_gait_children", "10", "22", "01"),
}
"""Folder, a walk, another, and the static trial of each."""
GAIT, PLATES = "qualisys_gait/Gait - CGM2 1.c3d", "pig_gait_3plates_emg/PiG_"
"""A gait trial; the beginning of another laboratory's."""
TUNED_CHILDREN = {"HC030A", "HC002D", "HC031A"}
"""Every row with another child, as template or as trial, is a check."""
SIDE = {
    "thigh": "THI KNE THAP HTAD THAD KNM",
    "shank": "HFB TUB TIB SHN ANK TIAP TIAD KNE KNM MED",
    "foot": "ANK HEE CPG LCA STL NAV P1M D1M P5M D5M TOE FMH SMH VMH MED",
    "upper arm": "SHO UPA ELB",
    "forearm": "ELB FRM WRA WRB",
    "hand": "WRA WRB FIN",
}
BODY = {
    "head": "LFHD LBHD RFHD RBHD",
    "trunk": "C7 T2 T6 T10 T12 RBAK CLAV STRN",
    "pelvis": "LASI RASI LPSI RPSI SACR",
}
SEGMENTS = {name: markers.split() for name, markers in BODY.items()} | {
    f"{side} {name}": [side + marker for marker in markers.split()] for side in "LR" for name, markers in SIDE.items()
}
MEET = {
    "neck": ("head", "trunk"),
    "back": ("trunk", "pelvis"),
    **{
        f"{side} {joint}": (one if one in BODY else f"{side} {one}", f"{side} {other}")
        for side in "LR"
        for joint, one, other in (
            ("hip", "pelvis", "thigh"), ("knee", "thigh", "shank"), ("ankle", "shank", "foot"),
            ("shoulder", "trunk", "upper arm"), ("elbow", "upper arm", "forearm"), ("wrist", "forearm", "hand"),
        )
    },
}  # fmt: skip
STATIC = 0.14
"""Relative spread of distances that a static trial does not show ; chosen, see docs/theory/label.md."""


class Row(NamedTuple):
    """A template, and the trial that it labels, with its names.

    Attributes:
        tuned: probabilities are fitted to it. nameless: it has what nobody named, so that no ghosts are added.
        wider: see `label.bystanders`.
    """

    name: str
    template: Template
    trial: Trajectories
    fits: bool = True
    tuned: bool = False
    nameless: bool = False
    wider: Template | None = None


class Shredding(NamedTuple):
    """How a trial is made into tracks: arguments of `shredded`."""

    pieces: int = 1
    ghosts: float = 2.0
    kinds: tuple[Any, ...] = ("walk",)
    absent: int = 0
    extra: int = 0
    still: int = 0


MIXED = ("walk", "midpoint", "reflection")
TWINS = (*MIXED, "twin")
VARIED = (
    Shredding(1, 2.0, MIXED),
    Shredding(4, 5.0, MIXED, absent=2, extra=2),
    Shredding(15, 1.0),
    Shredding(25, 3.0, MIXED, absent=3, extra=1),
    Shredding(40, 2.0, MIXED, extra=1),
    Shredding(8, 0.0, absent=4),
)
"""Ways of shredding; rows take them in turn."""


@cache
def read(file: str) -> Trajectories:
    """A trial of the data folder, with its names mended."""
    return mended(file, read_trial(ROOT / file).trajectories)


def only(trial: Trajectories, names: Sequence[str]) -> Trajectories:
    """Those of the markers that the trial has."""
    return trial.select([name for name in names if name in trial.names])


def child(name: str, trial: int) -> Trajectories:
    """A child's first or second walk (0, 1) or static trial (2)."""
    folder, *trials = CHILDREN[name]
    return only(read(f"{folder}/{name}{trials[trial]}.c3d"), CHILD)


def with_one_beside(trial: Trajectories, name: str, mm: float, seed: int) -> Trajectories:
    """The marker taken off, and another, `+1`, worn so far beside its place.

    It is fixed to the three markers that keep their distance to that place best.
    """
    i, xyz = trial.names.index(name), trial.xyz
    d = np.linalg.norm(xyz - xyz[i], axis=2)
    d[i] = np.nan
    spread = np.array([one[np.isfinite(one)].std() if np.isfinite(one).any() else np.inf for one in d])
    p = xyz[np.argsort(spread)[:3]]
    x = p[1] - p[0]
    z = np.cross(x, p[2] - p[0])
    axes = np.stack([one / np.linalg.norm(one, axis=1, keepdims=True) for one in (x, np.cross(z, x), z)])
    u = np.random.default_rng([seed, i]).normal(size=3)
    off = np.einsum("i,ifj->fj", mm * u / np.linalg.norm(u), axes)
    other = MarkerTrajectory.measured("+1", xyz[i] + off)
    return replace(trial, paths=tuple(other if path.name == name else path for path in trial))


def height(trial: Trajectories) -> float:
    """Head to heel, mm: what one would measure of a subject."""
    ends = [(a, b) for a in ("LFHD", "RFHD") for b in ("LHEE", "RHEE")]
    return max(float(np.nanmedian(np.linalg.norm(trial[a].xyz - trial[b].xyz, axis=1))) for a, b in ends)


def rows() -> Iterator[Row]:
    """All cases of the tables whose files are here."""
    if ROOT.is_dir():
        yield from same_subject()
        yield from static_trials()
        yield from static_sets()
        yield from few_markers()
        yield from other_child("HC030A")
        yield from several_children()
        yield from all_other_children()
        yield from whole_files()
        yield from wrong_templates()
    yield from walkers()


def more_rows() -> Iterator[Row]:
    """Further ones, by which probabilities are fitted and checked."""
    if ROOT.is_dir():
        for one in tuple(CHILDREN)[1:]:
            yield from other_child(one)
        yield from placed_otherwise()
        yield from halves()
        yield from static_children()
    yield from walkers_of_many_kinds()


def walkers() -> Iterator[Row]:
    """One synthetic walk labels another."""
    for n in (15, 39):
        for seed in (1, 2, 3):
            one, two = (_walk(k, n, seed) for k in (seed, seed + 10))
            yield Row(f"walker {n} seed {seed}", learn_template(one), two, tuned=seed == 1)


def _walk(walk: int, n: int, seed: int, **more: Any) -> Trajectories:
    """A walker with n markers, placed by `seed`."""
    subject = walking(**({"duration_s": 4, "rate": 100.0, "seed": walk, "wobble_mm": 1.0} | more))
    return with_markers(subject, n, seed=seed).trajectories


def walkers_of_many_kinds() -> Iterator[Row]:
    """Other sizes, rates and marker numbers; templates of a static posture of the walk, of another's size, scaled."""
    for k, (n, rate) in enumerate(((15, 50.0), (15, 200.0), (22, 100.0), (39, 120.0), (53, 100.0))):
        one, two = (_walk(s, n, k, rate=rate, duration_s=3.0, wobble_mm=2.0) for s in (k, k + 20))
        tuned, name = k % 2 == 0, f"walker {n}, {rate:g} Hz"
        yield Row(name, learn_template(one), two, tuned=tuned)
        yield Row(f"{name}, one frame", learn_template(one.frames(0, 1), relative_spread=STATIC), two, tuned=tuned)
        yield Row(f"{name}, scaled", learn_template(one).of_another(1.03), two, tuned=tuned)


def same_subject() -> Iterator[Row]:
    """Another trial, or the other half of one."""
    for name, (_, one, two, _) in CHILDREN.items():
        a, b, tuned = child(name, 0), child(name, 1), name in TUNED_CHILDREN
        yield Row(f"{name}{one} labels {two}", learn_template(a), b, tuned=tuned)
        yield Row(f"{name}{two} labels {one}", learn_template(b), a, tuned=tuned)
    gait, prone = read("qualisys_gait/Gait - CGM2 1.c3d"), read("labelling/PronetoRun01.c3d")
    yield Row("qualisys, first half labels second", learn_template(gait.frames(0, 172)), gait.frames(172, 344))
    yield Row(
        "prone to run, end labels begin", learn_template(prone.frames(626, 1253)), prone.frames(0, 626), tuned=True
    )
    move = only(read("pig_wholebody/Movement_trial.c3d"), list(whole_body().names))
    yield Row("whole body, first half labels second", learn_template(move.frames(0, 160)), move.frames(160, 323))


def whole_body() -> Trajectories:
    static = read("pig_wholebody/Static_trial.c3d")
    return replace(static, paths=static.paths[:39])  # the markers; the others are segments' axes and ghosts


def halves() -> Iterator[Row]:
    """Other laboratories' trials, by their other half."""
    for file, tuned in (
        ("fullbody_cmu/85_02.c3d", True),
        ("gait_emg_ccby/2014001_C1_01.c3d", False),
        ("tennis_serve_gap_pair/kinematics_tennis_serve.c3d", False),
        ("arm_box_lift_gaps/Vicon.c3d", False),
    ):
        trial = read(file)
        middle, name = trial.n_frames // 2, file.split("/")[0]
        a, b = trial.frames(0, middle), trial.frames(middle, trial.n_frames)
        yield Row(f"{name}, first half labels second", learn_template(a), b, tuned=tuned)
        yield Row(f"{name}, second half labels first", learn_template(b), a, tuned=tuned)


def whole_files() -> Iterator[Row]:
    """Walks with what is left of computed points beside the markers, as `kinemark label` sees them."""
    for name in ("HC032A", "HC033A"):
        folder, one, two, _ = CHILDREN[name]
        a, b = (_without_computed(f"{folder}/{name}{trial}.c3d") for trial in (one, two))
        yield Row(f"{name}{one} labels {two}, whole files", learn_template(a), b)


def _without_computed(file: str) -> Trajectories:
    return only(
        read(file), [name for name in put_aside(read_trial(ROOT / file)).rest.names if not name.startswith("*")]
    )


def static_trials() -> Iterator[Row]:
    """A static trial and segments."""
    gait, move = read("qualisys_gait/Gait - CGM2 1.c3d"), read("pig_wholebody/Movement_trial.c3d")
    body = whole_body()
    for name, static, trial, tuned in (
        ("HC030A static", child("HC030A", 2), child("HC030A", 1), False),
        ("qualisys static", read("qualisys_gait/Static - CGM2 1.c3d"), gait, False),
        ("whole body static", body, only(move, list(body.names)), True),
    ):
        yield Row(f"{name}, segments", static_template(static, segmented(static)), trial, tuned=tuned)


def segmented(static: Trajectories) -> MarkerSet:
    """The markers of a static trial, on the segments that they sit on, and which of these meet."""
    segments = {key: tuple(name for name in own if name in static.names) for key, own in SEGMENTS.items()}
    segments = {key: own for key, own in segments.items() if own}
    return MarkerSet(
        static.names,
        segments,
        joints={key: both for key, both in MEET.items() if set(both) <= segments.keys()},
    )


def static_sets() -> Iterator[Row]:
    """A static trial and a marker set that is shipped, whose segments have hands and whose joints say what meets."""
    body, move = whole_body(), read("pig_wholebody/Movement_trial.c3d")
    trials = [
        ("whole body", "plug-in-gait-full", body, move),
        ("whole body", "plug-in-gait-lower", body, move),
        ("qualisys", "plug-in-gait-full", read("qualisys_gait/Static - CGM2 1.c3d"), read(GAIT)),
        ("three plates", "plug-in-gait-lower", read(f"{PLATES}Calibration3_FF.c3d"), read(f"{PLATES}Motion3_FF.c3d")),
        *((name, "plug-in-gait-full", child(name, 2), child(name, 0)) for name in CHILDREN),
        *((name, "kiss-15", child(name, 2), child(name, 0)) for name in tuple(CHILDREN)[:2]),
    ]
    for name, of, static, trial in trials:
        template = static_template(static, read_marker_set(of))
        tuned = name in {*TUNED_CHILDREN, "whole body"}
        yield Row(f"{name} static, {of}", template, only(trial, template.names), tuned=tuned)


def few_markers() -> Iterator[Row]:
    """A static trial and 15 markers: children and walks that `static_sets`, which shreds are drawn from, has not."""
    worn = read_marker_set("kiss-15")
    for k, name in enumerate(CHILDREN):
        for walk in (0, 1) if k > 1 else (1,):
            template = static_template(child(name, 2), worn)
            title, trial = f"{name} static, kiss-15, walk {walk + 1}", only(child(name, walk), template.names)
            yield Row(title, template, trial, tuned=name in TUNED_CHILDREN)


def static_children() -> Iterator[Row]:
    """A static trial, with and without segments."""
    for name in tuple(CHILDREN)[1:]:
        static = child(name, 2)
        for words, template in (
            ("segments", static_template(static, segmented(static))),
            ("no segments", learn_template(static, relative_spread=STATIC)),
        ):
            yield Row(f"{name} static, {words}", template, child(name, 0), tuned=name in TUNED_CHILDREN)


def other_child(one: str) -> Iterator[Row]:
    """The template of one child, scaled by height, labels the others."""
    template, tall = learn_template(child(one, 0)), height(child(one, 0))
    for name in CHILDREN:
        if name != one:
            trial = child(name, 0)
            scaled = template.of_another(height(trial) / tall)
            yield Row(f"other child {one} labels {name}", scaled, trial, tuned={one, name} <= TUNED_CHILDREN)


def several_children() -> Iterator[Row]:
    """The template of the three children that are tuned on, or of two of them for the third, each scaled by height."""
    for name in CHILDREN:
        trial = child(name, 0)
        others = sorted((child(one, 0) for one in TUNED_CHILDREN - {name}), key=height)
        learnt = [learn_template(one) for one in others]
        template = template_of_subjects(learnt, [height(one) for one in others], height(trial))
        yield Row(f"{len(others)} other children label {name}", template, trial, tuned=name in TUNED_CHILDREN)


def all_other_children() -> Iterator[Row]:
    """The template of all four others for each child, scaled by height."""
    for name in CHILDREN:
        others, trial = sorted((child(one, 0) for one in CHILDREN if one != name), key=height), child(name, 0)
        learnt = [learn_template(one) for one in others]
        template = template_of_subjects(learnt, [height(one) for one in others], height(trial))
        yield Row(f"all {len(others)} others label {name}", template, trial, tuned=True)


def placed_otherwise() -> Iterator[Row]:
    """Children whose markers sit a few centimetres beside where the template has them: further subjects."""
    for k, (name, mm) in enumerate((name, mm) for name in sorted(TUNED_CHILDREN) for mm in (5.0, 10.0, 15.0)):
        template = learn_template(child(name, 0)).of_another(1.0)
        yield Row(f"{name}, placed {mm:g} mm otherwise", template, _moved(child(name, 1), mm, k), tuned=True)
    template = learn_template(child("HC032A", 0)).of_another(1.0)
    for k, mm in enumerate((5.0, 10.0, 15.0), 50):
        yield Row(f"HC032A, placed {mm:g} mm otherwise", template, _moved(child("HC032A", 1), mm, k))


def _moved(trial: Trajectories, mm: float, seed: int) -> Trajectories:
    """Each marker moved by an offset that is fixed to it and the two markers nearest to it."""
    rng, xyz = np.random.default_rng(seed), trial.xyz
    d = np.nanmean(np.linalg.norm(xyz[:, None] - xyz[None], axis=3), axis=2) + np.diag(np.full(len(xyz), np.inf))
    near = np.argsort(d, axis=1)[:, :2]
    u, w = (xyz[near[:, k]] - xyz for k in (0, 1))
    x = u / np.linalg.norm(u, axis=2, keepdims=True)
    z = np.cross(u, w)
    z /= np.linalg.norm(z, axis=2, keepdims=True)
    axes = np.stack([x, np.cross(z, x), z], axis=2)
    offset = np.einsum("mk,mfkc->mfc", rng.normal(0, mm / np.sqrt(3), (len(xyz), 3)), axes)
    new = xyz + np.where(np.isfinite(offset), offset, 0.0)
    return replace(
        trial, paths=tuple(MarkerTrajectory.measured(p.name, one) for p, one in zip(trial, new, strict=True))
    )


def wrong_templates() -> Iterator[Row]:
    """Nothing should be named."""
    gait, prone = read("qualisys_gait/Gait - CGM2 1.c3d"), read("labelling/PronetoRun01.c3d")
    one = child("HC030A", 0)
    yield Row("wrong: child labels qualisys", learn_template(one), gait, fits=False, tuned=True)
    yield Row("wrong: prone labels qualisys", learn_template(prone), gait, fits=False)
    yield Row("wrong: qualisys labels prone", learn_template(gait), prone, fits=False)
