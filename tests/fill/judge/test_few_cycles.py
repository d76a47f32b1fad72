"""Trials of a few cycles: the gap hides from its hold-out gaps the cycle that it is itself filled from."""

import numpy as np

from kinemark.fill import FILL, Gap, MarkerArray
from kinemark.fill.fill import evaluate_candidates
from kinemark.fill.judge.choice import choose_candidate
from kinemark.fill.reference_ranking import ranked
from kinemark.synth import walking, with_markers


def test_the_error_of_the_next_cycle_is_not_that_of_another_movement():
    subject = with_markers(walking(duration_s=2.9, rate=100.0, wobble_mm=1.0, seed=3), 16, seed=3)
    noise = np.random.default_rng(3).normal(0, 0.3, subject.xyz.shape)
    motion = MarkerArray(subject.xyz + noise, 100.0, subject.names)
    ratios = []
    for marker in (0, 9, 12):
        gaps = [Gap(k, 120, 170) for k in (marker, *ranked(motion, marker)[:4].tolist())]
        hidden = motion.hidden(gaps)
        answers = evaluate_candidates(hidden, gaps, [FILL.make("cyclic")])
        found, prediction, _ = choose_candidate(hidden, gaps, 0, answers)
        error = np.linalg.norm(prediction.xyz - motion.xyz[marker, 120:170], axis=1).mean()
        ratios.append(found.expected_mm / error)
        assert max(r.mean for r in answers[0].results if r.test.of == 0) > 8 * error  # another part of the stride
    assert all(0.5 < ratio < 2 for ratio in ratios)
