"""Segments by clusters against the truth of the virtual laboratory, and what is refused."""

from dataclasses import replace

import numpy as np
import pytest

from kinemark.apps.cli import app
from kinemark.data import KinemarkError
from kinemark.engine.gait.files import gait_of_files
from kinemark.engine.gait.settings import GaitSettings
from kinemark.engine.gait.trial_files import SubjectFiles
from kinemark.gait import Physical, analyse_gait, clinical_angles, marker_points, with_static_offsets
from kinemark.gait.clusters import SEGMENTS, calibrated_body, with_wands
from kinemark.gait.standard_trial import standard_trial, with_landmarks
from kinemark.gait.uncertainty import GaitErrors, gait_uncertainty
from kinemark.io.c3d import write_c3d
from support.clustered import LANDMARKS, MEASURES, called, clusters, laboratory

EXACT = Physical(smoothing="none")


def by_clusters(lab, used, method=EXACT):
    """Gait of the walk, whose landmarks the clusters carry."""
    stood = marker_points(lab.static)
    known = with_static_offsets(MEASURES, stood, flat_foot=True)
    body = calibrated_body(with_wands(stood), known, used)
    walk = with_landmarks(standard_trial(lab.walk, turn=np.eye(3)), stood, used).trial
    return analyse_gait(walk, known, method=method, body=body)


def worst(lab, found, names):
    """Greatest difference from the truth of some angles, deg."""
    return max(
        np.nanmax(np.abs((found.signals[s + n].values - lab.signals[s + n].values + 180) % 360 - 180))
        for s in "LR" for n in names
    )  # fmt: skip


def test_inner_markers_stand_for_wands_that_were_left_off():
    used, knees = clusters(("left thigh",)), []
    whole = marker_points(laboratory(tuple(used), seconds=1.0).static)
    bare = {name: xyz for name, xyz in whole.items() if name[1:] not in ("THI", "TIB")}
    for stood in (whole, with_wands(bare)):
        known = with_static_offsets(MEASURES, stood, flat_foot=True)
        limbs = calibrated_body(stood, known, used).limbs(stood, known, hip_centre="davis")
        knees += [limbs.left.knee, limbs.right.knee]
    np.testing.assert_allclose(knees[2:], knees[:2], atol=1e-6)


ANGLES = ("PelvisAngles", "HipAngles", "KneeAngles", "AnkleAngles")


@pytest.mark.parametrize("segments", [SEGMENTS, SEGMENTS[1:], ("left thigh", "right shank"), ("pelvis",)])
def test_rigid_clusters_show_the_true_angles_without_any_landmark(segments):
    """Of the segments that wear one; the others by their own markers."""
    hidden = {
        "pelvis": LANDMARKS[:3],
        **{f"{one} {part}": tuple(one[0].upper() + name for name in names) for one in ("left", "right")
           for part, names in (("thigh", ("THI", "KNE")), ("shank", ("TIB", "ANK")), ("foot", ("HEE", "TOE")))},
    }  # fmt: skip
    lab = laboratory(segments, unworn=tuple(name for segment in segments for name in hidden[segment]))
    found = by_clusters(lab, clusters(segments))
    assert worst(lab, found, ANGLES) < 1e-6
    for side in ("left", "right"):
        np.testing.assert_allclose(found.limbs.leg(side).knee, lab.limbs.leg(side).knee, atol=1e-6)


def test_moments_by_clusters_are_the_true_ones():
    lab = laboratory()
    found = by_clusters(lab, clusters())
    contact = next(one for one in found.contacts if one.side == "left" and not one.reason)
    frames = slice(contact.first + 2, contact.stop - 2)
    for name in ("LHipMoment", "LKneeMoment", "LAnkleMoment"):
        true = lab.signals[name].values[frames]
        assert np.abs(found.signals[name].values[frames] - true).max() < 0.01 * np.ptp(true)


