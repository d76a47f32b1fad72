"""Markers that sit on one segment as their names tell, of a static trial without a marker set or clusters."""

import numpy as np
import pytest

from kinemark.data import MarkerTrajectory, Trajectories, Trial
from kinemark.engine.naming.subject_templates import Known, subject_template
from kinemark.engine.naming.usual_segments import set_of_names
from kinemark.io.marker_sets import read_marker_set
from kinemark.io.trial import write_trial
from kinemark.label import label
from kinemark.synth import walking

ISB = {"KNE": "FLE", "KNM": "FME", "ANK": "FAL", "MED": "TAM", "HEE": "FCC", "TOE": "FM2", "ASI": "IAS", "PSI": "IPS"}


def test_names_of_a_shipped_set_have_its_segments():
    shipped = read_marker_set("plug-in-gait-full")
    found = set_of_names((*shipped.names, "EXTRA", "*12"))
    assert found.names == (*shipped.names, "EXTRA")
    assert {key: set(own) for key, own in found.segments.items()} == {k: set(v) for k, v in shipped.segments.items()}
    assert found.joints == shipped.joints and found.rigidity == shipped.rigidity


def test_landmarks_that_are_called_otherwise_are_on_the_same_segments():
    found = set_of_names([f"{side}_{name}" for side in "LR" for name in (*ISB.values(), "FTC", "SAA")])
    assert set(found.segments["pelvis"]) == {"L_IAS", "L_IPS", "R_IAS", "R_IPS"}
    assert set(found.segments["left thigh"]) == {"L_FLE", "L_FME", "L_FTC"}
    assert set(found.segments["right shank"]) == {"R_FLE", "R_FME", "R_FAL", "R_TAM"}
    assert set(found.segments["left foot"]) == {"L_FAL", "L_TAM", "L_FCC", "L_FM2"}


def test_names_that_are_no_landmarks_tell_nothing():
    assert set_of_names(["M1", "M2", "M3", "M4", "*5"]) is None


@pytest.mark.parametrize("seed", [3, 4])
def test_a_static_trial_with_usual_names_needs_no_marker_set(tmp_path, seed):
    walk = walking(duration_s=2.0, rate=50.0, seed=seed, wobble_mm=1.0).trajectories
    still = Trajectories(tuple(MarkerTrajectory.measured(p.name, p.xyz[:1].repeat(5, 0)) for p in walk), walk.rate)
    write_trial(Trial("still", still), tmp_path / "still.c3d")
    template = subject_template([tmp_path / "still.c3d"], Known(static=True)).template
    order = np.random.default_rng(seed).permutation(len(walk))
    tracks = Trajectories(
        tuple(MarkerTrajectory.measured(f"*{k}", walk.paths[t].xyz) for k, t in enumerate(order)), walk.rate
    )
    found = label(tracks, template)
    right = [name == walk.names[t] for name, t in zip(found.names, order, strict=True)]
    sure = [state == "sure" for state in found.state]
    assert all(good for good, told in zip(right, sure, strict=True) if told) and np.mean(sure) > 0.95
