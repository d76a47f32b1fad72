"""Names of walks that lack the landmarks of their standing trial, by the clusters that the session states."""

from types import SimpleNamespace

import numpy as np
import pytest

from kinemark.data import KinemarkError, MarkerTrajectory, Trajectories, Trial
from kinemark.data.subject_measures import LegMeasures, SubjectMeasures
from kinemark.engine.clusters_said import clusters_of
from kinemark.engine.naming.labelled_trials import set_of_clusters
from kinemark.engine.naming.subject_templates import Known, subject_template
from kinemark.engine.naming.template_files import save_template
from kinemark.engine.naming.templates import session_template
from kinemark.engine.settings.tables import GaitTable
from kinemark.gait.clusters import SEGMENTS
from kinemark.io.trial import write_trial
from kinemark.label import Labelling, label
from kinemark.synth import WalkingBody

LEG = LegMeasures(leg_mm=860.0, knee_mm=101.0, ankle_mm=70.0)
LANDMARKS = ("LASI", "RASI", "SACR", *(s + n for s in "LR" for n in ("THI", "KNE", "TIB", "ANK", "HEE", "TOE")))
SHORT = {"pelvis": "PV", "thigh": "TH", "shank": "SK", "foot": "FT"}
CLUSTERS = {
    segment: tuple(
        f"{'' if segment == 'pelvis' else segment[0].upper()}{SHORT[segment.split()[-1]]}{k}" for k in (1, 2, 3, 4)
    )
    for segment in SEGMENTS
}


@pytest.fixture(scope="module")
def session(tmp_path_factory):
    """A folder with a labelled standing trial, and the tracks of a walk in clusters alone, without names."""
    body, rng = WalkingBody(SubjectMeasures(LEG, LEG), plated=SEGMENTS, unworn=LANDMARKS, worn=("KNM", "MED")), 3
    rng, folder = np.random.default_rng(rng), tmp_path_factory.mktemp("cast")
    still = body.markers(body.standing(20), walking=False)
    write_trial(Trial("stand", trajectories(still, rng)), folder / "stand.c3d")
    walk = body.markers(body.limbs(np.arange(0.0, 1.2, 0.03)))
    order = rng.permutation(list(walk))
    tracks = trajectories({f"*{k}": walk[name] for k, name in enumerate(order, 1)}, rng)
    return folder, tracks, {f"*{k}": str(name) for k, name in enumerate(order, 1)}


def trajectories(points, rng):
    return Trajectories(
        tuple(MarkerTrajectory.measured(n, x + rng.normal(0, 0.4, x.shape)) for n, x in points.items()), 33.3
    )


def named(session, gait):
    """Tracks with a sure name: those that have the right one, and those that have not."""
    folder, tracks, truth = session
    settings = SimpleNamespace(label=Labelling(static=("stand.c3d",)), marker_set=None, gait=gait)
    labels = label(tracks, session_template(folder, settings, ()).template)
    sure = [t for t, state in enumerate(labels.state) if state == "sure"]
    right = sum(labels.names[t] == truth[tracks.names[t]] for t in sure)
    return right, len(sure) - right


def test_a_walk_in_clusters_is_named_by_its_standing_trial_with_landmarks(session):
    right, wrong = named(session, GaitTable(clusters={k.replace(" ", "_"): v for k, v in CLUSTERS.items()}))
    assert (right, wrong) == (28, 0)


def test_segments_are_of_clusters_and_landmarks_that_were_shown():
    shown = ("PV1", "PV2", "PV3", "PV4", "LASI", "knee outer", "LTH1", "LTH2", "LTH3", "LTH4", "C7", "*1")
    found = set_of_clusters(CLUSTERS, shown, markers={"LKNE": "knee outer"})
    assert found.names == shown[:-1]
    assert dict(found.segments) == {
        "pelvis": ("PV1", "PV2", "PV3", "PV4", "LASI"),
        "left thigh": ("LTH1", "LTH2", "LTH3", "LTH4", "knee outer"),
    }
    assert set_of_clusters(CLUSTERS, ("LASI", "RASI", "LKNE")) is None


def test_segments_are_the_same_with_the_subject_before_all_names_and_with_landmarks_that_gait_knows_by_others():
    shown = ("PV1", "PV2", "PV3", "PV4", "LASIS", "LTH1", "LTH2", "LTH3", "LTH4", "Left knee")
    plain = set_of_clusters(CLUSTERS, shown, markers={"LKNE": "Left knee"})
    assert plain.segments["pelvis"][-1] == "LASIS" and plain.segments["left thigh"][-1] == "Left knee"
    other = set_of_clusters(CLUSTERS, [f"Ann:{name}" for name in shown], markers={"LKNE": "Left knee"})
    assert other.names == tuple(f"Ann:{name}" for name in shown)
    assert dict(other.segments) == {k: tuple(f"Ann:{m}" for m in own) for k, own in plain.segments.items()}


def test_a_file_is_named_by_a_standing_trial_and_the_clusters_that_the_command_states(session):
    folder, tracks, truth = session
    said = clusters_of([f"{segment.title()}={','.join(own)}" for segment, own in CLUSTERS.items()])
    assert said == CLUSTERS
    right = {}
    for clusters in ({}, said):
        template = subject_template([folder / "stand.c3d"], Known(static=True, clusters=clusters)).template
        labels = label(tracks, template)
        sure = [t for t, state in enumerate(labels.state) if state == "sure"]
        right[len(clusters)] = [labels.names[t] == truth[tracks.names[t]] for t in sure]
    assert right[len(said)] == [True] * 28 and sum(right[0]) < 28


@pytest.mark.parametrize(
    ("known", "words"),
    [
        (Known(clusters=CLUSTERS), "--static"),
        (Known(static=True, markers=("LASI",), clusters=CLUSTERS), "neither --marker-set nor --markers"),
        (Known(static=True, clusters={"left thigh": ("A", "B", "C")}), "no cluster as a whole, of A, B, C: it has"),
        (
            Known(static=True, clusters=CLUSTERS | {"left foot": ("LFT1", "LFT2", "FT3")}),
            "no FT3, of --cluster: it has",
        ),
    ],
)
def test_clusters_that_tell_nothing_are_refused_in_words(session, known, words):
    with pytest.raises(KinemarkError, match=words):
        subject_template([session[0] / "stand.c3d"], known)


def test_clusters_are_refused_where_no_static_trial_is_looked_at(session, tmp_path):
    known, kept = Known(static=True, clusters=CLUSTERS), tmp_path / "ann.template.h5"
    save_template(kept, subject_template([session[0] / "stand.c3d"], known))
    for files in ([], [kept]):
        with pytest.raises(KinemarkError, match="nor a template that was kept"):
            subject_template(files, known)


def test_a_cluster_on_no_segment_is_refused():
    with pytest.raises(KinemarkError, match="'left ear', which is none of pelvis"):
        clusters_of(["left ear=A,B,C"])


@pytest.mark.parametrize(
    ("said", "words"),
    [
        (["left thigh=A,B,C", "Left_thigh=D,E,F"], "left thigh twice"),
        (["left thigh=A,B,C", "right thigh=A,D,E"], "A twice"),
        (["left thigh=A,B,B"], "B twice"),
        (["left thigh=A,,B"], "'left thigh=A,,B' is not understood"),
        (["left thigh=,"], "is not understood"),
    ],
)
def test_what_is_said_twice_or_not_at_all_is_refused(said, words):
    with pytest.raises(KinemarkError, match=words):
        clusters_of(said)
