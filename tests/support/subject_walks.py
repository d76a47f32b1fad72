"""Simulated walks of one subject, and the template that is learnt from the first."""

from functools import cache

from kinemark.label import learn_template
from kinemark.synth import walking, with_markers


@cache
def walk(seed, n=15):
    """Three seconds of n markers at 100 Hz."""
    return with_markers(walking(duration_s=3.0, rate=100.0, seed=seed, wobble_mm=1.0), n, seed=1).trajectories


@cache
def template(n=15):
    return learn_template(walk(1, n))
