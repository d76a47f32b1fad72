"""No input crashes a function of `native`: compiled code and NumPy refuse the same, and else give the same."""

import inspect

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from kinemark import native
from support.examples import examples
from support.native_calls import CALLS, WRONGS, outcome, wrong

seeds = st.integers(0, 2**32 - 1)
wrongs = st.lists(st.sampled_from(WRONGS), max_size=2)


def plainly(call):
    """The outcome with NumPy alone."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(native.PLAIN, "1")
        return outcome(call)


def settled(name, found, expected):
    """Both results, without points whose images are those of no point, and patches that show no such shape.

    Their places are nothing but rounding, and where ten tries have led.
    """
    if name not in ("intersect", "fit_shapes") or expected is None or found is None:
        return found, expected
    if name == "fit_shapes":
        close = (expected[1] < 1e3) & np.isfinite(expected[3]).all((1, 2))
        return [array[close] for array in found], [array[close] for array in expected]
    close = expected[2].max(0, initial=0.0) < 1e3
    return [array[..., close] for array in found], [array[..., close] for array in expected]


def assert_same(found, expected):
    """Equal whole numbers; equal others to rounding, and not finite in the same places."""
    assert (found is None) == (expected is None)
    for one, other in zip(found or (), expected or (), strict=True):
        assert one.shape == other.shape and one.dtype == other.dtype
        finite = np.isfinite(other)
        np.testing.assert_array_equal(np.isfinite(one), finite)
        size = np.abs(other[finite]).max(initial=0.0)
        np.testing.assert_allclose(one[finite], other[finite], rtol=1e-6, atol=1e-9 * size)


def test_every_function_is_fuzzed():
    functions = {name for name in native.__all__ if inspect.isfunction(getattr(native, name))}
    assert functions - {"library", "status", "inverse"} <= set(CALLS)


@pytest.mark.parametrize("name", CALLS)
@settings(max_examples=examples(150))
@given(seeds, wrongs)
def test_compiled_and_numpy_agree_whatever_they_are_given(name, seed, ways):
    rng = np.random.default_rng(seed)
    call = wrong(CALLS[name](rng), ways, rng)
    assert_same(*settled(name, outcome(call), plainly(call)))


@pytest.mark.parametrize("name", CALLS)
@settings(max_examples=examples(30))
@given(seeds)
def test_right_calls_are_not_refused(name, seed):
    """So that the law above is not true for want of anything that is computed."""
    call = CALLS[name](np.random.default_rng(seed))
    wild = {"most": -1}.items() & call.parameters.items()
    frames = call.parameters.get("height", 1), call.parameters.get("width", 1)
    if not wild and name != "group_runs":
        assert outcome(call) is not None
    elif name == "group_runs" and all(0 < n < 1000 for n in frames):
        assert outcome(call) is not None or call.arrays["last"].max() >= frames[1]


@pytest.mark.parametrize("plain", ["", "1"])
@pytest.mark.parametrize("name", CALLS)
def test_arrays_of_other_shapes_are_refused(monkeypatch, plain, name):
    """Compiled code once read beyond such arrays, and the process ended."""
    monkeypatch.setenv(native.PLAIN, plain)
    rng = np.random.default_rng(7)
    call = CALLS[name](rng)
    for changed, array in call.arrays.items():
        for other in (array[..., None], array[None], array.reshape(-1)[None, None]):
            if other.ndim != array.ndim:
                with pytest.raises(ValueError, match=f"{changed} has shape|first must rise"):
                    call._replace(arrays=call.arrays | {changed: other})()
