"""Gait of one of several subjects in a file."""

from dataclasses import replace

import pytest

from kinemark.data import KinemarkError, MarkerTrajectory, Trial
from kinemark.engine.gait.files import gait_of_files
from kinemark.engine.gait.settings import GaitSettings
from kinemark.engine.gait.trial_files import SubjectFiles
from kinemark.io.c3d import write_c3d
from kinemark.synth import walking

QUICK = GaitSettings(uncertainty=False)


def speeds(folder, subject):
    """Mean speed, mm/s, of both sides of a subject in the file."""
    settings = replace(QUICK, subject=subject)
    found = gait_of_files(SubjectFiles([folder / "both.c3d"]), settings=settings, folder=folder / subject)
    return [found.figures["time_distance"][side]["speed"]["mean"] for side in ("left", "right")]


@pytest.fixture
def both(tmp_path):
    """Two people who walk beside each other, the second half as large again, of whom one lacks her left toe."""
    one = walking(duration_s=4.0, rate=50.0, seed=1).trajectories
    paths = [
        MarkerTrajectory.measured(f"{who}:{path.name}", size * path.xyz + [0, aside, 0])
        for who, size, aside in (("Ann", 1.0, 0), ("Ben", 1.5, 4000))
        for path in one
        if (who, path.name) != ("Ben", "LTOE")
    ]
    write_c3d(tmp_path / "both.c3d", Trial("both", replace(one, paths=tuple(paths))))
    return tmp_path


def test_whose_gait_is_wanted_must_be_said(both):
    """It was the last subject's, and what they lacked the first one's, without a word."""
    with pytest.raises(KinemarkError, match=r"both: The markers of 2 subjects are there: Ann, Ben\. .*--subject Ben"):
        gait_of_files(SubjectFiles([both / "both.c3d"]), settings=QUICK)
    with pytest.raises(KinemarkError, match=r"'Cleo' is none of them"):
        gait_of_files(SubjectFiles([both / "both.c3d"]), settings=replace(QUICK, subject="Cleo"))


def test_the_gait_is_that_of_the_subject_alone(both):
    write_c3d(both / "ann.c3d", Trial("ann", walking(duration_s=4.0, rate=50.0, seed=1).trajectories))
    alone = gait_of_files(SubjectFiles([both / "ann.c3d"]), settings=QUICK).figures["time_distance"]
    assert speeds(both, "ann") == pytest.approx([alone[side]["speed"]["mean"] for side in ("left", "right")], rel=1e-3)
    with pytest.raises(KinemarkError, match=r"wants the markers LTOE"):  # which are not Ann's
        speeds(both, "Ben")