def test_a_clusters_segment_does_not_follow_the_skin_at_its_landmarks():
    """Six degrees of freedom of its own: what moves KNE and THI over the bone is of no matter."""
    skin = {name: np.array([6.0, 3.0, -4.0]) for name in ("LTHI", "LKNE", "RTHI", "RKNE")}
    lab = laboratory(unworn=(), tissue_mm=skin)
    plain = analyse_gait(
        lab.walk, with_static_offsets(MEASURES, marker_points(lab.static), flat_foot=True), method=EXACT
    )
    assert worst(lab, plain, ("KneeAngles",)) > 1
    assert worst(lab, by_clusters(lab, clusters()), ("KneeAngles",)) < 1e-6


def files(tmp_path, lab):
    for trial in (lab.walk, lab.static):
        write_c3d(tmp_path / f"{trial.name}.c3d", trial)
    return [tmp_path / "walk.c3d"], tmp_path / "static.c3d"


def test_files_of_a_laboratory_with_clusters_become_a_report_that_says_so(tmp_path):
    segments = ("pelvis", "left thigh")
    lab = laboratory(segments, unworn=("LASI", "RASI", "SACR", "LKNE", "LTHI"), seconds=1.4)
    walks, static = files(tmp_path, lab)
    result = gait_of_files(
        SubjectFiles(walks, static=static, measures=MEASURES, clusters=clusters(segments)), folder=tmp_path / "out",
        settings=GaitSettings(smoothing="none", plate_mm=0),
    )  # fmt: skip
    said = next(f for f in result.figures["findings"] if f["kind"] == "gait_clusters")
    assert said["values"]["segments_list"] == list(segments) and said["values"]["misfit_mm"] < 0.1
    assert "carry pelvis, left thigh" in (tmp_path / "out" / "gait.html").read_text()
    knee = next(row for row in result.figures["uncertainty"] if row["name"] == "LKneeAngles")["by_cause"]
    assert 1 < knee["soft tissue"][0] < 5 and knee["placement"][0] > 0.5


def test_an_exchanged_pair_in_a_cluster_is_told(tmp_path):
    lab = laboratory()
    walks, static = files(tmp_path, lab)
    wrong = {**clusters(), "left thigh": ("LTH2", "LTH1", "LTH3", "LTH4")}
    paths = {"LTH1": "LTH2", "LTH2": "LTH1"}
    moved = replace(
        lab.walk.trajectories,
        paths=tuple(replace(p, name=paths.get(p.name, p.name)) for p in lab.walk.trajectories.paths),
    )
    write_c3d(walks[0], replace(lab.walk, trajectories=moved))
    files_of = SubjectFiles(walks, static=static, measures=MEASURES, clusters=wrong)
    result = gait_of_files(files_of, folder=tmp_path / "out", settings=GaitSettings(uncertainty=False))
    loose = [f["values"]["segment"] for f in result.figures["findings"] if f["kind"] == "gait_cluster_loose"]
    assert loose == ["left thigh"]


@pytest.mark.parametrize(
    ("stated", "says"),
    [
        ({"left thigh": ("LTH1", "LTH2")}, "wanted 3 or more"),
        ({"left thigh": ("LTH1", "LTH2", "Nobody")}, "no Nobody"),
        ({"thigh": ("LTH1", "LTH2", "LTH3")}, "none of pelvis"),
        ({"left thigh": ("LTH1", "LTH2", "LTH3"), "left shank": ("LTH3", "LSK1", "LSK2")}, "two clusters"),
    ],
)
def test_a_cluster_that_cannot_be_is_refused_in_words(tmp_path, stated, says):
    walks, static = files(tmp_path, laboratory(unworn=()))
    with pytest.raises(KinemarkError, match=says):
        gait_of_files(SubjectFiles(walks, static=static, measures=MEASURES, clusters=stated), folder=tmp_path / "out")


