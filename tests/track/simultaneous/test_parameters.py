"""Every legal parameter of the tracker works over its whole range."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from kinemark.data.method import parameters_of
from kinemark.track.simultaneous import Simultaneous, ambiguous_decisions, track_simultaneously
from support.laboratory import observe, ring
from support.motions import dance

RIG = ring(4)
DETECTIONS, _ = observe(RIG, dance(n=5, frames=30), noise=0.2)
BLINKING = DETECTIONS.keep(DETECTIONS.frame % 9 != 4)
NUMBERS = [p.name for p in parameters_of(Simultaneous) if isinstance(p.default, float)]


def sound(method):
    """The tracks, which are sound whatever the method finds."""
    result = track_simultaneously(BLINKING, RIG, method)
    ambiguous_decisions(result, method)
    tracks = result.tracks
    pairs = np.column_stack([tracks.id, tracks.cloud.frame])
    assert len(np.unique(pairs, axis=0)) == len(pairs), "a track has one point a frame"
    assert np.isfinite(tracks.cloud.xyz).all() and np.isfinite(tracks.cloud.cov).all()
    return tracks


@pytest.mark.parametrize("name", NUMBERS)
@pytest.mark.parametrize("value", [1e-6, 1e-2, 1e6])
def test_each_parameter_far_from_its_default(name, value):
    sound(Simultaneous(**{name: value}))


@settings(max_examples=15)
@given(st.fixed_dictionaries({name: st.floats(-3, 3) for name in NUMBERS}), st.booleans())
def test_parameters_together(powers, learn_motion):
    defaults = {p.name: p.default for p in parameters_of(Simultaneous)}
    sound(
        Simultaneous(
            **{name: defaults[name] * 10.0**power for name, power in powers.items()}, learn_motion=learn_motion
        )
    )
