"""The study of gait against OpenSim and against bone pins still prints the figures that the documentation quotes."""

from support.shared import shared_data
from support.studies import figures, printed


def test_opensim_and_pins():
    for path in ("opensim_gait", "bone_truth"):
        shared_data(f"mocap3d/{path}")
    text = printed("gait_references")
    for side in ("left", "right"):
        for name, least in (("hip flexion", 0.98), ("knee flexion", 0.98), ("ankle dorsiflexion", 0.75)):
            span, offset, rms, r = figures(text, f"{side} {name}")
            assert r > least and rms < 4.5 and abs(offset) < 7 and span > 18
        for name, least, most in (("knee extension", 0.85, 0.2), ("ankle plantarflexion", 0.99, 0.08)):
            _, offset, rms, r = figures(text, f"{side} {name}")
            assert r > least and rms < most and abs(offset) < 0.2
    back = text.split("-30 mm forward")[1]
    assert all(figures(back, f"{side} hip extension")[3] > 0.88 for side in ("left", "right"))
    for name in ("flexion", "adduction", "rotation"):
        span, mean, sd, rms, stated, held = figures(text.split("bone_truth")[1], name)
        assert (
            held >= 95 and rms < 4 and span > 6 and abs(rms**2 - mean**2 - sd**2) < 0.6 and 0.75 < stated / rms < 1.35
        )