def test_a_walk_that_lacks_landmarks_of_segments_without_a_cluster_is_told_which(tmp_path):
    """Where names do not tell either: markers of the left thigh and the right shank are Q1 to Q8 here."""
    lab = laboratory(unworn=("LASI", "RASI", "SACR", "LKNE", "RANK", "RHEE"), seconds=1.0)
    blind = {f"{plate}{k}": f"{plate[1]}Q{k}" for plate in ("LTH", "RSK") for k in (1, 2, 3, 4)}
    walks, static = files(tmp_path, replace(lab, walk=called(lab.walk, blind), static=called(lab.static, blind)))
    some = clusters(("pelvis", "left shank", "right thigh"))
    with pytest.raises(KinemarkError, match="Clusters are stated of pelvis, left shank, right thigh alone") as told:
        gait_of_files(SubjectFiles(walks, static=static, measures=MEASURES, clusters=some), folder=tmp_path / "out")
    assert "(left thigh: LKNE; right shank: RANK; right foot: RHEE)" in str(told.value)
    assert '--cluster "left thigh=A,B,C"' in str(told.value)


def test_clusters_want_a_standing_trial_and_are_not_plug_in_gaits(tmp_path):
    walks, static = files(tmp_path, laboratory(unworn=()))
    with pytest.raises(KinemarkError, match="standing trial"):
        gait_of_files(SubjectFiles(walks, measures=MEASURES, clusters=clusters()), folder=tmp_path / "out")
    with pytest.raises(KinemarkError, match="Plug-in Gait has no clusters"):
        gait_of_files(
            SubjectFiles(walks, static=static, measures=MEASURES, clusters=clusters()), folder=tmp_path / "out",
            settings=GaitSettings(method="plug_in_gait", uncertainty=False),
        )  # fmt: skip


def test_skin_under_clusters_makes_the_errors_that_are_stated():
    """Against draws: all markers of a cluster together by 5 mm along each axis of the segment, each besides by half."""
    segments = ("left thigh", "left shank")
    lab, used = laboratory(segments, unworn=("LKNE", "LTHI", "LTIB", "LANK"), seconds=1.0), clusters(segments)
    stood = marker_points(lab.static)
    walk = with_landmarks(standard_trial(lab.walk, turn=np.eye(3)), stood, used).trial
    errors = GaitErrors(placement_mm=0, hip_mm=0, width_mm=0, plate_mm=0, tissue_mm=5.0, draws=0)
    known = with_static_offsets(MEASURES, stood, flat_foot=True)
    stated = gait_uncertainty(walk, MEASURES, method=EXACT, errors=errors, static=stood, clusters=used)["soft tissue"]
    body = calibrated_body(with_wands(stood), known, used)
    points, rng, off = marker_points(walk), np.random.default_rng(3), []
    for _ in range(80):
        moved = dict(points)
        for segment, markers in used.items():
            R, together = getattr(lab.limbs.left, segment.split()[1]).R, 5.0 * rng.normal(size=3)
            moved |= {name: points[name] + R @ (together + 2.5 * rng.normal(size=3)) for name in markers}
        found = clinical_angles(body.limbs(moved, known, hip_centre="davis"))["LKneeAngles"]
        off.append(found - lab.signals["LKneeAngles"].values)
    seen, said = np.sqrt(np.mean(np.square(off), axis=(0, 1))), np.sqrt(np.mean(stated["LKneeAngles"] ** 2, axis=0))
    np.testing.assert_allclose(said, seen, rtol=0.2)


def test_the_command_reads_clusters_and_says_what_it_does_not_understand(tmp_path, capsys):
    walks, static = files(tmp_path, laboratory(("left thigh",), unworn=("LKNE", "LTHI"), seconds=1.4))
    call = ["gait", str(walks[0]), "--static", str(static), "--no-uncertainty", "--output", str(tmp_path / "out")]
    app([*call, "--cluster", "left_thigh=LTH1, LTH2,LTH3,LTH4"], result_action="return_value")
    assert "carry left thigh" in capsys.readouterr().out
    with pytest.raises(KinemarkError, match="left thigh=A,B,C"):
        app([*call, "--cluster", "left thigh"], result_action="return_value", exit_on_error=False)
