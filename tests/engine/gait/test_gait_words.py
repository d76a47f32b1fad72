"""What the gait report says of its method, its subject and its strides, in words."""

import pytest

from kinemark.data import Trial, make_finding
from kinemark.engine.gait.files import gait_of_files
from kinemark.engine.gait.settings import GaitSettings
from kinemark.engine.gait.trial_files import SubjectFiles
from kinemark.io.c3d import write_c3d
from kinemark.report.gait_page import consistency_table, model_text
from kinemark.report.words import text_of
from kinemark.synth import walking

QUICK = GaitSettings(uncertainty=False)
LEG = "leg_mm = 890\nknee_mm = 105\nankle_mm = 72\n"


@pytest.fixture
def walk(tmp_path):
    """A simulated walk without plates, and measures."""
    subject = walking(duration_s=5.0, rate=100.0, seed=1)
    write_c3d(tmp_path / "walk.c3d", Trial("walk", subject.trajectories))
    (tmp_path / "anna.toml").write_text(f"mass_kg = 70\n[left]\n{LEG}[right]\n{LEG}", encoding="utf-8")
    return tmp_path


def test_the_page_says_its_method_and_its_subject_in_words(walk):
    settings = GaitSettings(uncertainty=False, hip_centre="harrington", smoothing="none", flat_foot=False)
    found = gait_of_files(SubjectFiles([walk / "walk.c3d"], measures=walk / "anna.toml"), settings=settings)
    page = (found.folder / "gait.html").read_text()
    words = "hip joint centre by Harrington et al. (2007); segments&#39; inertia by Winter (2009); markers not smoothed"
    assert words in page and "feet as they stood" in page and "hip_centre" not in page
    assert "Body mass 70.0\u00a0kg" in page and "left, or whole" not in page
    assert "left pelvic obliquity" in page and 'href="#profile"' not in page
    plug_in = {"method": {"name": "plug_in_gait", "flat_foot": True, "axes": False}}
    assert model_text(plug_in) == (
        "as Plug-in Gait computes it; feet flat in the standing trial; axes of knees and ankles by wands and measures"
    )


def test_one_stride_of_a_side_is_one_and_tells_nothing_of_consistency(walk):
    figures = gait_of_files(SubjectFiles([walk / "walk.c3d"], measures=walk / "anna.toml"), settings=QUICK).figures
    assert len(consistency_table(figures).rows) > 4
    one = figures | {"curves": [curve | {"strides": 1} for curve in figures["curves"]]}
    assert not consistency_table(one).rows and "several walks" in consistency_table(one).absent
    statement = {"left_strides": 1, "speed": 1.2, "cadence": 110.0}
    for n, words in ((1, "1 left and 1 right stride,"), (2, "1 left and 2 right strides,")):
        assert words in text_of(make_finding("gait_measured", right_strides=n, **statement).as_dict())
