"""The study of real upper limbs still prints the figures that the documentation quotes."""

from support.shared import shared_data
from support.studies import figures, printed


def test_ulema_bone_and_box():
    for path in ("ulema_hand_to_head", "bone_truth", "arm_box_lift_gaps"):
        shared_data(f"mocap3d/{path}")
    text = printed("upper_limb")
    for name in ("LElbowFlExt ", "LElbowProSupination ", "LShoulderElevationH1 ", "LWristFlExt ", "LWristDeviation "):
        _, r, offset, rms, own_r, own_offset, own_rms = figures(text, name)
        assert r > 0.99999 and abs(offset) < 0.01 and rms < 0.01
        assert own_r > 0.9999 and abs(own_offset) < 0.1 and own_rms < 0.1
    r, offset, rms = figures(text, "UM2AS model LElbowFlExt")
    assert r > 0.996 and 5 < offset < 10 and rms < 2.5
    bone = text.split("bone_truth")[1]
    for name, most in (("plane of elevation", 6), ("minus elevation", 15), ("internal rotation", 7)):
        span, mean, sd, rms, trembling, misfit = figures(bone, name)[:6]
        assert abs(rms**2 - mean**2 - sd**2) < 0.1 and rms < most and trembling < 0.05 < misfit
        assert 1 < misfit < 6 and span > 25
    assert figures(bone, "the arm hangs in gimbal lock in")[0] > 200
    scapula, predicted, humerus, own = figures(bone, "rotation from bone, RMS deg: scapula")
    assert scapula > 2 * predicted and humerus < 3 * own
    bare, carried = figures(text, "elbow flexion")[:2]
    assert (bare, carried) == (551, 580)
    assert figures(text, "wrist ulnar deviation")[:2] == [531, 580]
