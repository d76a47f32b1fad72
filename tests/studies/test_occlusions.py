"""The study of occlusions hides what it says, and tells right identities from wrong ones."""

import numpy as np
import occlusions as study
import pytest


def walker(study, rate=50.0):
    subject = study.walking(duration_s=5.0, rate=rate, speed_mm_s=800.0, wobble_mm=3.0, seed=1)
    return study.Walk(
        "walk", subject, study.SessionTemplate(study.learn_template(subject.trajectories), ("own",)), 0.1, 4
    )


def test_hidden_markers_are_seen_by_no_camera_and_by_all_others_before_and_after():
    walk = walker(study)
    gone = study.occlusions(walk.subject, 3)
    assert {one.seconds for one in gone} <= set(study.LENGTHS) and len({one.first for one in gone}) > 3
    rig = study.rig_about(walk.subject, 4)
    left = study.hidden(walk, rig, gone, 3)
    whole = study.hidden(walk, rig, [], 3)
    uv = study.observe(rig, walk.subject, noise_px=0.0).detections.uv
    assert len(left) < len(whole) and np.isfinite(uv).all()
    for one in gone:
        assert walk.subject.rate * one.seconds == pytest.approx(one.stop - one.first)
        others = [o for o in gone if o.marker == one.marker and o != one]
        assert all(o.first >= one.stop + 25 or o.stop <= one.first - 25 for o in others)


def test_identities_are_judged_by_what_is_before_and_after():
    assert study.going_on({1: 5, 2: 6}, 1, 5) == "right"
    assert study.going_on({1: 5, 2: 6}, 1, 6) == "wrong"
    assert study.going_on({2: 5}, 1, 5) == "wrong"
    assert study.going_on({2: 6}, 1, 5) == "none"
    assert study.commonest(np.array([3, 4, 4])) == 4 and study.commonest(np.array([])) is None


def test_a_walk_is_named_rightly_after_its_occlusions():
    seen = study.judged(walker(study), 4)
    assert len(seen) > 8
    assert [one.names for one in seen].count("wrong") == 0
    assert [one.tracker for one in seen].count("wrong") == 0
    assert [one.names for one in seen].count("right") >= 0.9 * len(seen)
