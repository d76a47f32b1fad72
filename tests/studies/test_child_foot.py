"""The child's foot: markers are as far apart as the study says, and at 100 Hz each keeps its identity."""

import numpy as np
import pytest

from kinemark.synth import observe
from kinemark.synth.score import score
from kinemark.track.simultaneous import track_detections
from support.studies import STUDIES


@pytest.fixture(scope="module")
def study():
    """The study as a module."""
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(STUDIES))
        import child_foot

        yield child_foot


def test_the_grid_has_the_pitch_of_the_question(study):
    subject = study.child(0.2, 50.0)
    grid = [k for k, name in enumerate(subject.names) if name.startswith("LF") or name == "LTOE"]
    apart = np.linalg.norm(subject.xyz[grid][:, None] - subject.xyz[grid], axis=-1)
    nearest = np.where(np.eye(len(grid), dtype=bool)[..., None], np.inf, apart).min(1)
    np.testing.assert_allclose(nearest, study.PITCH_MM, rtol=1e-9)


def test_at_100_hz_every_marker_of_the_foot_keeps_its_identity(study):
    subject, rig = study.child(0.4, 100.0), study.cameras(2.5)
    seen = observe(rig, subject, noise_px=0.1, merge_px=2.5)
    result = score(track_detections(seen.detections, rig), subject.xyz, within=study.WITHIN)
    assert result.swaps == 0 and result.recall > 0.97
