"""Clusters that names tell, clusters called as the file calls them, which way is up where walks have no ankles."""

from dataclasses import replace

import numpy as np
import pytest

from kinemark.data import KinemarkError
from kinemark.data.laboratory_axes import level_axes, turned
from kinemark.engine.gait.files import gait_of_files
from kinemark.engine.gait.settings import GaitSettings
from kinemark.engine.gait.trial_files import SubjectFiles
from kinemark.gait.clusters import usual_clusters
from kinemark.gait.marker_leaps import marker_leaps
from kinemark.io.c3d import write_c3d
from support.clustered import MEASURES, called, clusters, laboratory

LEGS = ("left thigh", "left shank", "right thigh", "right shank")
NO_WANDS = tuple(side + name for side in "LR" for name in ("THI", "TIB"))
BARE = tuple(side + name for side in "LR" for name in ("THI", "KNE", "TIB", "ANK"))
QUICK = GaitSettings(smoothing="none", uncertainty=False)
ISB = {"KNE": "FLE", "KNM": "FME", "ANK": "FAL", "MED": "TAM", "HEE": "FCC", "TOE": "FM2", "TH1": "FTC", "SK1": "FAX",
       "SK2": "TTC", "TH2": "q", "TH3": "r", "TH4": "s", "SK3": "t", "SK4": "u"}  # fmt: skip


def report(folder, lab, *, change=lambda trial: trial, settings=QUICK, clusters=None):
    folder.mkdir()
    for trial in (lab.walk, lab.static):
        write_c3d(folder / f"{trial.name}.c3d", change(trial))
    given = SubjectFiles(
        [folder / "walk.c3d"], static=folder / "static.c3d", measures=MEASURES, clusters=clusters or {}
    )
    return gait_of_files(given, folder=folder / "out", settings=settings)


def off(lab, result, names=("HipAngles", "KneeAngles", "AnkleAngles")):
    """Greatest difference from the truth, deg."""
    found = result.trials[0].gait.signals
    return max(np.nanmax(np.abs(found[s + n].values - lab.signals[s + n].values)) for s in "LR" for n in names)


def test_numbered_markers_of_a_segment_stand_for_the_wands(tmp_path):
    lab = laboratory(LEGS, unworn=NO_WANDS)
    result = report(tmp_path / "a", lab)
    assert off(lab, result) < 0.02  # C3D holds single precision
    told = {f["kind"]: f for f in result.figures["findings"]}
    assert "left thigh = LTH1, LTH2, LTH3, LTH4" in told["gait_clusters_by_names"]["text"]
    assert sorted(told["gait_clusters"]["values"]["segments_list"]) == sorted(LEGS)
    with pytest.raises(KinemarkError, match="LTHI, LTIB, RTHI, RTIB"):  # that program knows no clusters
        report(tmp_path / "b", lab, settings=GaitSettings(method="plug_in_gait", uncertainty=False))


def test_landmarks_of_the_isb_are_clusters_by_themselves(tmp_path):
    """Trochanter and epicondyles; head of the fibula, tuberosity and malleoli; in the walk too."""
    lab = laboratory(LEGS, unworn=NO_WANDS)
    body = replace_worn(lab)
    names = {side + ours: f"{side}_{theirs}" for side in "LR" for ours, theirs in ISB.items()}
    result = report(tmp_path / "a", body, change=lambda trial: called(trial, names))
    assert off(lab, result) < 0.02
    told = next(f for f in result.figures["findings"] if f["kind"] == "gait_clusters_by_names")
    assert told["values"]["clusters_list"] == [
        "left thigh = L_FTC, LKNE, LKNM",
        "left shank = L_FAX, L_TTC, LANK, LMED",
        "right thigh = R_FTC, RKNE, RKNM",
        "right shank = R_FAX, R_TTC, RANK, RMED",
    ]


