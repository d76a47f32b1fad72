"""C3D: laws of the three number formats and of the parameter section."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from kinemark.data import same
from kinemark.io.c3d import ByteOrder, Group, Parameter
from kinemark.io.c3d.numbers import decode_floats, encode_floats, float_of_vax, vax_of_float
from kinemark.io.c3d.parameters import decode_parameters, encode_parameters
from support.examples import examples

finite = st.floats(width=32, allow_nan=False, allow_infinity=False, min_value=-(2.0**126), max_value=2.0**126)

# Numbers


@given(hnp.arrays(np.uint32, 20))
def test_vax_bits_come_back(bits):
    exponent, sign = (bits >> 23) & 0xFF, bits >> 31
    back = vax_of_float(float_of_vax(bits))
    assert (back == bits)[exponent >= 3].all()
    assert (back[exponent == 0] == np.where(sign, 1 << 31, 0)[exponent == 0]).all()


@given(hnp.arrays(np.float32, 20, elements=finite))
def test_ieee_numbers_come_back_from_dec(values):
    wanted = np.where(np.abs(values) < 2.0**-128, 0, values)
    assert np.array_equal(float_of_vax(vax_of_float(values)), wanted)


def test_vax_numbers_are_those_of_the_processor():
    raw = np.frombuffer(bytes.fromhex("8040 0000 80c0 0000 4941 db0f 0000 0000 0080 0000"), np.uint8)
    values = decode_floats(raw, ByteOrder.DEC)
    assert np.allclose(values[:4], [1, -1, np.float32(np.pi), 0], rtol=1e-7) and np.isnan(values[4])
    assert encode_floats(values, ByteOrder.DEC).tobytes() == raw.tobytes()


@pytest.mark.parametrize("value", [2.0**127, np.inf, -np.inf])
def test_numbers_beyond_dec_are_refused(value):
    with pytest.raises(ValueError, match="DEC"):
        vax_of_float(np.array([value], np.float32))


# Parameters

shapes = hnp.array_shapes(min_dims=0, max_dims=4, min_side=0, max_side=5)
values = st.one_of(
    hnp.arrays(np.uint8, shapes),
    hnp.arrays(np.int8, shapes),
    hnp.arrays(np.int16, shapes),
    hnp.arrays(np.float32, shapes, elements=finite.filter(lambda x: x == 0 or abs(x) > 2.0**-126)),
)
short = st.text(st.characters(max_codepoint=255), max_size=30)
parameters = st.builds(Parameter, short.filter(bool), values, short, st.booleans())
groups = st.lists(
    st.tuples(short.filter(bool), st.lists(parameters, max_size=4), short, st.booleans()), max_size=4
).map(lambda found: tuple(Group(i + 1, n, tuple(p), d, k) for i, (n, p, d, k) in enumerate(found)))


@given(groups, st.sampled_from(list(ByteOrder)))
@settings(max_examples=examples(60), deadline=None)
def test_parameters_come_back(given_groups, order):
    found, lost, odd = decode_parameters(encode_parameters(given_groups, order), order)
    assert same(found, given_groups) and not lost and not odd


def test_a_dimension_beyond_255_is_refused():
    with pytest.raises(ValueError, match="255"):
        encode_parameters([Group(1, "A", (Parameter.real("B", np.zeros(256)),))], ByteOrder.INTEL)
