"""One declaration checks dtypes, shapes and indices, and its messages say what was found and wanted."""

import numpy as np
import pytest

from kinemark.native.array_checks import FLOAT, GREY, INT, Arrays, index

ARRAYS = Arrays(x=(FLOAT, 3, "n"), row=(index("D", none=True), "n"), uv=(FLOAT, "D", 2))


def call(x=((0.0,) * 4,) * 3, row=(0, 1, -1, 4), uv=((0.0, 0.0),) * 5):
    arrays = ARRAYS(np.array(x), np.array(row), np.array(uv))
    ARRAYS.check_indices(arrays)
    return arrays


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"x": np.zeros((2, 4))}, r"x has shape \(2, 4\), wanted \(3, n\)"),
        ({"x": np.zeros(3)}, r"x has shape \(3,\), wanted \(3, n\)"),
        ({"row": [0, 1]}, r"row has shape \(2,\), wanted \(n,\), n = 4"),
        ({"row": [0.0, 1.0, 2.0, 3.0]}, "row has dtype float64, wanted int64"),
        ({"x": np.zeros((3, 4), complex)}, "x has dtype complex128, wanted float64"),
        ({"row": [0, 1, 5, 0]}, r"row has the index 5, wanted -1 … 4"),
        ({"row": [0, 1, -2, 0]}, r"row has the index -2, wanted -1 … 4"),
        ({"uv": np.zeros((0, 2))}, r"row has the index 0, wanted -1 … -1"),
    ],
)
def test_what_is_wrong_is_said(wrong, message):
    call()
    with pytest.raises(ValueError, match=message):
        call(**wrong)


def test_numbers_are_cast_where_nothing_is_lost_and_laid_out_in_order():
    given = np.arange(12, dtype=np.float32).reshape(4, 3).T
    x, row, _ = call(x=given, row=np.array([0, 1, 2, 3], np.int8))
    assert x.dtype == np.float64 and row.dtype == np.int64 and x.flags.c_contiguous
    np.testing.assert_array_equal(x, given)


def test_arrays_that_fit_are_not_copied():
    y = np.arange(5)
    assert Arrays(y=(INT, "n"))(y)[0] is y


def test_images_keep_their_depth():
    grey = Arrays(images=(GREY, "H", "W"))
    assert [grey(np.zeros((2, 2), t))[0].dtype for t in ("u1", "u2", ">u2")] == [np.uint8, np.uint16, np.uint16]
    with pytest.raises(ValueError, match="images has dtype int16, wanted uint8 or uint16"):
        grey(np.zeros((2, 2), np.int16))