def replace_worn(lab):
    """The same laboratory where the walk too wears the inner markers, each where its own segment carries it."""
    stood = {p.name: p.xyz for p in lab.static.trajectories}
    walk = lab.walk.trajectories
    paths = list(walk.paths)
    for side in "LR":
        for inner, part in (("KNM", "TH"), ("MED", "SK")):
            plate = [f"{side}{part}{k}" for k in (1, 2, 3, 4)]
            paths.append(replace(walk[plate[0]], name=side + inner, xyz=carried(stood, walk, plate, side + inner)))
    return replace(lab, walk=replace(lab.walk, trajectories=replace(walk, paths=tuple(paths))))


def carried(stood, walk, plate, name):
    """(F, 3) mm of a point that a rigid plate carries."""
    at, now = np.array([np.median(stood[m], 0) for m in plate]), np.array([walk[m].xyz for m in plate])
    U, _, Vt = np.linalg.svd(np.einsum("kfi,kj->fij", now - now.mean(0), at - at.mean(0)))
    R = U @ np.diag([1, 1, 1.0]) @ Vt
    return (R @ (np.median(stood[name], 0) - at.mean(0))) + now.mean(0)


def test_markers_of_a_stated_cluster_are_called_as_the_files_call_them(tmp_path):
    lab = laboratory(LEGS, unworn=NO_WANDS)
    names = {side + ours: f"{side}_{theirs}" for side in "LR" for ours, theirs in ISB.items() if ours in ("KNE", "ANK")}
    stated = {"left thigh": ("L_FLE", "LTH1", "LTH2"), "right thigh": ("RKNE", "RTH1", "RTH2")}
    result = report(tmp_path / "a", lab, change=lambda trial: called(trial, names), clusters=stated)
    assert off(lab, result) < 0.02


def test_up_is_where_the_feet_are_not_where_a_walk_has_no_ankles(tmp_path):
    """A laboratory whose y goes up; shanks follow clusters, and no walk wears ankles."""
    lab = laboratory(LEGS, unworn=BARE)
    y_up = level_axes(np.array([0.0, 1.0, 0.0])).T
    result = report(tmp_path / "a", lab, change=lambda trial: turned(trial, y_up), clusters=clusters(LEGS))
    assert off(lab, result, ("PelvisAngles", "KneeAngles", "FootProgressAngles")) < 0.02
    assert "gait_not_level" not in {f["kind"] for f in result.figures["findings"]}


def test_no_cluster_of_segments_that_have_a_wand_or_too_few_markers():
    walk = ["LASI", "RASI", "SACR", "LTHI", "LKNE", "LTIB", "LANK", "LHEE", "LTOE", "LTH1", "LTH2", "LTH3", "RKNE",
            "RANK", "RHEE", "RTOE", "R_FTC", "R_FAX", "R_TTC"]  # fmt: skip
    found = usual_clusters(walk, [*walk, "RTHI", "RTIB"], {})
    assert found == {"right shank": ("R_FAX", "R_TTC", "RANK")}
    assert usual_clusters(walk, [*walk, "RTHI", "RTIB"], {"right shank": ("A", "B", "C")}) == {}
    assert usual_clusters(walk, walk, {}) == {}  # the standing trial shows no wand either


@pytest.mark.parametrize("rate", [50.0, 100.0, 250.0])
def test_a_leap_is_told_and_a_quick_foot_is_none(rate):
    t = np.arange(2 * rate) / rate
    foot = np.stack([300 * np.sin(2 * np.pi * 2 * t), 0 * t, 40 * np.sin(2 * np.pi * 6 * t)], -1)  # 3 m/s, 6 g
    assert marker_leaps({"LTOE": foot, "LHEE": foot}, ("LTOE", "RTOE"), rate=rate).markers == ()
    wrong = foot.copy()
    wrong[int(rate)] += [0, 120.0, 0]
    found = marker_leaps({"LTOE": wrong, "LHEE": foot}, ("LTOE", "LHEE"), rate=rate)
    assert found.markers == ("LTOE",) and 1 <= found.frames <= 3 and found.most_mm > 200
